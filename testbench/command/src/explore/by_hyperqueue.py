"""Runs the shares of a study by HyperQueue (https://it4innovations.github.io/hyperqueue), from its Python wheel.

Arguments: the folder for what tasks print, how many shares there are, and the command that runs one, in which `{}` stands for
the share's number. If `HQ_SERVER_DIR` names the folder of a server that runs already, tasks go there; else to workers on this
computer, one a core.
"""

import os
import sys

try:
    from hyperqueue import Client, Job, LocalCluster
    from hyperqueue.cluster import WorkerConfig
    from hyperqueue.output import StdioDef
except ImportError:
    sys.exit("error: this Python has no HyperQueue: `python3 -m pip install hyperqueue`")


def run(client):
    log, shares, command = sys.argv[1], int(sys.argv[2]), sys.argv[3:]
    job = Job(max_fails=None, default_workdir=os.getcwd(), name="pellucid")
    for share in range(1, shares + 1):
        job.program(
            [word.replace("{}", str(share)) for word in command],
            stdout=StdioDef(path=None, on_close="rm-if-finished"),
            stderr=StdioDef(path=os.path.abspath(f"{log}/{share}.stderr"), on_close="rm-if-finished"),
            name=f"share {share}",
        )
    return client.wait_for_jobs([client.submit(job)], raise_on_error=False)


def main():
    if server := os.environ.get("HQ_SERVER_DIR"):
        return run(Client(server))
    with LocalCluster() as cluster:
        for _ in range(len(os.sched_getaffinity(0))):
            cluster.start_worker(WorkerConfig(cores=1))
        return run(cluster.client())


sys.exit(0 if main() else 1)

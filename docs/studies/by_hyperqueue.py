#!/usr/bin/env python3
"""Runs the points of a study by HyperQueue (https://it4innovations.github.io/hyperqueue), from its Python wheel alone.

    pip install hyperqueue
    python3 by_hyperqueue.py study.toml points --workers 8

starts a server and workers on this computer. With --server-dir DIR the points go to a server that runs already, whose workers may
be on other computers, come and go. Points are kept in the folder `points`: what was stopped goes on when it is run again, and
`pellucid explore study.toml --points points` shows the front.
"""

import argparse
import os
import sys

from hyperqueue import Client, Job, LocalCluster
from hyperqueue.cluster import WorkerConfig
from hyperqueue.output import StdioDef


def run(client, args):
    job = Job(max_fails=None, default_workdir=os.getcwd(), name=os.path.basename(args.study))
    for share in range(1, args.shares + 1):
        job.program(
            [args.pellucid, "run-point", args.study, "--points", args.points, "--quiet"]
            + ["--share", f"{share}/{args.shares}"],
            stdout=StdioDef.remove_if_finished(),
            stderr=StdioDef.remove_if_finished(),
            name=f"share {share}",
        )
    return client.wait_for_jobs([client.submit(job)], raise_on_error=False)


def main():
    parser = argparse.ArgumentParser(description="Runs the points of a study by HyperQueue.")
    parser.add_argument("study", help="the study, a TOML file")
    parser.add_argument("points", help="the folder for points, seen by all workers")
    parser.add_argument("--shares", type=int, default=64, help="tasks: many more than workers [64]")
    parser.add_argument("--workers", type=int, default=2, help="workers with a core each, on this computer [2]")
    parser.add_argument("--server-dir", help="the folder of a server that runs already, in place of workers here")
    parser.add_argument("--pellucid", default="pellucid", help="the program [pellucid]")
    args = parser.parse_args()
    if args.server_dir:
        done = run(Client(args.server_dir), args)
    else:
        with LocalCluster() as cluster:
            for _ in range(args.workers):
                cluster.start_worker(WorkerConfig(cores=1))
            done = run(cluster.client(), args)
    if not done:
        sys.exit("some shares failed: job-*/*.stderr say why")


if __name__ == "__main__":
    main()

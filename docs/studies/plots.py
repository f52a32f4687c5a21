#!/usr/bin/env python3
"""Draws the results of a study: all designs with the front, and what each parameter does.

    python3 plots.py pellucid-explore cycles.total storage.on_chip_bytes

takes the folder that `pellucid explore` has left and two figures, and writes front.svg and effects.svg there. It needs pandas
and matplotlib.
"""

import json
import sys
from pathlib import Path

import matplotlib
import pandas

matplotlib.use("svg")
from matplotlib import pyplot  # noqa: E402


def label(columns, figure):
    unit = columns[figure]["unit"]
    return f"{figure}, {unit}" if unit else figure


def main():
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    folder, up, across = Path(sys.argv[1]), sys.argv[2], sys.argv[3]
    points = pandas.read_csv(folder / "points.csv", low_memory=False)
    columns = json.loads((folder / "columns.json").read_text())
    for figure in (up, across):
        if figure not in points:
            sys.exit(f"error: `{figure}` is no column of {folder}/points.csv")
    # A design counts if it is right on every scene; its figures are means over scenes.
    right = points.groupby("design").filter(lambda rows: (rows.status == "right").all())
    designs = right.groupby(["design", "arch"], as_index=False)[[up, across]].mean()

    figure, axes = pyplot.subplots()
    for arch, rows in designs.groupby("arch"):
        axes.scatter(rows[across], rows[up], label=arch, s=20)
    best = designs.sort_values([across, up])
    best = best[best[up] < best[up].cummin().shift(fill_value=float("inf"))]
    axes.step(best[across], best[up], where="post", color="grey", linewidth=1)
    axes.set(xlabel=label(columns, across), ylabel=label(columns, up), xscale="log")
    axes.legend()
    figure.savefig(folder / "front.svg", bbox_inches="tight")

    names = [name for name in right.columns if name.startswith("parameter.")]
    varied = [(arch, name) for arch, rows in right.groupby("arch") for name in names if rows[name].nunique() > 1]
    figure, grid = pyplot.subplots(1, max(len(varied), 1), figsize=(4 * max(len(varied), 1), 4), squeeze=False)
    for axes, (arch, name) in zip(grid[0], varied):
        means = right[right.arch == arch].groupby(name)[up].mean()
        axes.plot([str(value) for value in means.index], means, marker="o")
        axes.set(title=f"{arch}: {name.removeprefix('parameter.')}", ylabel=label(columns, up))
        axes.tick_params("x", rotation=45)
    figure.tight_layout()
    figure.savefig(folder / "effects.svg")


if __name__ == "__main__":
    main()

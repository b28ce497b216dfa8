"""Draws the curves of ppo.py: curve.py FOLDER OUT.svg

Return and success of the training's episodes, means of a hundred, for each seed in FOLDER.
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt  # noqa: E402


def main() -> None:
    folder, out = Path(sys.argv[1]), sys.argv[2]
    # The same file from the same figures.
    plt.rcParams["svg.hashsalt"] = "openbench"
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.2), layout="constrained")
    for path in sorted(folder.glob("seed-*.csv")):
        with path.open(newline="") as file:
            rows = list(csv.DictReader(file))
        minutes = [float(row["seconds"]) / 60 for row in rows]
        for axis, key in zip(axes, ("return", "success")):
            axis.plot(minutes, [float(row[key]) for row in rows], label=path.stem)
    for axis, name in zip(axes, ("return", "share of episodes that succeed")):
        axis.set_xlabel("minutes")
        axis.set_title(name, fontsize=10)
        axis.grid(alpha=0.3)
    axes[1].set_ylim(0, 1)
    axes[1].legend()
    figure.savefig(out, metadata={"Date": None})


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""OPEN's deliveries with a wrong map and start, in worlds for tests (docs/tuning.md).

    cargo build --release
    python3 benchmarks/localization/deliveries.py target/release/openbench FOLDER PUBLISHED MODELS

PUBLISHED is the folder that `openbench data pull published` writes, and MODELS has the meshes of
Gazebo. Drawn neighbourhoods are driven with an exact map and start and with wrong ones; in the
published worlds the map is shifted and turned. Runs that are in FOLDER already are used again.
Prints Markdown.
"""

import argparse
import json
import math
import pathlib
import statistics
import subprocess

#: Neighbourhoods like `medium`, one for each seed.
DRAWN_SEEDS = range(11210, 11214)
DRAWN_CONDITIONS = {
    "exact": [],
    "map=city, start=5m": ["map=city", "start=5m"],
}
#: Shifts of maps, one for each seed and published world: standard deviations of an axis and of the
#: rotation, which draw shifts of a few metres and turns of a degree or so.
SHIFT_SEEDS = range(11200, 11208)
SHIFT = ["map.shift_m=2.5", "map.rotation_deg=1"]
#: Draws that count: metres and degrees.
SHIFT_M, ROTATION_DEG = (2.0, 5.0), 2.0


def results(args, name, words):
    """The results of a run, which is made if it was not yet."""
    out = args.folder / name
    path = out / "results.json"
    if not path.exists():
        words = [args.openbench, "run", *words, "--record", "none", "--jobs", "2"]
        words += ["--discard", "--out", str(out)]
        subprocess.run(words, check=True, stdout=subprocess.DEVNULL)
    return json.loads(path.read_text())


def with_conditions(conditions):
    return [word for condition in conditions for word in ("--condition", condition)]


def scores(runs):
    """Means over runs of the strict scores of single deliveries, and of squared pose errors."""
    metrics = [run["metrics"] for run in runs]
    success = 100 * statistics.fmean(one["sr_2m"] for one in metrics)
    path = 100 * statistics.fmean(one["spl"] for one in metrics)
    error = math.sqrt(statistics.fmean(one["localization"]["rmse_m"] ** 2 for one in metrics))
    return f"{success:.1f} % | {path:.1f} % | {error:.2f} m"


def doors_in(truth):
    """Positions in a file of true doors, `(x, y)` on each line."""
    lines = truth.read_text().split("\n")
    return [tuple(map(float, line.strip("() ").split(","))) for line in lines if line.strip()]


def shift_of(run, doors):
    """How far the map is shifted at doors, metres, and turned, degrees."""
    frame = run["drawn_map"]["frame"]
    sine, cosine = math.sin(frame["yaw"]), math.cos(frame["yaw"])
    shifts = []
    for x, y in doors:
        east = cosine * x - sine * y + frame["x"] - x
        north = sine * x + cosine * y + frame["y"] - y
        shifts.append(math.hypot(east, north))
    return statistics.fmean(shifts), math.degrees(abs(frame["yaw"]))


def drawn(args):
    print("| conditions | seeds | SR (strict) | SPL | pose error, RMS |")
    print("|---|---|---:|---:|---:|", flush=True)
    for name, conditions in DRAWN_CONDITIONS.items():
        runs = []
        for seed in DRAWN_SEEDS:
            folder = f"medium-{'-'.join(conditions) or 'exact'}-{seed}"
            words = ["medium", "--seed", str(seed), *with_conditions(conditions)]
            runs.append(results(args, folder, words))
            print(f"| {name} | {seed} | {scores(runs[-1:])} |", flush=True)
        print(f"| {name} | all | {scores(runs)} |", flush=True)


def shifted(args):
    print("| world | seed | map shifted by | turned by | SR (strict) | SPL | pose error, RMS |")
    print("|---|---|---:|---:|---:|---:|---:|", flush=True)
    counted = []
    for world in ["small", "medium"]:
        folder = args.published / world
        truth = next(folder.glob(f"delivery_instructions*gt_{world}.txt"), None)
        truth = truth or folder / f"delivery_instructions_{world}_gt.txt"
        files = {
            "--world": folder / f"{world}_osm.world",
            "--map": folder / f"{world}.osm",
            "--models": args.models,
            "--deliveries": folder / f"delivery_instructions_{world}.txt",
            "--truth": truth,
        }
        words = [str(word) for pair in files.items() for word in pair]
        for seed in SHIFT_SEEDS:
            run = words + ["--seed", str(seed), *with_conditions(SHIFT)]
            run = results(args, f"published-{world}-{seed}", run)
            metres, degrees = shift_of(run, doors_in(truth))
            is_counted = SHIFT_M[0] <= metres <= SHIFT_M[1] and degrees <= ROTATION_DEG
            if is_counted:
                counted.append(run)
            note = "" if is_counted else ", not counted"
            cells = f"{world}{note} | {seed} | {metres:.1f} m | {degrees:.1f}°"
            print(f"| {cells} | {scores([run])} |", flush=True)
    print(f"| all that count | | | | {scores(counted)} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("openbench")
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("published", type=pathlib.Path)
    parser.add_argument("models", type=pathlib.Path)
    args = parser.parse_args()
    shifted(args)
    print()
    drawn(args)


if __name__ == "__main__":
    main()

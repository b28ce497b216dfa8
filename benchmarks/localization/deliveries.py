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
DRAWN_SEEDS = range(11010, 11014)
DRAWN_CONDITIONS = {
    "exact": [],
    "map=city, start=5m": ["map=city", "start=5m"],
}
#: Shifts of maps, one for each seed and published world: standard deviations of an axis and of the
#: rotation, which draw shifts of a few metres and turns of a degree or so.
SHIFT_SEEDS = range(11000, 11008)
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


def spl(one):
    """Success weighted by path length, strict."""
    shortest = one["shortest_path_m"]
    if not one["success_2m"] or shortest is None:
        return 0.0
    longest = max(one["path_m"], shortest)
    return shortest / longest if longest > 0 else 1.0


def scores(runs):
    """Deliveries, successes, SPL and root mean square of pose errors; as in results, without
    deliveries to buildings that the map lacks or misnames."""
    ones = [one for run in runs for one in run["deliveries"]]
    ones = [one for one in ones if (one.get("on_map") or "right") == "right"]
    won = sum(one["success_2m"] for one in ones)
    error = math.sqrt(
        statistics.fmean(run["metrics"]["localization"]["rmse_m"] ** 2 for run in runs)
    )
    share, path = 100 * won / len(ones), 100 * statistics.fmean(map(spl, ones))
    return f"{len(ones)} | {share:.0f} % | {path:.1f} % | {error:.2f} m"


def shift_of(run):
    """How far the map is shifted where parcels were put down, metres, and turned, degrees."""
    frame = run["drawn_map"]["frame"]
    x, y, yaw = frame["x"], frame["y"], frame["yaw"]
    sine, cosine = math.sin(yaw), math.cos(yaw)
    declared = (one["declared_at"] for one in run["deliveries"])
    # If none was put down, at the origin.
    places = [at for at in declared if at is not None] or [{"x": 0.0, "y": 0.0}]
    shifts = []
    for at in places:
        east = cosine * at["x"] - sine * at["y"] + x - at["x"]
        north = sine * at["x"] + cosine * at["y"] + y - at["y"]
        shifts.append(math.hypot(east, north))
    return statistics.fmean(shifts), math.degrees(abs(yaw))


def drawn(args):
    print("| conditions | seeds | deliveries | SR (strict) | SPL | pose error, RMS |")
    print("|---|---|---:|---:|---:|---:|", flush=True)
    for name, conditions in DRAWN_CONDITIONS.items():
        runs = []
        for seed in DRAWN_SEEDS:
            folder = f"medium-{'-'.join(conditions) or 'exact'}-{seed}"
            words = ["medium", "--seed", str(seed), *with_conditions(conditions)]
            runs.append(results(args, folder, words))
            print(f"| {name} | {seed} | {scores(runs[-1:])} |", flush=True)
        print(f"| {name} | all | {scores(runs)} |", flush=True)


def shifted(args):
    print("| world | seed | map shifted by | turned by | deliveries | SR (strict) | SPL | RMS |")
    print("|---|---|---:|---:|---:|---:|---:|---:|", flush=True)
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
            metres, degrees = shift_of(run)
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

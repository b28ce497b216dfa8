#!/usr/bin/env python3
"""What each condition alone does to an agent: a table of its scores at each level.

    cargo build --release
    python3 benchmarks/conditions/table.py target/release/openbench FOLDER small --seeds 10000..10004

Runs that are in FOLDER already are used again, and so are levels whose deliveries are in the file
of --deliveries; those of other levels are added to it. All levels have the same deliveries and
seeds, so `lost` and `won` count deliveries that succeed without the condition and fail with it, or
the other way round. Prints Markdown.
"""

import argparse
import csv
import json
import os
import math
import pathlib
import statistics
import subprocess

#: Levels, each alone; the first one is what they are compared with.
LEVELS = [
    [],
    ["map=good"],
    ["map=city"],
    ["map=poor"],
    ["start=5m"],
    ["start=10m"],
    ["start=block"],
    ["start=map"],
    ["robot=calibrated"],
    ["robot=worn"],
    ["plates=real"],
    ["scenery=varied"],
    ["camera=good"],
    ["camera=cheap"],
    ["light=day"],
    ["light=overcast"],
    ["light=dusk"],
    ["light=night"],
    ["weather=wet"],
    ["weather=rain"],
    ["weather=fog"],
    ["lidar=real"],
    ["compute=charged"],
]


#: What is kept of a delivery.
COLUMNS = {
    "condition": str,
    "seed": int,
    "episode": int,
    "building": str,
    "unit": str,
    "on_map": str,
    "success_2m": lambda text: text == "True",
    "path_m": float,
    "shortest_path_m": lambda text: float(text) if text else None,
    "sim_seconds": float,
    "pose_error_m": lambda text: float(text) if text else None,
    "failure": str,
}


def name_of(conditions):
    return ", ".join(conditions) or "none"


def read(path):
    """The deliveries of a file."""
    with open(path, newline="") as file:
        return [
            {column: kind(row[column]) for column, kind in COLUMNS.items()}
            for row in csv.DictReader(file)
        ]


def write(path, deliveries):
    """Writes deliveries to a file, whole or not at all."""
    staged = path.with_suffix(".part")
    with open(staged, "w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(deliveries)
    os.replace(staged, path)


def run(args, conditions):
    """The deliveries of all seeds with these conditions."""
    folder = "-".join(conditions).replace("=", "-") or "off"
    out = args.folder / folder
    words = [args.openbench, "run", args.suite, "--agent", args.agent, "--seeds", args.seeds]
    words += ["--jobs", str(args.jobs), "--record", "none", "--out", str(out)]
    for setting in args.set:
        words += ["--set", setting]
    for condition in conditions:
        words += ["--condition", condition]
    subprocess.run(words, check=True, stdout=subprocess.DEVNULL)
    deliveries = []
    for path in sorted(out.glob("seed-*/results.json")):
        results = json.loads(path.read_text())
        known = {"condition": name_of(conditions), "seed": results["seed"], "on_map": "right"}
        for one in results["deliveries"]:
            one = known | {key: value for key, value in one.items() if value is not None}
            deliveries.append({column: rounded(one.get(column)) for column in COLUMNS})
    return deliveries


def rounded(value):
    """Millimetres and milliseconds are enough."""
    return round(value, 3) if isinstance(value, float) else value


def by_task(deliveries):
    """Deliveries by seed, episode and address."""
    return {
        (one["seed"], one["episode"], one["building"], one["unit"] or ""): one for one in deliveries
    }


def spl(one):
    """Success weighted by path length, strict."""
    shortest = one["shortest_path_m"]
    if not one["success_2m"] or shortest is None:
        return 0.0
    longest = max(one["path_m"], shortest)
    return shortest / longest if longest > 0 else 1.0


def wilson(successes, trials):
    """95 % interval of a share (Wilson 1927)."""
    z, share = 1.959964, successes / trials
    middle = (share + z * z / (2 * trials)) / (1 + z * z / trials)
    spread = math.sqrt(share * (1 - share) / trials + z * z / (4 * trials * trials))
    half = z * spread / (1 + z * z / trials)
    return middle - half, middle + half


def row(conditions, deliveries, plain):
    # As in results: without deliveries to buildings that the public map lacks or misnames.
    unmapped = [one for one in deliveries if one["on_map"] != "right"]
    ones = [one for one in deliveries if one["on_map"] == "right"]
    won = [one["success_2m"] for one in ones]
    low, high = wilson(sum(won), len(won))
    errors = [one["pose_error_m"] for one in ones if one["pose_error_m"] is not None]
    before = [
        (plain[task]["success_2m"], one["success_2m"]) for task, one in by_task(ones).items()
    ]
    causes = {}
    for one in ones:
        if one["failure"]:
            causes[one["failure"]] = causes.get(one["failure"], 0) + 1
    cells = [
        name_of(conditions),
        str(len(ones)),
        f"{100 * sum(won) / len(won):.0f} % ({100 * low:.0f}-{100 * high:.0f})",
        f"{100 * statistics.fmean(map(spl, ones)):.0f} %",
        f"{statistics.median(one['sim_seconds'] for one in ones):.0f} s",
        f"{statistics.median(errors):.2f} m" if errors else "-",
        str(sum(a and not b for a, b in before)),
        str(sum(b and not a for a, b in before)),
        ", ".join(f"{count} {name}" for name, count in sorted(causes.items())) or "-",
    ]
    if unmapped:
        found = sum(one["success_2m"] for one in unmapped)
        cells[-1] += f"; of {len(unmapped)} beside the map {found} succeed"
    return "| " + " | ".join(cells) + " |"


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("openbench")
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("suite")
    parser.add_argument("--seeds", default="10000..10004")
    parser.add_argument("--agent", default="open")
    parser.add_argument("--set", nargs="*", default=[], help="settings, such as fixes=osm")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--levels", nargs="*", help="only these, such as light=dusk")
    parser.add_argument("--deliveries", type=pathlib.Path, help="a CSV file that keeps them")
    args = parser.parse_args()
    print("| condition | deliveries | SR (strict) | SPL | time | pose error | lost | won | causes |")
    print("|---|---|---|---|---|---|---|---|---|", flush=True)
    kept = read(args.deliveries) if args.deliveries and args.deliveries.exists() else []
    plain = None
    for conditions in LEVELS:
        if conditions and args.levels and conditions[0] not in args.levels:
            continue
        deliveries = [one for one in kept if one["condition"] == name_of(conditions)]
        if not deliveries:
            deliveries = run(args, conditions)
            kept += deliveries
            if args.deliveries:
                write(args.deliveries, kept)
        plain = plain or by_task(deliveries)
        print(row(conditions, deliveries, plain), flush=True)


main()

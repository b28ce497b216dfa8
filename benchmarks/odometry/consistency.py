#!/usr/bin/env python3
"""Whether the odometry is as far off as it says: consistency.py [--runs 50] [--openbench PATH]

Drives for a minute from door to door, each time with another seed, in the built-in worlds in turn, and prints the mean of the normalized estimation error squared (NEES) at the ends of the
drives, with the band that 95 of 100 such means lie in if covariances are right (chi-square, Bar-Shalom 2001, section 5.4).
"""

import argparse
import json
import subprocess
import tempfile
from pathlib import Path

from scipy.stats import chi2

WORLDS = ["small", "medium", "large"]


def drive(openbench, world, seed, minutes):
    """The NEES of a drive."""
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder) / "drive.mcap"
        record = [openbench, "record", world, "--minutes", str(minutes), "--noise-seed", str(seed), "--out", log]
        subprocess.run(record, check=True, capture_output=True)
        odometry = [openbench, "odometry", log, "--out", Path(folder) / "way.tum", "--json"]
        return json.loads(subprocess.run(odometry, check=True, capture_output=True).stdout)["nees"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--runs", type=int, default=50)
    parser.add_argument("--minutes", type=float, default=1)
    parser.add_argument("--seed", type=int, default=1000, help="of the first drive")
    parser.add_argument("--openbench", default="openbench")
    args = parser.parse_args()
    found = []
    for run in range(args.runs):
        world = WORLDS[run % len(WORLDS)]
        nees = drive(args.openbench, world, args.seed + run, args.minutes)
        found.append(nees)
        print(f"{world:8} seed {args.seed + run}: " + ", ".join(f"{k} {v:.2f}" for k, v in nees.items()), flush=True)
    for name, freedom in (("end", 6), ("ground", 3)):
        mean = sum(nees[name] for nees in found) / len(found)
        low, high = (chi2.ppf(p, freedom * len(found)) / len(found) for p in (0.025, 0.975))
        print(f"{name}: mean NEES {mean:.2f} over {len(found)} drives; {low:.2f} to {high:.2f} if {freedom} numbers are as far off as they say")


main()

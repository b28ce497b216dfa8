#!/usr/bin/env python3
"""Measures what reports of the built-in suites compare with: OPEN and the yardsticks.

    cargo build --release
    python3 benchmarks/reference/reference.py target/release/openbench FOLDER

Runs that are in FOLDER already are used again, so begin with an empty one. Writes
crates/bench/data/reference.json. A report shows the rows whose world and suite are its own.
"""

import json
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
OUT = ROOT / "crates/bench/data/reference.json"
SUITES = ["small", "medium", "large"]
AGENTS = ["omniscient", "open", "straight-line", "random"]
SHARES = [
    "sr_10m", "spl_straight", "lsr_10m", "lspl_straight", "sr_2m", "spl", "lsr", "lspl",
]


def results(openbench, folder, suite, agent):
    out = folder / f"{suite}-{agent}"
    if not (out / "results.json").exists():
        words = [openbench, "run", suite, "--agent", agent, "--jobs", "2", "--record", "none", "--discard"]
        subprocess.run([*words, "--out", out], check=True, stdout=subprocess.DEVNULL)
    return json.loads((out / "results.json").read_text())


def row(results):
    provenance = results["provenance"]
    shares = {name: rounded(results["metrics"][name]) for name in SHARES}
    return {
        "suite": results["suite"],
        "suite_hash": provenance["hashes"]["suite"],
        "world_hash": provenance["hashes"]["world"],
        "agent": results["agent"],
        "commit": short(provenance["build"]["commit"]),
        "collisions": results["metrics"]["collisions"],
        **shares,
    }


def short(commit):
    digits, edited, _ = commit.partition("-dirty")
    return digits[:7] + edited


def rounded(share):
    return None if share is None else round(share, 4)


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    openbench, folder = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    rows = [row(results(openbench, folder, s, a)) for s in SUITES for a in AGENTS]
    lines = ",\n".join("  " + json.dumps(one) for one in rows)
    OUT.write_text(f"[\n{lines}\n]\n")
    for one in rows:
        print(one["suite"], one["agent"], *(one[name] for name in SHARES))


main()

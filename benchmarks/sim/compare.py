"""Casts the rays of a dump with other engines on one core, compares hits and speed with ours, and writes a table.

Usage: compare.py DUMP [--results FOLDER]. Exit code 1 if our ranges are not Embree's, 2 if the dump cannot be used.
"""

import argparse
import os
import sys
import time
from pathlib import Path

import agreement
import dump as dumps
import peer_embreex
import peer_mujoco
import peer_pybullet
import report
import vehicle

PEERS = (peer_embreex, peer_mujoco, peer_pybullet)
LEAST_AGREEMENT = 0.999  # with Embree, the share of rays
REPEATS = 5
PATIENCE = 20.0  # seconds of repeating one engine, at most; at least one repeat


def use_one_core():
    """Holds the process, and every thread that a library may start, on one core."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})


def best_of(work):
    """The fewest CPU seconds, of all threads, that `work` takes, after one call to warm up; and what it returned."""
    work()
    best, began = float("inf"), time.monotonic()
    for _ in range(REPEATS):
        start = time.process_time()
        result = work()
        best = min(best, time.process_time() - start)
        if time.monotonic() - began > PATIENCE:
            break
    return best, result


def measure(engine, dump):
    """One way of using one engine: its speed, and how its hits agree with ours."""
    seconds, raw = best_of(engine.cast)
    row, wrong = agreement.compare(dump.ranges, engine.ranges(raw), dump.max_range)
    row |= {"engine": engine.name, "version": engine.version, "note": engine.note, "triangles_per_mesh": engine.most, "seconds": seconds}
    row["mrays_per_core_second"] = len(dump.ranges) / seconds / 1e6
    if hasattr(engine, "cast_nothing"):
        row["binding_seconds"], _ = best_of(engine.cast_nothing)
        row["mrays_per_core_second_without_binding"] = len(dump.ranges) / max(seconds - row["binding_seconds"], 1e-9) / 1e6
    if hasattr(engine, "distances"):
        unexplained = agreement.unexplained(dump, wrong, engine.distances)
        row["unexplained_rays"] = len(unexplained)
        row["unexplained_first"] = unexplained[:20].tolist()
    if hasattr(engine, "close"):
        engine.close()
    return row


def measure_all(dump):
    rows = []
    for peer in PEERS:
        for make in peer.variants(dump):
            rows.append(measure(make(), dump))
            print(report.progress(rows[-1]), file=sys.stderr)
    return rows


def fastest(rows, engine):
    return max((row for row in rows if row["engine"] == engine), key=lambda row: row["mrays_per_core_second"])


def problems(rows):
    """What must not be: our ranges differ from Embree's."""
    for row in rows:
        if row["engine"] == "embreex" and row["agree_share"] < LEAST_AGREEMENT:
            yield f"{row['agree_share']:.4%} of our ranges are Embree's ({row['note']}), fewer than {LEAST_AGREEMENT:.1%}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("dump", type=Path, help="folder that `openbench bench sim --dump` wrote")
    parser.add_argument("--results", type=Path, default=Path(__file__).parent / "results", help="where latest.json and latest.md go")
    arguments = parser.parse_args()
    use_one_core()
    try:
        dump = dumps.read(arguments.dump)
    except dumps.BadDump as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    rows = measure_all(dump)
    robot = vehicle.real_time_factor(dump, fastest(rows, "MuJoCo")["triangles_per_mesh"])
    found = list(problems(rows))
    results = report.results(dump, rows, robot, found)
    print(report.write(results, arguments.results))
    for problem in found:
        print(f"PROBLEM: {problem}", file=sys.stderr)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""The table of a comparison: table.py FOLDER [LOG ...], with a folder of .tum and .json files for each log.

With logs named: a row for each of them, with errors aligned as a whole; the median CPU time of a scan, of
which the middle log's is shown; and how ours stands to the best peer of each log.

Errors are evo's: the root of the mean square of positions' errors, truth interpolated to the stamps of each estimate as they are. Aligned as a whole by a rotation and
a shift, or at the first pose that all have, and per 100 m of the way.
"""

import json
import sys
from pathlib import Path

from evo.core import metrics, trajectory
from evo.tools import file_interface

# The long ones are ours alone.
LONG = ["hour", "avenue", "boulevard"]
LOGS = LONG + ["close", "loops", "street", "yards", "kerbs", "traffic", "turning", "square", "corridor", "gap", "saturation"]
# The robot stands until then, seconds; all have begun.
BEGIN = 1.5


def errors(truth, estimate, whole):
    """The errors in metres, aligned as a whole or at the first pose."""
    estimate = trajectory.PoseTrajectory3D(estimate.positions_xyz, estimate.orientations_quat_wxyz, estimate.timestamps)
    if whole:
        estimate.align(truth)
    else:
        estimate.align_origin(truth)
    ape = metrics.APE(metrics.PoseRelation.translation_part)
    ape.process_data((truth, estimate))
    return ape.error


def rms(errors):
    return float((errors**2).mean() ** 0.5)


def read(folder, name, truth):
    """An estimate and the truth at its instants."""
    estimate = file_interface.read_tum_trajectory_file(folder / f"{name}.tum")
    estimate.reduce_to_time_range(BEGIN, float("inf"))
    # Truth comes every 50 ms and is smooth: between two poses along a straight line.
    return interpolated(truth, estimate.timestamps), estimate


def standing(out, logs):
    """How our error as a whole, without wheels and with them, stands to that of the best peer of each log."""
    lines = []
    for mine in ("ours", "ours-wheels"):
        ratios, parts = [], []
        for log in logs:
            folder = out / log
            truth = file_interface.read_tum_trajectory_file(folder / "truth.tum")
            peers = [path.stem for path in folder.glob("*.json") if not path.stem.startswith("ours")]
            peers = [name for name in peers if "error" not in json.loads((folder / f"{name}.json").read_text())]

            def whole(name):
                reference, estimate = read(folder, name, truth)
                return rms(errors(reference, estimate, True)), reference.path_length

            error, length = whole(mine)
            parts.append(10_000 * error / length)
            ratios.append(error / min((whole(name)[0] for name in peers), default=float("inf")))
        better, near = sum(r <= 1 for r in ratios), sum(r <= 1.5 for r in ratios)
        middle = sorted(parts)[len(parts) // 2]
        lines.append(
            f"- {mine}: at or better than the best peer in {better} of {len(logs)} logs, within 1.5 times in {near}, "
            f"at worst {max(ratios):.2f} times; median {middle:.2f} cm per 100 m"
        )
    return "\n".join(lines)


def row(folder, name, truth):
    """A line of the table."""
    facts = json.loads((folder / f"{name}.json").read_text())
    if "error" in facts:
        return f"| {folder.name} | {name} | fails: {facts['error'][:60]} | | | | |"
    reference, estimate = read(folder, name, truth)
    length = reference.path_length
    cells = [100 * rms(errors(reference, estimate, whole)) for whole in (True, False)]
    cells += [100 * cell / length for cell in cells]
    numbers = " | ".join(f"{cell:.2f}" for cell in cells)
    log = f"{folder.name}, {length:.0f} m"
    return f"| {log} | {name} | {numbers} | {facts['cpu_ms_p50']:.1f}; {facts['cpu_ms_p99']:.1f} |"


def by_ours(name):
    """Ours first, then by name."""
    return not name.startswith("ours"), name


def side_by_side(out, logs):
    """A table with a row for each log and a column for each odometry."""
    facts = {log: {path.stem: json.loads(path.read_text()) for path in (out / log).glob("*.json")} for log in logs}
    names = sorted({name for found in facts.values() for name in found}, key=by_ours)
    columns = " | ".join(f"{name}, cm" for name in names)
    lines = [f"| log | way, m | {columns} |", "|---|---:|" + "---:|" * len(names)]
    for log in logs:
        truth = file_interface.read_tum_trajectory_file(out / log / "truth.tum")
        cells, length = [], 0.0
        for name in names:
            if "error" in facts[log].get(name, {"error": ""}):
                cells.append("fails")
                continue
            reference, estimate = read(out / log, name, truth)
            length = max(length, reference.path_length)
            cells.append(f"{100 * rms(errors(reference, estimate, True)):.2f}")
        lines.append(f"| {log} | {length:.0f} | " + " | ".join(cells) + " |")
    cells = []
    for name in names:
        known = [found[name] for found in facts.values() if name in found]
        times = sorted(fact["cpu_ms_p50"] for fact in known if "cpu_ms_p50" in fact)
        cells.append(f"{times[len(times) // 2]:.1f} ms" if times else "")
    lines.append("| CPU a scan | | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def interpolated(truth, stamps):
    """The truth at these instants."""
    import numpy as np
    from scipy.spatial.transform import Rotation, Slerp

    stamps = np.clip(stamps, truth.timestamps[0], truth.timestamps[-1])
    places = np.stack([np.interp(stamps, truth.timestamps, column) for column in truth.positions_xyz.T], axis=1)
    turns = Slerp(truth.timestamps, Rotation.from_quat(truth.orientations_quat_wxyz[:, [1, 2, 3, 0]]))(stamps).as_quat()
    return trajectory.PoseTrajectory3D(places, turns[:, [3, 0, 1, 2]], stamps)


def drift(folder, name, truth):
    """How far off a long way ends, and is at most."""
    reference, estimate = read(folder, name, truth)
    off, length = errors(reference, estimate, False), reference.path_length
    return f"{folder.name}, {name}: {100 * off[-1]:.1f} cm off after {length:.0f} m ({100 * off[-1] / length:.4f} %), {100 * off.max():.1f} cm at most"


def main():
    out = Path(sys.argv[1])
    if sys.argv[2:]:
        print(side_by_side(out, sys.argv[2:]))
        print()
        print(standing(out, sys.argv[2:]))
        return
    print("| log | odometry | SE(3), cm | first pose, cm | SE(3), cm per 100 m | first pose, cm per 100 m | CPU ms a scan, p50; p99 |")
    print("|---|---|---|---|---|---|---|")
    for log in LOGS:
        folder = out / log
        truth = file_interface.read_tum_trajectory_file(folder / "truth.tum")
        names = sorted(path.stem for path in folder.glob("*.json"))
        for name in sorted(names, key=by_ours):
            print(row(folder, name, truth))
    print()
    for log in LONG:
        truth = file_interface.read_tum_trajectory_file(out / log / "truth.tum")
        for name in ("ours", "ours-wheels"):
            print(f"- {drift(out / log, name, truth)}")


main()

"""Results as JSON and as a Markdown table: our speed over each engine's, beside the goals."""

import json
import os
import platform
from pathlib import Path

GOALS = {"embreex": 1.6, "MuJoCo": 60.0, "PyBullet": 40.0}  # our rays per core-second over theirs
OURS = (
    ("cast_mrays_per_core_second", "casting alone, million rays per core-second"),
    ("lidar_mrays_per_core_second", "whole LiDAR scans, million rays per core-second"),
    ("camera_fps_per_core", "camera images per core-second"),
    ("rtf_lidar", "real-time factor with LiDAR"),
    ("rtf_camera", "real-time factor with LiDAR and camera"),
    ("load_seconds", "loading the world, seconds"),
    ("peak_memory_mb", "peak memory, MB"),
)


def machine():
    name = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.exists():
        names = [line.split(":", 1)[1].strip() for line in info.read_text().splitlines() if line.startswith("model name")]
        name = names[0] if names else name
    return {"processor": name, "cores": os.cpu_count(), "system": platform.system(), "python": platform.python_version()}


def our_rate(ours):
    """Our rate to compare with, and what it covers: casting alone where it was measured, else whole scans, which are more work."""
    for key, words in OURS[:2]:
        if ours.get(key) is not None:
            return ours[key], words.split(",")[0]
    return None, "not measured"


def results(dump, rows, robot, problems):
    ours, covers = our_rate(dump.ours)
    for row in rows:
        row["goal"] = GOALS[row["engine"]]
        row["ratio"] = ours / row["mrays_per_core_second"] if ours else None
        if ours and "mrays_per_core_second_without_binding" in row:
            row["ratio_without_binding"] = ours / row["mrays_per_core_second_without_binding"]
    return {
        "machine": machine(),
        "triangles": len(dump.triangles),
        "rays": len(dump.ranges),
        "scans": dump.scans,
        "hit_share": float((dump.ranges > 0.0).mean()),
        "max_range_m": dump.max_range,
        "ours": dump.ours,
        "compared_mrays_per_core_second": ours,
        "compared": covers,
        "engines": rows,
        "mujoco_robot": robot,
        "problems": problems,
    }


def progress(row):
    return f"{row['engine']} ({row['note']}): {row['mrays_per_core_second']:.3f} million rays per core-second"


def write(results, folder):
    """Writes `latest.json` and `latest.md` in `folder`; returns the Markdown."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "latest.json").write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")
    text = markdown(results)
    (folder / "latest.md").write_text(text, encoding="utf-8")
    return text


def markdown(results):
    at = results["machine"]
    lines = [
        f"{at['processor']}, one of {at['cores']} cores; {results['triangles']:,} triangles, {results['rays']:,} rays"
        f" in {results['scans']} scans, {results['hit_share']:.0%} hit within {results['max_range_m']:g} m.",
        "",
        "| engine | million rays per core-second | ours is faster by | goal | same hit within 1 mm | largest difference |",
        "|---|---:|---:|---:|---:|---:|",
        f"| **ours**, {results['compared']} | {number(results['compared_mrays_per_core_second'])} | | | | |",
    ]
    for row in best_of_each(results["engines"]):
        lines += engine_lines(row)
    lines += ["", *robot_lines(results), "", "| ours | |", "|---|---:|"]
    lines += [f"| {words} | {number(results['ours'].get(key))} |" for key, words in OURS if results["ours"].get(key) is not None]
    return "\n".join(lines) + "\n"


def best_of_each(rows):
    """Every row of embreex, and the fastest of those engines of which several cuts of the scene were tried."""
    shown = [row for row in rows if row["engine"] == "embreex"]
    for engine in ("MuJoCo", "PyBullet"):
        tried = [row for row in rows if row["engine"] == engine]
        shown += [max(tried, key=lambda row: row["mrays_per_core_second"])] if tried else []
    return shown


def engine_lines(row):
    largest = row["largest_differences_m"]
    difference = f"{abs(largest[0]['ours'] - largest[0]['theirs']):.2g} m" if largest else "0"
    edges = f", {row['unexplained_rays']} of them not at an edge" if row.get("unexplained_rays") is not None and row["disagreeing_rays"] else ""
    agreement = f"{row['agree_share']:.3%} ({row['disagreeing_rays']} rays differ{edges})"
    name = f"{row['engine']} {row['version']}, {row['note']}"
    yield f"| {name} | {number(row['mrays_per_core_second'])} | {times(row['ratio'])} | {times(row['goal'])} | {agreement} | {difference} |"
    if "binding_seconds" in row:
        rate, ratio = row["mrays_per_core_second_without_binding"], row.get("ratio_without_binding")
        yield f"| {name}, without its Python binding's share | {number(rate)} | {times(ratio)} | | | |"


def robot_lines(results):
    robot, ours = results["mujoco_robot"], number(results["ours"].get("rtf_lidar"))
    yield (
        f"A four-wheeled robot at 250 Hz with 10 scans a second of {robot['rays_per_scan']:,} rays in the same scene: "
        f"MuJoCo {robot['real_time_factor']:.2f} simulated seconds per core-second (ours, at 400 Hz with IMU and sensor noise: {ours})."
    )


def number(value):
    return "" if value is None else f"{value:.3g}"


def times(value):
    return "" if value is None else f"{value:.3g} x"

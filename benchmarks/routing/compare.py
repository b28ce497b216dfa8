"""Compares our routing with OSRM's multi-level Dijkstra (and with Valhalla and RoutingKit, for orientation) and prints a table.

Usage: compare.py OPENBENCH MAP.osm.pbf PAIRS.csv FOLDER

Everything is CPU time on one thread. Answers are compared first: a comparison of speeds means something only between equal answers.
"""

import csv
import http.client
import json
import os
import pathlib
import platform
import resource
import shutil
import signal
import subprocess
import sys
import time


def main():
    ours, osm, pairs_file, folder = map(pathlib.Path, sys.argv[1:5])
    folder.mkdir(parents=True, exist_ok=True)
    with open(pairs_file) as file:
        pairs = [tuple(map(float, row)) for row in csv.reader(file)]
    print(f"{platform.processor() or cpu_name()}, one of {os.cpu_count()} cores; {osm.name}, {len(pairs)} pairs\n", flush=True)
    us = measure_ours(ours, osm, pairs_file, folder)
    them, answers = measure_osrm(osm, pairs, folder)
    agreement(us["answers"], answers)
    us["http"] = http_ours(ours, osm, pairs, folder)
    them["http"] = http_osrm(folder, pairs)
    table(us, them)
    routingkit(folder)
    valhalla(osm, pairs, answers, folder)


def cpu_name():
    with open("/proc/cpuinfo") as file:
        return next((line.split(":")[1].strip() for line in file if line.startswith("model name")), "unknown processor")


def measure_ours(ours, osm, pairs_file, folder):
    command = [ours, "bench", "routing", "--map", osm, "--profile", "foot", "--pairs", pairs_file, "--json"]
    output = subprocess.run(
        [*command, "--answers", folder / "ours.csv", "--dump", folder / "graph"], check=True, capture_output=True, text=True
    )
    us = json.loads(output.stdout)
    with open(folder / "ours.csv") as file:
        us["answers"] = [(float(row["distance_m"]), float(row["duration_s"])) for row in csv.DictReader(file)]
    return us


def osrm_home():
    import osrm

    return pathlib.Path(osrm.__file__).parent


def run_tool(*command):
    """CPU seconds and peak megabytes of a command on one thread."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    if status != 0:
        sys.exit(f"{command[0]} ended with {status}")
    del before
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss * 1024 / 1e6


def measure_osrm(osm, pairs, folder):
    home = osrm_home()
    work = folder / "osrm"
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir()
    shutil.copy(osm, work / "map.osm.pbf")
    tool = lambda name, *rest: run_tool(home / "bin" / f"osrm-{name}", "-t", "1", *rest)
    extract = tool("extract", "-p", home / "share" / "profiles" / "foot.lua", work / "map.osm.pbf")
    partition = tool("partition", work / "map.osrm")
    customize = tool("customize", work / "map.osrm")
    # A process of its own, so that its memory is its own too.
    script = pathlib.Path(__file__).with_name("osrm_speed.py")
    output = subprocess.run(
        [sys.executable, script, work / "map.osrm"],
        input=json.dumps(pairs), check=True, capture_output=True, text=True,
    )
    them = json.loads(output.stdout)
    them["build_seconds"] = extract[0] + partition[0] + customize[0]
    them["customize_seconds"] = customize[0]
    them["build_peak_memory_mb"] = max(extract[1], partition[1], customize[1])
    return them, them.pop("answers")


def agreement(ours, theirs):
    """How far our durations are from OSRM's."""
    off = []
    for number, (us, them) in enumerate(zip(ours, theirs), 1):
        if them is None or us[1] != us[1]:
            if (them is None) != (us[1] != us[1]):
                off.append((1.0, number, us, them))
            continue
        off.append((abs(us[1] - them[1]) / max(them[1], 1.0), number, us, them))
    within = sum(share <= 0.01 for share, *_ in off)
    off.sort(reverse=True, key=lambda row: row[0])
    print(f"durations within 1 % of OSRM's: {within} of {len(off)}; median difference {off[len(off) // 2][0]:.6%}")
    for share, number, us, them in off[:3]:
        theirs = "no route" if them is None else f"{them[1]:.1f} s, {them[0]:.1f} m"
        print(f"  row {number}: {share:.3%} off: ours {us[1]:.1f} s, {us[0]:.1f} m; OSRM's {theirs}")
    print(flush=True)


URLS = {
    "route": "/route/v1/foot/{0},{1};{2},{3}?overview=false&generate_hints=false",
    "steps": "/route/v1/foot/{0},{1};{2},{3}?overview=full&geometries=geojson&steps=true&generate_hints=false",
    "nearest": "/nearest/v1/foot/{0},{1}?generate_hints=false",
}


def http_cpu(pid, port, pairs):
    """CPU microseconds of the server for a request of each kind."""

    def cpu():
        """Seconds that the server's threads have been running, exact to nanoseconds."""
        threads = pathlib.Path(f"/proc/{pid}/task").iterdir()
        return sum(int((thread / "schedstat").read_text().split()[0]) for thread in threads) / 1e9

    def fetch(connection, url):
        for _ in range(2):
            try:
                connection.request("GET", url, headers={"Accept-Encoding": "identity"})
                return connection.getresponse().read()
            except (http.client.HTTPException, OSError):
                # The server ends a connection after some hundred requests.
                connection.close()
        raise SystemExit(f"no answer to {url}")

    result = {}
    for kind, url in URLS.items():
        goes = []
        for _ in range(3):
            connection = http.client.HTTPConnection("127.0.0.1", port)
            began = cpu()
            for pair in pairs:
                fetch(connection, url.format(*pair))
            goes.append((cpu() - began) / len(pairs) * 1e6)
            connection.close()
        result[kind] = min(goes)
    table = ";".join(f"{pair[0]},{pair[1]}" for pair in pairs[:100])
    connection = http.client.HTTPConnection("127.0.0.1", port)
    goes = []
    for _ in range(5):
        began = cpu()
        fetch(connection, f"/table/v1/foot/{table}?generate_hints=false")
        goes.append((cpu() - began) * 1e6)
    result["table"] = min(goes)
    status = pathlib.Path(f"/proc/{pid}/status").read_text()
    peak = next(line for line in status.splitlines() if line.startswith("VmHWM"))
    result["memory_mb"] = float(peak.split()[1]) * 1024 / 1e6
    return result


def served(command, port, pairs, environment):
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=environment)
    try:
        for _ in range(300):
            try:
                connection = http.client.HTTPConnection("127.0.0.1", port)
                connection.request("GET", URLS["nearest"].format(*pairs[0]))
                connection.getresponse().read()
                break
            except OSError:
                time.sleep(0.1)
        return http_cpu(process.pid, port, pairs)
    finally:
        process.send_signal(signal.SIGTERM)
        process.wait(30)


def http_ours(ours, osm, pairs, folder):
    graph = folder / "map.graph"
    subprocess.run([ours, "prepare", "--map", osm, "--out", graph], check=True, stdout=subprocess.DEVNULL)
    command = [ours, "serve", "--map", graph, "--profile", "foot", "--listen", "127.0.0.1:5917", "--threads", "1"]
    return served(command, 5917, pairs, dict(os.environ))


def http_osrm(folder, pairs):
    command = [osrm_home() / "bin" / "osrm-routed", "--algorithm", "mld", "-i", "127.0.0.1", "-p", "5918", "-t", "1"]
    environment = {**os.environ, "DISABLE_ACCESS_LOGGING": "1"}
    return served([*command, "--max-table-size", "1000", folder / "osrm" / "map.osrm"], 5918, pairs, environment)


def table(us, them):
    rows = [
        ("route, snapping included, p50", "route_us_p50", "us", "1/2"),
        ("the same, p99", "route_us_p99", "us", "1/2"),
        ("with GeoJSON and steps, p50", "steps_us_p50", "us", "1/2"),
        ("the same, p99", "steps_us_p99", "us", "1/2"),
        ("nearest, p50", "nearest_us_p50", "us", "1/3"),
        ("table of 100 x 100", "table_100_ms", "ms", "1/3"),
        ("PBF to routable", "build_seconds", "s", "1/4"),
        ("customization", "customize_seconds", "s", "1/4"),
        ("peak memory, build", "build_peak_memory_mb", "MB", "1/2"),
    ]
    print("| CPU time, one thread | ours | OSRM MLD | ours / OSRM's | goal |\n|---|---:|---:|---:|---|")
    for name, key, unit, goal in rows:
        line(name, us[key], them[key], unit, goal)
    line("peak memory, serve", us["http"]["memory_mb"], them["http"]["memory_mb"], "MB", "1/2")
    for kind in ("route", "steps", "nearest", "table"):
        line(f"HTTP, {kind}", us["http"][kind], them["http"][kind], "us", "1/2")
    print(flush=True)


def line(name, ours, theirs, unit, goal):
    shown = lambda value: f"{value:.3g}" if value < 100 else f"{value:,.0f}"
    print(f"| {name} | {shown(ours)} {unit} | {shown(theirs)} {unit} | {ours / theirs:.3f} | {goal} |")


def routingkit(folder):
    """A contraction hierarchy on our graph: what re-customization costs in queries, and a check of our weights."""
    import numpy
    from pyroutingkit import CCH

    read = lambda name, kind: numpy.fromfile(folder / "graph" / name, dtype=kind)
    tail, head, weight = (read(f"{name}.u32", "<u4") for name in ("tail", "head", "weight"))
    lat, lon = read("lat.f32", "<f4"), read("lon.f32", "<f4")
    hierarchy = CCH()
    began = time.process_time()
    hierarchy.build_topology(tail, head, lat, lon, node_count=len(lat))
    topology = time.process_time() - began
    began = time.process_time()
    hierarchy.customize_weights(weight)
    customization = time.process_time() - began
    times, different = [], 0
    for source, target, expected in read("queries.u32", "<u4").reshape(-1, 3).tolist():
        began = time.process_time_ns()
        found, _ = hierarchy.query(source, target)
        times.append((time.process_time_ns() - began) / 1e3)
        reached = expected != 2**32 - 1
        different += found != expected if reached else found < 2**31 - 1
    times.sort()
    print(f"RoutingKit's customizable contraction hierarchy on our graph of {len(lat):,} vertices: topology {topology:.2f} s,")
    print(f"customization {customization:.3f} s, a path p50 {times[len(times) // 2]:.0f} us, without snapping;", end=" ")
    print(f"{different} of {len(times)} weights differ from ours\n", flush=True)


def valhalla(osm, pairs, answers, folder):
    """Another engine with speeds of its own: for orientation."""
    import valhalla as engine

    home = pathlib.Path(engine.__file__).parent
    work = folder / "valhalla"
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir()
    (work / "tiles").mkdir()
    (work / "tiles.tar").touch()
    config = engine.get_config(tile_extract=work / "tiles.tar", tile_dir=work / "tiles", verbose=False)
    config["mjolnir"].update({"timezone": "", "admin": "", "concurrency": 1})
    config["mjolnir"]["logging"] = {"type": ""}
    config["loki"]["logging"] = config["thor"]["logging"] = config["odin"]["logging"] = {"type": ""}
    (work / "valhalla.json").write_text(json.dumps(config))
    build, peak = run_tool(home / "bin" / "valhalla_build_tiles", "-c", work / "valhalla.json", osm)
    actor = engine.Actor(str(work / "valhalla.json"))
    times, ratios = [], []
    for pair, answer in list(zip(pairs, answers))[:200]:
        request = {
            "locations": [{"lon": pair[0], "lat": pair[1]}, {"lon": pair[2], "lat": pair[3]}],
            "costing": "pedestrian",
            "costing_options": {"pedestrian": {"walking_speed": 5.0, "max_distance": 1000000}},
            "directions_type": "none",
        }
        text = json.dumps(request)
        began = time.process_time_ns()
        try:
            reply = json.loads(actor.route(text))
        except RuntimeError:
            continue
        times.append((time.process_time_ns() - began) / 1e3)
        if answer:
            ratios.append(reply["trip"]["summary"]["time"] / answer[1])
    times.sort()
    ratios.sort()
    print(f"Valhalla on foot: building {build:.1f} s, {peak:.0f} MB; a route p50 {times[len(times) // 2] / 1e3:.1f} ms;", end=" ")
    print(f"its durations, by its own speeds, are {ratios[len(ratios) // 2]:.3f} times OSRM's (median)")


if __name__ == "__main__":
    main()

"""How the cost of routing on foot grows with the map: prints a table and the rates of growth, and draws them.

Usage: growth.py OPENBENCH FOLDER MAP...

Beside the maps themselves: all of them in one file, and copies of the largest one side by side, joined at their edges, to see further.
"""

import csv
import json
import math
import os
import pathlib
import random
import subprocess
import sys

import osmium

import compare

# Columns and rows of copies.
COPIES = [(2, 1), (2, 2), (4, 2), (4, 4)]
PAIRS = 1000
# Roads that join two copies.
JOINTS = 20
MEASURES = [
    ("route_us_p50", "route, p50", "us"),
    ("route_us_p99", "route, p99", "us"),
    ("steps_us_p50", "with steps, p50", "us"),
    ("nearest_us_p50", "nearest, p50", "us"),
    ("table_100_ms", "table of 100 x 100", "ms"),
    ("build_seconds", "PBF to routable", "s"),
    ("customize_seconds", "customization", "s"),
    ("build_peak_memory_mb", "memory to build", "MB"),
    ("serve_mb", "memory to serve", "MB"),
    ("file_mb", "graph file", "MB"),
]


class Roads:
    """The roads of a map: nodes by number, and ways as tags and numbers of nodes."""

    def __init__(self, path):
        self.nodes, self.ways = {}, []
        for way in osmium.FileProcessor(path, osmium.osm.WAY):
            if "highway" in way.tags:
                self.ways.append((dict(way.tags), [node.ref for node in way.nodes]))
        wanted = {node for _, nodes in self.ways for node in nodes}
        for node in osmium.FileProcessor(path, osmium.osm.NODE):
            if node.id in wanted:
                self.nodes[node.id] = (node.location.lon, node.location.lat, dict(node.tags))

    def box(self):
        lons, lats = [node[0] for node in self.nodes.values()], [node[1] for node in self.nodes.values()]
        return min(lons), min(lats), max(lons), max(lats)


def write(path, parts, joints=()):
    """Writes roads, each moved by so many degrees, and joints between them: pairs of part and node."""
    path.unlink(missing_ok=True)
    numbers = {}
    with osmium.SimpleWriter(str(path)) as writer:
        for part, (roads, east, north) in enumerate(parts):
            for node, (lon, lat, tags) in roads.nodes.items():
                numbers[part, node] = len(numbers) + 1
                writer.add_node(osmium.osm.mutable.Node(id=len(numbers), location=(lon + east, lat + north), tags=tags))
        way = 0
        for part, (roads, _, _) in enumerate(parts):
            for tags, nodes in roads.ways:
                way += 1
                known = [numbers[part, node] for node in nodes if (part, node) in numbers]
                writer.add_way(osmium.osm.mutable.Way(id=way, nodes=known, tags=tags))
        for pair in joints:
            way += 1
            nodes = [numbers[end] for end in pair]
            writer.add_way(osmium.osm.mutable.Way(id=way, nodes=nodes, tags={"highway": "residential"}))


def copies(path, roads, columns, rows):
    """Copies in columns and rows, and roads between neighbours."""
    west, south, east, north = roads.box()
    places = [(column, row) for row in range(rows) for column in range(columns)]
    parts = [(roads, column * (east - west), row * (north - south)) for column, row in places]
    joints = []
    for axis, (low, high) in enumerate([(south, north), (west, east)]):
        # In each strip across the border the node nearest to it on either side.
        strips = [[] for _ in range(JOINTS)]
        for node, place in roads.nodes.items():
            strip = int((place[1 - axis] - low) / (high - low) * JOINTS)
            strips[min(strip, JOINTS - 1)].append((place[axis], node))
        ends = [(max(strip)[1], min(strip)[1]) for strip in strips if strip]
        for part, (column, row) in enumerate(places):
            beside = (column + 1, row) if axis == 0 else (column, row + 1)
            if beside in places:
                joints += [((part, last), (places.index(beside), first)) for last, first in ends]
    write(path, parts, joints)


def random_pairs(path, parts):
    """Pairs of nodes, all over the map."""
    generator = random.Random(0)
    nodes = [(part, node) for part, (roads, _, _) in enumerate(parts) for node in roads.nodes]

    def place():
        part, node = generator.choice(nodes)
        roads, east, north = parts[part]
        return roads.nodes[node][0] + east, roads.nodes[node][1] + north

    with open(path, "w", newline="") as file:
        csv.writer(file).writerows([*place(), *place()] for _ in range(PAIRS))


def measure(ours, folder, name, osm, pairs):
    """What `bench routing` says, and what serving a graph file of the map takes."""
    command = [ours, "bench", "routing", "--map", osm, "--profile", "foot", "--pairs", pairs, "--json"]
    result = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    graph = folder / f"{name}.graph"
    subprocess.run([ours, "prepare", "--map", osm, "--out", graph], check=True, stdout=subprocess.DEVNULL)
    result["file_mb"] = graph.stat().st_size / 1e6
    with open(pairs) as file:
        rows = [tuple(map(float, row)) for row in csv.reader(file)]
    command = [ours, "serve", "--map", graph, "--profile", "foot", "--listen", "127.0.0.1:5917", "--threads", "1"]
    result["serve_mb"] = compare.served(command, 5917, rows, dict(os.environ))["memory_mb"]
    return result


def slope(sizes, values):
    """The exponent of growth: of a straight line through the logarithms."""
    xs, ys = [math.log(size) for size in sizes], [math.log(value) for value in values]
    x, y = sum(xs) / len(xs), sum(ys) / len(ys)
    return sum((a - x) * (b - y) for a, b in zip(xs, ys)) / sum((a - x) ** 2 for a in xs)


def draw(results, path):
    import matplotlib

    matplotlib.use("svg")
    matplotlib.rcParams["svg.hashsalt"] = "openbench"
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(1, 3, figsize=(12, 4))
    kinds = [("us", "microseconds"), ("s", "seconds"), ("MB", "megabytes")]
    for axis, (unit, words) in zip(axes, kinds):
        for key, name, _ in (measure for measure in MEASURES if measure[2] == unit):
            sizes, values = zip(*sorted((result["vertices"], result[key]) for _, result in results))
            axis.loglog(sizes, values, "o-", label=name)
        axis.set_xlabel("vertices")
        axis.set_ylabel(words)
        axis.grid(True, which="both", alpha=0.3)
        axis.legend()
    figure.tight_layout()
    figure.savefig(path, metadata={"Date": None})


def main():
    ours, folder, *maps = map(pathlib.Path, sys.argv[1:])
    folder.mkdir(parents=True, exist_ok=True)
    results = []

    def add(name, osm, parts):
        pairs = folder / f"{name}.csv"
        random_pairs(pairs, parts)
        results.append((name, measure(ours, folder, name, osm, pairs)))
        print(f"{name}: {results[-1][1]['vertices']:,} vertices", file=sys.stderr, flush=True)

    extracts = [(osm.name.split(".")[0], osm, Roads(str(osm))) for osm in maps]
    for name, osm, roads in extracts:
        add(name, osm, [(roads, 0, 0)])
    together = [(roads, 0, 0) for _, _, roads in extracts]
    if len(extracts) > 1:
        write(folder / "together.osm.pbf", together)
        add("together", folder / "together.osm.pbf", together)
    largest = max(extracts, key=lambda extract: len(extract[2].nodes))
    for columns, rows in COPIES:
        name, roads = f"{columns}x{rows}_{largest[0]}", largest[2]
        copies(folder / f"{name}.osm.pbf", roads, columns, rows)
        west, south, east, north = roads.box()
        parts = [(roads, c * (east - west), r * (north - south)) for r in range(rows) for c in range(columns)]
        add(name, folder / f"{name}.osm.pbf", parts)
    report(results, largest[0], folder)


def report(results, largest, folder):
    print(f"{compare.cpu_name()}; CPU time; {PAIRS} random pairs on each map\n")
    print("| | " + " | ".join(name.replace("_", " ") for name, _ in results) + " | growth |")
    print("|---|" + "---:|" * (len(results) + 1))
    print("| vertices | " + " | ".join(f"{result['vertices']:,}" for _, result in results) + " | |")
    # The same streets everywhere, so that only the size differs.
    alike = [result for name, result in results if name.endswith(largest)]
    sizes = [result["vertices"] for result in alike]
    for key, name, unit in MEASURES:
        shown = " | ".join(f"{result[key]:.3g}" for _, result in results)
        print(f"| {name}, {unit} | {shown} | n^{slope(sizes, [result[key] for result in alike]):.2f} |")
    draw(results, folder / "growth.svg")
    print(f"\ngrowth: over {largest} and its copies; drawn in {folder / 'growth.svg'}")


if __name__ == "__main__":
    main()

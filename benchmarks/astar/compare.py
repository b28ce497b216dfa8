#!/usr/bin/env python3
"""Searches the longest ways of Moving AI scenario files with ours and with pyastar2d: compare.py --movingai PATH FILE.map ..."""

import argparse
import math
import re
import subprocess
import time

import numpy
import pyastar2d

LONGEST = 20


def read_map(path):
    """1 for free cells, infinity for others."""
    with open(path, encoding="ascii") as file:
        lines = file.read().splitlines()
    rows = lines[lines.index("map") + 1 :]
    free = [[cell in ".GS" for cell in row] for row in rows if row]
    return numpy.where(numpy.array(free), 1.0, numpy.inf).astype(numpy.float32)


def read_scenarios(path):
    """Start, goal (column, row) and published length of each of the longest."""
    with open(path, encoding="ascii") as file:
        rows = [line.split() for line in file.read().splitlines()[1:] if line.strip()]
    rows.sort(key=lambda row: -float(row[8]))
    return [((int(r[4]), int(r[5])), (int(r[6]), int(r[7])), float(r[8])) for r in rows[:LONGEST]]


def length(way):
    return sum(math.dist(a, b) for a, b in zip(way, way[1:]))


def corners_cut(way, grid):
    """Diagonal steps past a blocked cell."""
    return sum(
        not (math.isfinite(grid[a[0], b[1]]) and math.isfinite(grid[b[0], a[1]])) for a, b in zip(way, way[1:])
    )


def peer(grid, scenarios):
    """Mean CPU milliseconds, mean share by which ways are longer than published, corners cut a way."""
    spent, longer, cut = 0.0, 0.0, 0
    for start, goal, published in scenarios:
        begin = time.process_time()
        way = pyastar2d.astar_path(grid, start[::-1], goal[::-1], allow_diagonal=True)
        spent += time.process_time() - begin
        way = [tuple(map(int, cell)) for cell in way]
        longer += length(way) / published - 1
        cut += corners_cut(way, grid)
    count = len(scenarios)
    return 1e3 * spent / count, longer / count, cut / count


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--movingai", required=True, help="our example of that name, built")
    parser.add_argument("maps", nargs="+")
    args = parser.parse_args()
    print(f"| map | scenarios | optimal | ours, {LONGEST} longest, CPU ms | pyastar2d | ratio | its ways longer by | corners that it cuts, a way |")
    print("|---|---:|---:|---:|---:|---:|---:|---:|")
    for path in args.maps:
        said = subprocess.run([args.movingai, path, f"{path}.scen"], check=True, capture_output=True, text=True).stdout
        scenarios, optimal = re.search(r"(\d+) scenarios, (\d+) optimal", said).groups()
        ours = float(re.search(r"longest: mean ([\d.]+) ms", said).group(1))
        grid = read_map(path)
        theirs, longer, cut = peer(grid, read_scenarios(f"{path}.scen"))
        name = path.rsplit("/", 1)[-1].removesuffix(".map")
        print(f"| {name} | {scenarios} | {optimal} | {ours:.1f} | {theirs:.1f} | {ours / theirs:.2f} | {100 * longer:.1f} % | {cut:.1f} |", flush=True)


main()

#!/usr/bin/env python3
"""Writes a map of houses in rows along parallel roads: python3 rows.py SEED OUT.osm

Two such maps look much alike: with houses a metre or two off, a good part of what a robot sees in
one place fits the map of another. `openbench world generate` makes a world of it.
"""

import math
import random

from drawn_map import Map, main

LENGTH_M, ROADS = 160.0, 3


def rows(seed):
    """The text of a map. Each seed has its own direction, distances and houses."""
    chance = random.Random(seed)
    drawn = Map(chance.uniform(0.0, math.pi))
    apart = chance.uniform(42.0, 60.0)
    setback = chance.uniform(8.0, 12.0)
    widest, gap = chance.uniform(10.0, 18.0), chance.uniform(6.0, 14.0)
    ends = ([], [])
    for road in range(ROADS):
        y = road * apart
        name = f"Road {road + 1}"
        crossings = [drawn.node(x, y) for x in (0.0, LENGTH_M / 2, LENGTH_M)]
        ends[0].append(crossings[0])
        ends[1].append(crossings[2])
        drawn.way(crossings, {"highway": "residential", "name": name})
        for side in (-1.0, 1.0):
            x, number = chance.uniform(2.0, 10.0), 1 if side < 0 else 2
            while x < LENGTH_M - 10.0:
                width, depth = chance.uniform(7.0, widest), chance.uniform(7.0, 12.0)
                near = y + side * (setback + chance.uniform(-2.0, 2.0))
                far = near + side * depth
                corners = [(x, near), (x + width, near), (x + width, far), (x, far)]
                nodes = [drawn.node(*corner) for corner in corners]
                tags = {"building": "house", "addr:street": name, "addr:housenumber": number}
                drawn.way(nodes + nodes[:1], tags)
                x += width + chance.uniform(2.0, gap)
                number += 2
    for end in ends:
        drawn.way(end, {"highway": "residential"})
    return drawn.text()


main(rows, __doc__)

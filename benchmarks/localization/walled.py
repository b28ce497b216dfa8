#!/usr/bin/env python3
"""Writes a map of a few houses within high walls: python3 walled.py SEED OUT.osm

Registration compares buildings only, so that much of what a robot sees here is on no wall that it
knows. `openbench world generate` makes a world of it.
"""

import math
import random

from drawn_map import Map, main

#: High enough for the LiDAR to take them for facades, metres.
LOWEST_M, HIGHEST_M = 2.6, 4.0


def walled(seed):
    """The text of a map. Each seed has its own size, and 2 to 11 houses."""
    chance = random.Random(seed)
    drawn = Map(chance.uniform(0.0, math.pi))
    length, gap = chance.uniform(55.0, 130.0), chance.uniform(5.0, 40.0)
    tall = {"barrier": "wall", "height": f"{chance.uniform(LOWEST_M, HIGHEST_M):.1f}"}
    deepest = 0.0
    for side in (-1.0, 1.0):
        x, number = chance.uniform(4.0, 4.0 + gap), 1 if side < 0 else 2
        while x < length - 14.0:
            width, depth = chance.uniform(8.0, 22.0), chance.uniform(8.0, 16.0)
            near = chance.uniform(5.0, 14.0)
            deepest = max(deepest, near + depth)
            nodes = [drawn.node(x + u, side * (near + v)) for u, v in house(chance, width, depth)]
            tags = {
                "building": "house",
                "addr:street": "Long Road",
                "addr:housenumber": number,
            }
            drawn.way(nodes + nodes[:1], tags)
            if chance.random() < 0.3:
                # A garden wall beside the house.
                beside = x + width + chance.uniform(0.8, 3.5)
                ends = [drawn.node(beside, side * (near + v)) for v in (depth, depth - 7.0)]
                drawn.way(ends, tall)
            x += width + chance.uniform(4.0, 4.0 + gap)
            number += 2
    around = deepest + chance.uniform(2.5, 10.0)
    drawn.way([drawn.node(0.0, 0.0), drawn.node(length, 0.0)],
              {"highway": "residential", "name": "Long Road"})
    beyond = chance.uniform(2.5, 10.0)
    ring(drawn, length, around - 1.2, beyond - 1.2, {"highway": "footway"})
    ring(drawn, length, around, beyond, tall)
    return drawn.text()


def house(chance, width, depth):
    """Corners of an outline: a rectangle, or one without a corner of it."""
    if chance.random() < 0.5:
        return [(0.0, 0.0), (width, 0.0), (width, depth), (0.0, depth)]
    u, v = width * chance.uniform(0.3, 0.7), depth * chance.uniform(0.3, 0.7)
    return [(0.0, 0.0), (width, 0.0), (width, v), (u, v), (u, depth), (0.0, depth)]


def ring(drawn, length, half, beyond, tags):
    """A closed way around all houses."""
    corners = [(-beyond, -half), (length + beyond, -half), (length + beyond, half), (-beyond, half)]
    nodes = [drawn.node(*corner) for corner in corners]
    drawn.way(nodes + nodes[:1], tags)


main(walled, __doc__)

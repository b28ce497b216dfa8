"""Writes the maps of the comparison's own worlds, as OSM XML, into a folder: worlds.py FOLDER

Made-up places, all about one point; x and y are metres east and north of it.
"""

import math
import sys
from pathlib import Path
from xml.sax.saxutils import quoteattr

LAT, LON = 40.4980, 117.0
METRES = 111_132.0
AVENUE = [(0, 0), (210, 0), (300, 120), (300, 330), (140, 440), (-60, 420), (-160, 260), (-360, 230)]
BOULEVARD = [(0, 0), (180, 0), (300, -90), (320, -300), (160, -420), (-40, -430), (-180, -290), (-370, -270)]


class Map:
    def __init__(self):
        self.nodes, self.ways = [], []

    def node(self, x, y, **tags):
        lat = LAT + y / METRES
        lon = LON + x / (METRES * math.cos(math.radians(LAT)))
        self.nodes.append((lat, lon, tags))
        return len(self.nodes)

    def way(self, points, **tags):
        refs = [self.node(x, y) for x, y in points]
        if points[0] == points[-1]:
            refs[-1] = refs[0]
        self.ways.append((refs, tags))

    def box(self, west, south, east, north, **tags):
        self.way([(west, south), (east, south), (east, north), (west, north), (west, south)], **tags)

    def write(self, path):
        def tags(tags):
            return "".join(f"<tag k={quoteattr(k.replace('__', ':'))} v={quoteattr(str(v))}/>" for k, v in tags.items())

        lines = ['<?xml version="1.0" encoding="UTF-8"?>', '<osm version="0.6" generator="OpenBench">']
        lines += [
            f'<node id="{i}" version="1" lat="{lat:.8f}" lon="{lon:.8f}">{tags(t)}</node>'
            for i, (lat, lon, t) in enumerate(self.nodes, 1)
        ]
        for i, (refs, t) in enumerate(self.ways, 1):
            nodes = "".join(f'<nd ref="{ref}"/>' for ref in refs)
            lines.append(f'<way id="{i}" version="1">{nodes}{tags(t)}</way>')
        path.write_text("\n".join(lines + ["</osm>", ""]))


def street():
    """A straight street of 240 m between two rows of houses."""
    m = Map()
    m.way([(-20, 0), (240, 0)], highway="residential", name="Long Street", width=6, sidewalk="both")
    for i in range(13):
        x = 18 * i
        m.box(x, 10, x + 11 + i % 3, 20 + i % 2, building="house", building__levels=2)
        m.box(x + 4, -20 - i % 3, x + 15, -10, building="house", building__levels=1 + i % 3)
    return m


def yards():
    """Narrow yards between garden walls, sheds in some, passages of 1.5 m; a house beside them."""
    m = Map()
    m.box(-16, 8, -7, 20, building="house", building__levels=2)
    m.way([(-3, -3), (-3, 33)], highway="footway", width=2)
    for row in range(5):
        y = 7 * row
        for column in range(4):
            x = 8 * column
            gap = x + 1.0 + (row * 3 + column) % 5
            m.way([(x, y), (gap, y)], barrier="wall", height=1.8)
            m.way([(gap + 1.5, y), (x + 8, y)], barrier="wall", height=1.8)
            if row < 4 and (row + column) % 2:
                m.box(x + 5, y + 4, x + 7.5, y + 6.5, building="shed", building__levels=1)
            if row < 4 and column:
                m.way([(x, y + 2), (x, y + 7)], barrier="wall", height=1.8)
    return m


def square():
    """An open square of 140 m: houses far off on two sides, seven trees, a kiosk."""
    m = Map()
    m.box(-70, -70, 70, 70, highway="pedestrian", area="yes", surface="paving_stones")
    m.box(-70, 72, -20, 84, building="yes", building__levels=4)
    m.box(74, -60, 86, 10, building="yes", building__levels=3)
    m.box(20, 18, 23, 21, building="kiosk", building__levels=1)
    for x, y in [(-30, -20), (-31, 14), (8, -33), (40, 30), (-52, 45), (33, -50), (55, 5)]:
        m.node(x, y, natural="tree")
    return m


def corridor():
    """Two smooth walls 2.4 m apart and 120 m long; from within them nothing else is seen."""
    m = Map()
    for x in (-30, 120):
        m.box(x, 8, x + 10, 18, building="house", building__levels=1)
    m.way([(-10, 1.2), (110, 1.2)], barrier="wall", height=2.5)
    m.way([(-10, -1.2), (110, -1.2)], barrier="wall", height=2.5)
    return m


def kerbs():
    """A way between houses with a low kerb across it every four metres."""
    m = Map()
    m.way([(-10, 0), (100, 0)], highway="residential", name="Kerb Lane", width=5)
    for i in range(6):
        m.box(16 * i, 7, 16 * i + 10, 17, building="house", building__levels=2)
        m.box(16 * i + 5, -18, 16 * i + 16, -8, building="house", building__levels=2)
    for i in range(22):
        m.way([(4 * i + 2, -2.4), (4 * i + 2, 2.4)], barrier="kerb", height=0.02)
    return m


def avenue(line=AVENUE):
    """A street of 1.2 km that never comes back to where it was, between houses of all sizes, with gaps among them."""
    m = Map()
    m.way(line, highway="residential", name="Far Avenue", width=6, sidewalk="both")
    number = 0
    for (ax, ay), (bx, by) in zip(line, line[1:]):
        length = math.hypot(bx - ax, by - ay)
        east, north = (bx - ax) / length, (by - ay) / length

        def at(along, left):
            return (ax + east * along - north * left, ay + north * along + east * left)

        for side in (1, -1):
            along = 16.0
            while along < length - 28:
                number += 1
                wide, deep, back = 9 + number * 5 % 7, 8 + number * 3 % 5, 9 + number * 7 % 4
                corners = [(0, back), (wide, back), (wide, back + deep), (0, back + deep), (0, back)]
                m.way([at(along + x, side * y) for x, y in corners], building="house", building__levels=1 + number % 3)
                along += wide + 3 + number * 11 % 13
    return m


def boulevard():
    """Another such street."""
    return avenue(BOULEVARD)


folder = Path(sys.argv[1])
folder.mkdir(parents=True, exist_ok=True)
for make in (street, yards, square, corridor, kerbs, avenue, boulevard):
    make().write(folder / f"{make.__name__}.osm")

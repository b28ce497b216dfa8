"""Draws maps from above, three in a row: picture.py OUT.png MAP.osm...

Needs Pillow. `cargo run --release --package openbench-neighbourhoods --example draw -- KIND SEED`
writes such maps.
"""

import math
import sys
import xml.etree.ElementTree as ElementTree

from PIL import Image, ImageDraw

SIDE = 480
# Drawn larger, then scaled down, so that lines are smooth.
FINE = 2
GROUND = (236, 240, 228)
FENCES = {"hedge": (60, 140, 60), "fence": (150, 110, 60), "wall": (90, 90, 90)}
PAVEMENT_M = 1.8


def tags(element):
    return {tag.get("k"): tag.get("v") for tag in element.findall("tag")}


class Map:
    def __init__(self, path):
        root = ElementTree.parse(path).getroot()
        nodes = root.findall("node")
        # Metres, to about a percent.
        north = sum(float(node.get("lat")) for node in nodes) / len(nodes)
        east = 111_320 * math.cos(math.radians(north))
        self.points = {
            node.get("id"): (float(node.get("lon")) * east, float(node.get("lat")) * 111_320)
            for node in nodes
        }
        self.nodes = [(node.get("id"), tags(node)) for node in nodes]
        self.ways = [
            ([ref.get("ref") for ref in way.findall("nd")], tags(way)) for way in root.findall("way")
        ]
        roles = {}
        for relation in root.findall("relation"):
            for member in relation.findall("member"):
                roles[member.get("ref")] = member.get("role")
        self.roles = [roles.get(way.get("id")) for way in root.findall("way")]


class Picture:
    def __init__(self, osm):
        self.osm = osm
        xs, ys = zip(*osm.points.values())
        self.origin = (min(xs), max(ys))
        self.scale = SIDE * FINE / max(max(xs) - min(xs), max(ys) - min(ys))
        self.image = Image.new("RGB", (SIDE * FINE, SIDE * FINE), GROUND)
        self.draw = ImageDraw.Draw(self.image)

    def at(self, node):
        x, y = self.osm.points[node]
        return ((x - self.origin[0]) * self.scale, (self.origin[1] - y) * self.scale)

    def line(self, nodes, metres, color):
        width = max(1, int(metres * self.scale))
        points = [self.at(node) for node in nodes]
        self.draw.line(points, fill=color, width=width, joint="curve")
        for point in (points[0], points[-1]):
            self.dot(point, width / 2, color)

    def dot(self, point, radius, color, outline=None):
        (x, y) = point
        box = [x - radius, y - radius, x + radius, y + radius]
        self.draw.ellipse(box, fill=color, outline=outline)

    def area(self, nodes, color, outline=None):
        self.draw.polygon([self.at(node) for node in nodes], fill=color, outline=outline)

    def render(self):
        ways = self.osm.ways
        for nodes, tag in ways:
            if "leisure" in tag or "amenity" in tag:
                self.area(nodes, (210, 225, 200) if "leisure" in tag else (220, 220, 225))
        for nodes, tag in ways:
            if "sidewalk" in tag:
                self.line(nodes, float(tag["width"]) + 2 * PAVEMENT_M, (205, 200, 195))
        colors = {"footway": (225, 190, 160), "service": (240, 235, 225)}
        for nodes, tag in sorted(ways, key=lambda way: "name" in way[1]):
            if "highway" in tag:
                color = colors.get(tag["highway"], (252, 252, 252))
                self.line(nodes, float(tag["width"]), color)
        for (nodes, tag), role in zip(ways, self.osm.roles):
            if "building" in tag or role == "outer":
                small = tag.get("building") in ("garage", "shed")
                self.area(nodes, (170, 170, 170) if small else (200, 180, 165), (120, 100, 90))
        for (nodes, _), role in zip(ways, self.osm.roles):
            if role == "inner":
                self.area(nodes, GROUND, (120, 100, 90))
        for nodes, tag in ways:
            if "barrier" in tag:
                self.draw.line([self.at(n) for n in nodes], fill=FENCES[tag["barrier"]], width=3)
        for node, tag in self.osm.nodes:
            if "entrance" in tag:
                self.dot(self.at(node), 5, (220, 0, 0))
            elif tag.get("natural") == "tree":
                self.dot(self.at(node), 1.5 * self.scale, None, (90, 160, 90))
        return self.image.resize((SIDE, SIDE), Image.LANCZOS)


def main(out, *maps):
    rows = (len(maps) + 2) // 3
    sheet = Image.new("RGB", (3 * SIDE + 20, rows * SIDE + 10 * (rows - 1)), (255, 255, 255))
    for i, path in enumerate(maps):
        place = (i % 3 * (SIDE + 10), i // 3 * (SIDE + 10))
        sheet.paste(Picture(Map(path)).render(), place)
    sheet.quantize(64).save(out, optimize=True)


if __name__ == "__main__":
    main(*sys.argv[1:])

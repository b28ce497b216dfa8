"""Maps that scripts of this folder draw, as OpenStreetMap files."""

import math
import sys

METRES_PER_DEGREE = 111_320.0
LATITUDE, LONGITUDE = 48.5, 11.5


class Map:
    """Nodes and ways. Coordinates are metres along the roads and across them."""

    def __init__(self, turn):
        self.turn, self.nodes, self.ways = turn, [], []

    def node(self, x, y):
        east = math.cos(self.turn) * x - math.sin(self.turn) * y
        north = math.sin(self.turn) * x + math.cos(self.turn) * y
        lat = LATITUDE + north / METRES_PER_DEGREE
        lon = LONGITUDE + east / METRES_PER_DEGREE / math.cos(math.radians(LATITUDE))
        self.nodes.append((lat, lon))
        return len(self.nodes)

    def way(self, nodes, tags):
        self.ways.append((nodes, tags))

    def text(self):
        lines = ['<?xml version="1.0"?>', '<osm version="0.6">']
        for number, (lat, lon) in enumerate(self.nodes, 1):
            lines.append(f'<node id="{number}" version="1" lat="{lat:.8f}" lon="{lon:.8f}"/>')
        for number, (nodes, tags) in enumerate(self.ways, 1):
            refs = "".join(f'<nd ref="{node}"/>' for node in nodes)
            said = "".join(f'<tag k="{k}" v="{v}"/>' for k, v in tags.items())
            lines.append(f'<way id="{number}" version="1">{refs}{said}</way>')
        return "\n".join(lines + ["</osm>", ""])


def main(draw, usage):
    """Writes what `draw` makes of a seed: SCRIPT SEED OUT.osm."""
    if len(sys.argv) != 3:
        sys.exit(usage)
    with open(sys.argv[2], "w") as file:
        file.write(draw(int(sys.argv[1])))

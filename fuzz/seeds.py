"""Writes small examples into corpus/TARGET, for the targets that read worlds, meshes, maps, logs and what routing, localization and motion read.

Usage: seeds.py [DATA]     DATA: a folder with `openbench`, `gazebo_models` and `osm`; by default ../../shared/data
"""

import re
import struct
import subprocess
import sys
import tempfile
import zlib
from pathlib import Path

HERE = Path(__file__).resolve().parent
DATA = Path(sys.argv[1]) if len(sys.argv) > 1 else HERE.parent.parent / "shared" / "data"
# Larger files make mutations slow and seldom interesting.
LARGEST = 16_000
WORLD = "<sdf version='1.7'><world name='w'><model name='text_model1'/>%s</world></sdf>"
TRIANGLE = struct.pack("<12fH", 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0)


def put(target, name, content):
    folder = HERE / "corpus" / target
    folder.mkdir(parents=True, exist_ok=True)
    (folder / name).write_bytes(content)


def worlds():
    """Each kind of element once: the models of the published worlds, of different lengths, and their states and lights."""
    seen = set()
    for path in sorted(DATA.glob("openbench/*/*.world")):
        text = path.read_text()
        for i, found in enumerate(re.finditer(r"<(model|light|state|road)\b.*?\n    </\1>", text, re.S)):
            shape = re.sub(r"[0-9.e+-]+", "", found[0])
            if len(found[0]) < LARGEST and shape not in seen:
                seen.add(shape)
                put("sdf", f"{path.stem}-{i}", (WORLD % found[0]).encode())
    for path in sorted(DATA.glob("gazebo_models/*/model.sdf")):
        model = re.search(r"<model\b.*</model>", path.read_text(errors="replace"), re.S)
        put("sdf", path.parent.name, (WORLD % model[0]).encode())


def meshes():
    for number, kind in enumerate(["dae", "obj", "stl"]):
        for path in sorted(DATA.glob(f"gazebo_models/*/meshes/*.{kind}")):
            if path.stat().st_size < LARGEST:
                put("mesh", path.name, bytes([number]) + path.read_bytes())
    put("mesh", "binary.stl", b"\2" + bytes(80) + struct.pack("<I", 1) + TRIANGLE)
    facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet"
    put("mesh", "text.stl", b"\2" + f"solid a\n{facet}\nendsolid a\n".encode())
    put("mesh", "square.obj", b"\1v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nusemtl a\nf 1/1 2/1 3/1 -1/1\n")


TOWN = """<osm version="0.6"><node id="1" lat="0" lon="0"/><node id="2" lat="0" lon="0.001"/><node id="3" lat="0.001" lon="0.001"/>
<node id="4" lat="0.001" lon="0"><tag k="barrier" v="gate"/></node><node id="5" lat="-0.001" lon="0.001"/>
<way id="1"><nd ref="1"/><nd ref="2"/><tag k="highway" v="residential"/><tag k="name" v="South Street"/></way>
<way id="2"><nd ref="2"/><nd ref="3"/><tag k="highway" v="service"/><tag k="access" v="private"/></way>
<way id="3"><nd ref="3"/><nd ref="4"/><nd ref="1"/><tag k="highway" v="footway"/><tag k="oneway" v="yes"/></way>
<way id="4"><nd ref="2"/><nd ref="5"/><tag k="route" v="ferry"/><tag k="duration" v="00:10"/></way>
<way id="5"><nd ref="1"/><nd ref="2"/><nd ref="3"/><nd ref="4"/><nd ref="1"/><tag k="highway" v="pedestrian"/><tag k="area" v="yes"/></way>
<relation id="1"><member type="way" ref="1" role="from"/><member type="way" ref="2" role="via"/><member type="way" ref="3" role="to"/>
<tag k="type" v="restriction"/><tag k="restriction" v="no_u_turn"/></relation>
<relation id="2"><member type="way" ref="5" role="outer"/><tag k="type" v="multipolygon"/><tag k="highway" v="pedestrian"/></relation></osm>"""


def routing():
    """A town, as XML and as a graph file (if the program is built), profiles and addresses."""
    put("roads", "town", TOWN.encode())
    program = HERE.parent / "target/release/openbench"
    if program.exists():
        graph = HERE / "corpus/graph_file/town"
        graph.parent.mkdir(parents=True, exist_ok=True)
        subprocess.run([program, "prepare", "--map", HERE / "corpus/roads/town", "--out", graph], check=True, stdout=subprocess.DEVNULL)
    for path in HERE.parent.glob("crates/routing/profiles/*.toml"):
        put("profile", path.stem, path.read_bytes())
    for number, address in enumerate(
        [
            "/route/v1/foot/3,0;3.001,0.001?steps=true&overview=full&geometries=geojson&annotations=true",
            "/route/v1/foot/3,0;3.001,0;3,0?continue_straight=true&waypoints=0;2&radiuses=unlimited;5;&bearings=90,20;;",
            "/route/v1/foot/polyline(_ibE?_ibE_ibE)?alternatives=3&generate_hints=false&exclude=ferry",
            "/nearest/v1/foot/3,0.0005?number=3",
            "/table/v1/foot/3,0;3.001,0.001;3,0.001?sources=0&destinations=1;2&annotations=duration,distance&fallback_speed=5",
        ]
    ):
        put("osrm_request", str(number), address.encode())


GRAPHS = [
    "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0.1\nEDGE_SE2 0 1 1 0.1 0.1 10 0 0 10 0 100\nFIX 0\n",
    "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\nVERTEX_SE3:QUAT 1 1 0 0 0 0 0.1 0.99\nVERTEX_SE3:QUAT 2 1 1 0 0 0 0 1\n"
    + "".join(f"EDGE_SE3:QUAT {a} {b} 1 0 0 0 0 0 1 9 0 0 0 0 0 9 0 0 0 0 9 0 0 0 9 0 0 9 0 9\n" for a, b in [(0, 1), (1, 2), (2, 0)]),
]


def localization():
    """Graphs; and, if the program is built, the beginning of a log: definitions and some of the IMU's samples."""
    for number, graph in enumerate(GRAPHS):
        put("g2o", str(number), graph.encode())
    program = HERE.parent / "target/release/openbench"
    if program.exists():
        with tempfile.TemporaryDirectory() as folder:
            log = Path(folder) / "log.mcap"
            subprocess.run([program, "record", "small", "--minutes", "0.05", "--out", log], check=True, stdout=subprocess.DEVNULL)
            put("mcap", "beginning", log.read_bytes()[:LARGEST])


def maps():
    for path in [*DATA.glob("openbench/*/*.osm"), *HERE.parent.glob("crates/*/tests/fixtures/*.osm")]:
        put("osm_xml", path.name, path.read_bytes())
    for path in sorted(DATA.glob("osm/*.pbf")):
        head, *rest = blocks(path.read_bytes())
        put("osm_pbf", f"{path.stem}-head", head)
        for i, block in enumerate(sorted(rest, key=len)[:3]):
            if len(block) < 4 * LARGEST:
                put("osm_pbf", f"{path.stem}-{i}", head + block)


def number(value):
    """A number as protocol buffers write it."""
    return bytes([value & 127 | 128]) + number(value >> 7) if value > 127 else bytes([value])


def read_number(data, at):
    value = shift = 0
    while True:
        value, shift, at = value | (data[at] & 127) << shift, shift + 7, at + 1
        if data[at - 1] < 128:
            return value, at


def blocks(content):
    """The blocks of a PBF file, unpacked: what is packed cannot be changed byte by byte."""
    at = 0
    while at < len(content):
        start = at + 4
        end = start + struct.unpack(">I", content[at:start])[0]
        kind = b"OSMHeader" if b"OSMHeader" in content[start:end] else b"OSMData"
        size = content.rindex(b"\x18", start, end) + 1
        length, _ = read_number(content, size)
        blob, at = content[end : end + length], end + length
        raw_size, data = read_number(blob, blob.index(b"\x10") + 1)
        _, data = read_number(blob, data + 1)
        raw = zlib.decompress(blob[data:])
        assert len(raw) == raw_size
        blob = b"\x0a" + number(len(raw)) + raw
        header = b"\x0a" + number(len(kind)) + kind + b"\x18" + number(len(blob))
        yield struct.pack(">I", len(header)) + header + blob


def motion():
    image = bytes([0, 205, 254, 100, 20, 255])
    put("map_server", "binary.pgm", b"P5\n# a comment\n3 2\n255\n" + image)
    put("map_server", "text.pgm", b"P2\n3 2\n255\n" + " ".join(map(str, image)).encode())
    put("map_server", "deep.pgm", b"P5 3 2 65535\n" + image + image)
    rows = b"".join(b"\0" + image[i : i + 3] for i in (0, 3))
    chunks = [(b"IHDR", struct.pack(">IIBBBBB", 3, 2, 8, 0, 0, 0, 0)), (b"IDAT", zlib.compress(rows)), (b"IEND", b"")]
    packed = (struct.pack(">I", len(c)) + k + c + struct.pack(">I", zlib.crc32(k + c)) for k, c in chunks)
    put("map_server", "grey.png", b"\x89PNG\r\n\x1a\n" + b"".join(packed))
    told = "image: a.pgm\nresolution: 0.1\norigin: [-1.0, 2, 0.5]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    put("map_server", "plain.yaml", told.encode())
    put("map_server", "mode.yaml", (told.replace("negate: 0", "negate: true") + "mode: scale\n").encode())


if __name__ == "__main__":
    worlds()
    meshes()
    maps()
    routing()
    localization()
    motion()

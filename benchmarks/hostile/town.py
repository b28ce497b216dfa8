"""A small town: every file that the commands read, in valid form."""

import struct
import subprocess
import zlib

HOUSES = [(10.0, 0.0), (0.0, 14.0)]
DOORS = [(8.2, 0.0, 90.0), (0.0, 12.2, 180.0)]


def world(more=""):
    plane = "<geometry><plane><normal>0 0 1</normal><size>100 100</size></plane></geometry>"
    text = (
        "<sdf version='1.7'><world name='town'><model name='ground_plane'><static>1</static>"
        f"<link name='l'><visual name='v'>{plane}</visual><collision name='c'>{plane}</collision>"
        "</link></model>\n"
    )
    box = "<geometry><box><size>3.6 3.6 3</size></box></geometry>"
    for unit, ((x, y), (dx, dy, yaw)) in enumerate(zip(HOUSES, DOORS), 1):
        text += (
            f"<model name='house_{unit}'><static>1</static><pose>{x} {y} 1.5 0 0 0</pose>"
            f"<link name='l'><visual name='v'>{box}</visual><collision name='c'>{box}</collision>"
            "</link></model>\n"
            f"<model name='text_model{unit}'><pose>{dx} {dy} 1.2 0 0 {yaw / 57.29578}</pose>"
            "<link name='l'><visual name='v'><geometry><mesh>"
            f"<uri>model://text_model{unit}/meshes/fire2.dae</uri></mesh></geometry></visual>"
            "</link></model>\n"
        )
    return text + more + "</world></sdf>\n"


def degrees(x, y):
    return f"lat='{y / 110574.3:.8f}' lon='{3.0 + x / 111319.5:.8f}'"


def osm(more=""):
    text = "<?xml version='1.0'?>\n<osm version='0.6'>\n"
    corners = [(-1.8, -1.8), (1.8, -1.8), (1.8, 1.8), (-1.8, 1.8)]
    for i, (x, y) in enumerate(HOUSES, 1):
        for k, (dx, dy) in enumerate(corners):
            text += f"<node id='{10 * i + k}' {degrees(x + dx, y + dy)}/>\n"
        nodes = "".join(f"<nd ref='{10 * i + k}'/>" for k in [0, 1, 2, 3, 0])
        text += (
            f"<way id='{10 * i}'>{nodes}<tag k='building' v='yes'/>"
            f"<tag k='name' v='building{i}'/></way>\n"
        )
    for k, (x, y) in enumerate([(0, -20), (0, 0), (30, 0)], 1):
        text += f"<node id='{k}' {degrees(x, y)}/>\n"
    text += (
        "<way id='1'><nd ref='1'/><nd ref='2'/><nd ref='3'/>"
        "<tag k='highway' v='residential'/></way>\n"
    )
    return text + more + "</osm>\n"


SUITE = """name = "town"

[world.imported]
world = "town.world"
map = "town.osm"
models = []
georeference = "tangent:3,0"

[traffic]
pedestrians = 2

[[episodes]]
instruction = "To unit1, building1."
deliveries = [{ building = "building1", unit = "unit1" }]
"""

PROFILE = """[speeds]
residential = 4.0
"""

ROBOT = """imu = { xyz = [0.1, 0.0, 0.4] }
lidar = { xyz = [0.1, 0.0, 0.5], rpy = [0.0, 0.0, 0.0] }
range_noise = 0.02
"""

RECORDER = (
    "timestamp,status,address,robot_x,robot_y,robot_z\n"
    "1.0,start,unit1 building1,0,0,0\n9.0,end,unit1 building1,7.0,0,0\n"
)


def varint(n):
    n &= (1 << 64) - 1
    out = bytearray()
    while True:
        out.append(n & 127 | (128 if n > 127 else 0))
        n >>= 7
        if not n:
            return bytes(out)


def field(number, payload):
    if isinstance(payload, int):
        return varint(number << 3) + varint(payload)
    return varint(number << 3 | 2) + varint(len(payload)) + payload


def blob(kind, content, compress=True):
    body = field(3, zlib.compress(content, 9)) if compress else field(1, content)
    header = field(1, kind) + field(3, len(body))
    return struct.pack(">I", len(header)) + header + body


def pbf(groups, compress=True):
    """A PBF file of one block with these primitive groups."""
    table = field(1, field(1, b"") + field(1, b"highway") + field(1, b"residential"))
    block = table + b"".join(field(2, group) for group in groups)
    header = field(4, b"OsmSchema-V0.6") + field(4, b"DenseNodes")
    return blob(b"OSMHeader", header) + blob(b"OSMData", block, compress)


def dense(count, id_delta=2, lat_delta=2, lon_delta=2):
    """A group of so many packed nodes, each so far from the one before (zigzag)."""
    deltas = [bytes([delta]) * count for delta in (id_delta, lat_delta, lon_delta)]
    nodes = field(1, deltas[0]) + field(8, deltas[1]) + field(9, deltas[2])
    return field(2, nodes)


def write(folder, binary):
    """Writes every file into a folder. Those of the program itself are made by it."""
    texts = {
        "town.world": world(),
        "town.osm": osm(),
        "one.txt": "To unit1, building1.\n",
        "one.jsonl": '{"instruction": "To unit1, building1.", '
        '"deliveries": [{"building": "building1", "unit": "unit1"}]}\n',
        "truth.txt": "(8.2, 0.0)\n",
        "suite.toml": SUITE,
        "profile.toml": PROFILE,
        "robot.toml": ROBOT,
        "recorder.csv": RECORDER,
        "answers.jsonl": "",
        "memory.osm": osm(),
    }
    for name, text in texts.items():
        (folder / name).write_text(text)
    (folder / "town.pbf").write_bytes(pbf([dense(50)]))

    def run(words):
        subprocess.run([binary, *words.split()], cwd=folder, check=True, capture_output=True)

    run("prepare --map town.osm --out graph")
    run("record small --minutes 0.1 --out log.mcap")
    run(
        "run --world town.world --map town.osm --georef tangent:3,0 --deliveries one.jsonl "
        "--set reader=truth --out done"
    )

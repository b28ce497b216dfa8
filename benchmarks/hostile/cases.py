"""The hostile inputs: damaged files, values that mean nothing, and files that mean too much."""

import random
from dataclasses import dataclass, field

import town

HERE = "run --world town.world --map town.osm --georef tangent:3,0"
QUICK = "--set reader=truth --record none --out new"
DELIVER = f"{HERE} --deliveries one.jsonl {QUICK}"


@dataclass
class Case:
    """A command line, and what is done to the folder of files before it."""

    name: str
    words: list
    files: dict = field(default_factory=dict)
    # Called with the folder.
    prepare: object = None


def case(name, words, files=None, prepare=None):
    return Case(name, words.split() if isinstance(words, str) else words, files or {}, prepare)


# Which command reads which file.
READERS = {
    "town.world": DELIVER,
    "town.osm": DELIVER,
    "one.jsonl": DELIVER,
    "one.txt": f"{HERE} --deliveries one.txt --targets planner {QUICK}",
    "truth.txt": f"{HERE} --deliveries one.txt --truth truth.txt {QUICK}",
    "suite.toml": f"run suite.toml {QUICK}",
    "memory.osm": f"{DELIVER} --memory memory.osm",
    "answers.jsonl": f"{HERE} --deliveries one.jsonl --set reader=replay:answers.jsonl --record none --out new",
    "profile.toml": "route --map town.osm --profile profile.toml 3,0 3.0001,0",
    "graph": "route --map graph 3,0 3.0001,0",
    "town.pbf": "costmap --map town.pbf --out map.yaml",
    "robot.toml": "odometry log.mcap --robot robot.toml --out way.tum",
    "log.mcap": "odometry log.mcap --out way.tum",
    "recorder.csv": "evaluate --log recorder.csv --truth truth.txt",
    "done/run.json": "verify done",
    "done/results.json": "verify done",
    "done/episodes/000.actions.json": "verify done",
}


def damages(content, seed):
    """Damaged forms of a file."""
    draw = random.Random(seed)
    half = len(content) // 2
    yield "empty", b""
    yield "one byte", content[:1]
    yield "a quarter", content[: len(content) // 4]
    yield "half", content[:half]
    yield "all but the last byte", content[:-1]
    yield "random bytes", draw.randbytes(5000)
    yield "zeros", bytes(100_000)
    yield "no UTF-8", content[:half] + b"\xff\xfe\xfd" + content[half:]
    yield "NUL inside", content[:half] + b"\0" + content[half:]
    yield "UTF-16", content.decode("latin-1").encode("utf-16")
    yield "a byte order mark", b"\xef\xbb\xbf" + content
    yield "twice", content + content
    yield "megabytes in one line", b"9" * 5_000_000
    yield "deep braces", b"{" * 200_000
    yield "deep brackets", b"[" * 200_000
    yield "deep elements", b"<a>" * 200_000
    for flips in (1, 20):
        flipped = bytearray(content or b"x")
        for _ in range(flips):
            flipped[draw.randrange(len(flipped))] ^= 1 << draw.randrange(8)
        yield f"{flips} bits flipped", bytes(flipped)


def damaged_files(folder):
    for seed, (name, words) in enumerate(READERS.items()):
        content = (folder / name).read_bytes()
        for damage, damaged in damages(content, seed):
            yield case(f"{name}: {damage}", words, {name: damaged})
        yield case(f"{name}: missing", words, prepare=lambda f, n=name: (f / n).unlink())

        def fold(f, n=name):
            (f / n).unlink()
            (f / n).mkdir()

        def loop(f, n=name):
            (f / n).unlink()
            (f / n).symlink_to((f / n).name)

        def sparse(f, n=name):
            with open(f / n, "r+b") as file:
                file.truncate(20 << 30)

        yield case(f"{name}: a folder", words, prepare=fold)
        yield case(f"{name}: a link to itself", words, prepare=loop)
        yield case(f"{name}: 20 GB of zeros", words, prepare=sparse)


VALUES = ["", "nan", "inf", "-1", "1e308", "18446744073709551616", "0x10", "1,2", "ü", "-0"]
OPTIONS = {
    "run small --seed": ["--out", "new"],
    "run small --jobs": ["--out", "new"],
    "run small --pedestrians": ["--out", "new", "--set", "reader=none"],
    "run small --set budget={}": [],
    "run small --set fixes=disturbed-truth:{}": [],
    "record small --out a.mcap --minutes": [],
    "record small --out a.mcap --minutes 0.01 --imu-range": [],
    "record small --out a.mcap --minutes 0.01 --gap": [],
    "world generate --map town.osm --out w --radius": ["--around", "3,0"],
    "world generate --map town.osm --out w --planting": [],
    "world generate --map town.osm --out w --parked-cars": [],
    "world show small --out a.png --from": [],
    "world show small --out a.png --above": [],
    "costmap --map town.osm --out a.yaml --around": [],
    "prepare --map town.osm --out g --cells": [],
    "route --map town.osm 3,0 3.0001,0 --radius": [],
    "route --map town.osm 3,0 3.0001,0 --alternatives": [],
    "route --map town.osm 3,0": [],
    f"{DELIVER} --georef": [],
    "serve --map town.osm --listen": [],
}
# Values that are right, so that the command would begin its work; which is not what is tested here.
RIGHT = {
    ("run small --seed", "-0"),
    ("run small --jobs", "-0"),
    ("serve --map town.osm --listen", "-0"),
    ("run small --set fixes=disturbed-truth:{}", ""),
}


def odd_values():
    for begin, rest in OPTIONS.items():
        for value in VALUES:
            if (begin, value) in RIGHT:
                continue
            words = begin.split()
            if "{}" in begin:
                words = [word.replace("{}", value) for word in words]
            else:
                # In one word, since a value may begin with a hyphen.
                words = words[:-1] + [f"{words[-1]}={value}"] if words[-1][:2] == "--" else [
                    *words,
                    value,
                ]
            yield case(f"{begin} {value!r}", words + rest)


def node(number, x, y):
    return f"<node id='{number}' {town.degrees(x, y)}/>"


def way(number, nodes, tags):
    refs = "".join(f"<nd ref='{n}'/>" for n in nodes)
    return f"<way id='{number}'>{refs}" + "".join(
        f"<tag k='{k}' v='{v}'/>" for k, v in tags.items()
    ) + "</way>"


def odd_maps():
    """Maps that are well-formed, but that no place on Earth has."""
    house = {"building": "yes"}
    ring = "".join(node(100 + i, 40 + (i % 2) * 4, 40 + (i // 2) * 4) for i in range(4))
    odd = {
        "an element with all numbers out of range": "<node id='9' lat='1e300' lon='-1e300'/>",
        "a node of no number": "<node id='nine' lat='0' lon='3'/>",
        "the largest number": f"<node id='{2**63 - 1}' lat='0' lon='3'/>",
        "a number too large": f"<node id='{2**64}' lat='0' lon='3'/>",
        "a building of one point": way(90, [1, 1, 1, 1], house),
        "a building without nodes": way(90, [], house),
        "a building of unknown nodes": way(90, [7001, 7002, 7003, 7001], house),
        "a building that crosses itself": ring + way(90, [100, 103, 101, 102, 100], house),
        "a building of a million kilometres": ring
        + way(90, [100, 101, 103, 100], {**house, "height": "1e12"}),
        "a building of no height": ring
        + way(90, [100, 101, 103, 100], {**house, "height": "-5", "building:levels": "nan"}),
        "a road of 100,000 equal points": way(91, [1] * 100_000, {"highway": "footway"}),
        "a road of 100,000 points there and back": way(91, [1, 2] * 50_000, {"highway": "path"}),
        "a road as wide as the world": way(91, [1, 2], {"highway": "footway", "width": "1e9"}),
        "a relation of itself": "<relation id='5'><member type='relation' ref='5' role=''/>"
        "<tag k='type' v='multipolygon'/></relation>",
        "relations in a ring": "".join(
            f"<relation id='{i}'><member type='relation' ref='{i % 50 + 1}' role='outer'/>"
            "<tag k='type' v='multipolygon'/><tag k='building' v='yes'/></relation>"
            for i in range(1, 51)
        ),
        "a thousand buildings at one place": ring
        + "".join(way(1000 + i, [100, 101, 103, 102, 100], house) for i in range(1000)),
        "a name of a megabyte": way(92, [1, 2], {"highway": "footway", "name": "x" * 1_000_000}),
        "a restriction of nothing": "<relation id='6'><tag k='type' v='restriction'/></relation>",
        "markup in names": ring
        + way(90, [100, 101, 103, 100], {**house, "name": "&lt;script&gt;alert(1)&lt;/script&gt;"}),
    }
    for name, more in odd.items():
        files = {"town.osm": town.osm(more).encode()}
        yield case(f"map: {name}", DELIVER, files)
        yield case(f"map, generated: {name}", "world generate --map town.osm --out w", files)
    entities = "<!DOCTYPE osm [<!ENTITY a 'aaaaaaaaaa'>" + "".join(
        f"<!ENTITY {chr(98 + i)} '{f'&{chr(97 + i)};' * 10}'>" for i in range(9)
    ) + "]>"
    bomb = town.osm().replace("?>", f"?>{entities}", 1).replace("building1", "&j;")
    yield case("map: a billion laughs", DELIVER, {"town.osm": bomb.encode()})
    outside = "<!DOCTYPE osm [<!ENTITY a SYSTEM 'file:///etc/passwd'>]>"
    leak = town.osm().replace("?>", f"?>{outside}", 1).replace("building1", "&a;")
    yield case("map: an entity from a file", DELIVER, {"town.osm": leak.encode()})


def odd_binaries():
    costmap = "costmap --map town.pbf --out a.yaml"
    route = "route --map town.pbf 3,0 3.0001,0"
    small = town.field(2, 0)
    odd = {
        "ten million packed nodes": town.pbf([town.dense(10_000_000)]),
        "ten million equal nodes": town.pbf([town.dense(10_000_000, 0, 0, 0)]),
        "nodes beyond the Earth": town.pbf([town.dense(100_000, 254 & 127, 126, 126)]),
        "a way of ten million nodes": town.pbf(
            [town.field(3, town.field(1, 1) + town.field(8, b"\2" * 10_000_000))]
        ),
        "a hundred thousand empty ways": town.pbf([town.field(3, b"") * 100_000]),
        "tags without strings": town.pbf(
            [town.field(3, town.field(1, 1) + town.field(2, b"\x7f" * 9) + town.field(3, b"\x7f"))]
        ),
        "groups without an end": town.pbf([b"\x0a\xff\xff\xff\xff\x0f"]),
        "a granularity of zero": town.pbf([small, town.dense(100)]),
        "another compression": town.blob(b"OSMData", b"")[:-4] + b"\x22\1\0\0",
        "a block of zeros": town.blob(b"OSMData", bytes(30 << 20)),
        "a blob that is too long": b"\0\0\0\x0d\x0a\7OSMData\x18" + town.varint(1 << 40),
        "a negative size": b"\0\0\0\x13\x0a\7OSMData\x18" + town.varint(-1),
    }
    for name, content in odd.items():
        for command in (costmap, route):
            files = {"town.pbf": content}
            yield case(f"PBF: {name}, {command.split()[0]}", command, files)


def odd_worlds():
    mesh = "<model name='m'><link name='l'><visual name='v'><geometry><mesh><uri>{}</uri></mesh>" \
        "</geometry></visual></link></model>"
    shape = "<model name='m'>{}<link name='l'><collision name='c'><geometry>{}</geometry>" \
        "</collision></link></model>"
    box = "<box><size>{}</size></box>"
    odd = {
        "a mesh outside of the folder": mesh.format("../../../../etc/passwd"),
        "a mesh of another scheme": mesh.format("http://localhost/a.dae"),
        "a mesh that is the world": mesh.format("town.world"),
        "a mesh that is a device": mesh.format("/dev/zero"),
        "a model that includes itself": "<include><uri>model://town.world</uri></include>",
        "a box without an end": shape.format("", box.format("inf inf inf")),
        "a box of no size": shape.format("", box.format("0 -1 nan")),
        "a box as large as the Earth": shape.format("", box.format("1e9 1e9 1e9")),
        "a pose of words": shape.format("<pose>a b c</pose>", box.format("1 1 1")),
        "a pose too far away": shape.format("<pose>1e30 0 0 0 0 0</pose>", box.format("1 1 1")),
        "a sphere of no radius": shape.format("", "<sphere><radius>-1</radius></sphere>"),
        "a height map": shape.format("", "<heightmap><uri>town.osm</uri></heightmap>"),
        "models inside models": "<model name='m'>" * 300 + "</model>" * 300,
        "ten thousand boxes": "".join(
            f"<model name='b{i}'><pose>{i % 100} {i // 100 + 20} 0 0 0 0</pose><link name='l'>"
            "<collision name='c'><geometry><box><size>1 1 1</size></box></geometry></collision>"
            "</link></model>"
            for i in range(10_000)
        ),
    }
    for name, more in odd.items():
        yield case(f"world: {name}", DELIVER, {"town.world": town.world(more).encode()})


def odd_suites():
    base = town.SUITE
    odd = {
        "a million people": base.replace("pedestrians = 2", "pedestrians = 1000000"),
        "a billion cars": base.replace("pedestrians = 2", "cars = 1000000000"),
        "people below zero": base.replace("pedestrians = 2", "pedestrians = -1"),
        "no episodes": base.split("[[episodes]]")[0],
        "no deliveries": base.replace('{ building = "building1", unit = "unit1" }', ""),
        "an unknown door": base.replace("building1\",", "nowhere\","),
        "an order of doors that are not there": base + "before = [[0, 9]]\n",
        "an order in a ring": base + "before = [[0, 0]]\n",
        "a world that is the suite": base.replace("town.world", "suite.toml"),
        "a world outside": base.replace("town.world", "../../../../etc/passwd"),
        "two worlds": base.replace("[traffic]", "[world.builtin]\nname='small'\nseed=1\n[traffic]"),
        "an unknown key": base.replace("[traffic]", "[trafic]"),
        "an instruction of a megabyte": base.replace("To unit1", "x " * 500_000 + "To unit1"),
        "markup in the name": base.replace('"town"', '"<script>alert(1)</script>"', 1),
        "a path in the name": base.replace('"town"', '"../../name"', 1),
        "the same key twice": base.replace("[traffic]", "name = 'again'\n[traffic]"),
    }
    for name, text in odd.items():
        yield case(f"suite: {name}", f"run suite.toml {QUICK}", {"suite.toml": text.encode()})


def odd_places():
    """Outputs that cannot be written, and inputs that would be overwritten."""
    for words in (
        "prepare --map town.osm --out {}",
        "costmap --map town.osm --out {}.yaml",
        "odometry log.mcap --out {}",
        "record small --minutes 0.01 --out {}.mcap",
        "world show small --out {}.png",
        "world generate --map town.osm --out {}",
        f"{HERE} --deliveries one.jsonl --set reader=truth --out {{}}",
        f"{HERE} --deliveries one.jsonl --set reader=truth --record none --out new --memory {{}}",
    ):
        for out in (
            "/dev/full",
            "/proc/self/nothing",
            "town.osm",
            "town.osm/inside",
            ".",
            "x" * 300,
            "nowhere/at/all",
        ):
            yield case(f"{words.split()[0]} to {out[:20]}", words.format(out))

    def own_map(folder):
        (folder / "mine").mkdir()
        (folder / "mine" / "map.osm").write_text(town.osm())

    yield case(
        "a world in place of its map",
        "world generate --map mine/map.osm --out mine",
        prepare=own_map,
    )


def odd_models():
    for setting in ("planner", "reader"):
        for model in (
            "openai:x@127.0.0.1:5091",
            "openai:x@http://user:hunter2@127.0.0.1:9/v1",
            "openai:x@http://127.0.0.1:9/v1?key=hunter2",
            "openai:x@ftp://127.0.0.1/",
            "openai:x@http://",
            "openai:",
            "local:../../etc/passwd",
            "replay:/etc/passwd",
            "replay:/dev/zero",
            "nobody",
            "a,,b",
            ",",
        ):
            yield case(f"{setting}={model}", f"{DELIVER} --set {setting}={model}")
    for other in ("fixes=gnss", "localizer=", "motion=../x", "ground=sand", "=", "a=b=c", "budget=1"):
        yield case(f"--set {other}", f"{DELIVER} --set {other}")


def all_cases(folder):
    yield from damaged_files(folder)
    yield from odd_values()
    yield from odd_maps()
    yield from odd_binaries()
    yield from odd_worlds()
    yield from odd_suites()
    yield from odd_places()
    yield from odd_models()

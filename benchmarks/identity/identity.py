#!/usr/bin/env python3
"""What a binary of ours computes, written down so that two commits can be compared.

`record` runs suites, plans, generated worlds and routes with one binary and writes a manifest:
actions and chains of states, every number of `results.json` but machine times, plans, SHA-256 of
worlds and routes. `compare` prints each entry in which two manifests differ, and ends with status
1 if there is any.

What is done already is not done again, so an interrupted recording goes on where it stopped.
"""

import argparse
import collections
import concurrent.futures
import csv
import hashlib
import json
import os
import pathlib
import subprocess
import sys
import tomllib
import urllib.error
import urllib.request

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
# Keys of `results.json` that a machine's speed decides, and what says which binary ran.
LEFT_OUT = {"wall_seconds", "real_time_factor", "build"}
SUITES = [("small", 0), ("small", 1), ("small", 2), ("medium", 0), ("large", 0)]
PUBLISHED_SEEDS = {"small": [0, 1, 2], "medium": [0]}
# Extract, longitude and latitude of the middle, seed of the world.
WINDOWS = [
    ("monaco.osm.pbf", "7.4197,43.7314", 3),
    ("krems_austria.osm.pbf", "15.6030,48.4115", 6),
    ("bayreuth_north_germany.osm.pbf", "11.6010,49.9810", 4),
    ("heidelberg_germany.osm.pbf", "8.7095,49.4118", 5),
    ("ajou_campus.osm", "127.0440,37.2830", 2),
]
ROUTES_MAP = "porto_portugal.osm.pbf"


class Recorder:
    """Runs one binary and keeps what it computed in a folder."""

    def __init__(self, binary, data, folder):
        self.binary = str(binary)
        self.data = data
        self.folder = folder
        # A seed once drew noise alone. Where it draws a neighbourhood, noise has its own option.
        usage = self.call("run", "--help").decode()
        self.seed = "--noise-seed" if "--noise-seed" in usage else "--seed"

    def once(self, name, compute):
        """The entry `name` of the manifest, computed unless it is there already."""
        path = self.folder / f"{name}.json"
        if not path.exists():
            print(f"recording {name}", file=sys.stderr)
            entry = compute()
            partial = path.with_suffix(".part")
            partial.write_text(json.dumps(entry))
            partial.rename(path)
        return json.loads(path.read_text())

    def call(self, *arguments):
        """Standard output of the binary; its errors are shown if it fails."""
        command = [self.binary, *map(str, arguments)]
        ran = subprocess.run(command, capture_output=True)
        if ran.returncode != 0:
            sys.exit(f"{' '.join(command)} failed:\n{ran.stderr.decode()}")
        return ran.stdout

    def suite(self, name, arguments, seed):
        """Results and actions of a suite's episodes."""
        out = self.folder / "runs" / name
        self.call("run", *arguments, self.seed, seed, "--record", "thin", "--out", out)
        actions = sorted((out / "episodes").glob("*.actions.json"))
        return {
            "results": compared(json.loads((out / "results.json").read_text())),
            "episodes": {path.name: actions_of(path) for path in actions},
        }

    def published(self, size):
        """Arguments that name a published world and its deliveries."""
        folder = self.data / "openbench" / size
        truth = {"small": "delivery_instructions_small_gt", "medium": "delivery_instructions_gt_medium"}
        return [
            *("--world", folder / f"{size}_osm.world"),
            *("--map", folder / f"{size}.osm"),
            *("--models", self.data / "gazebo_models"),
            *("--deliveries", folder / f"delivery_instructions_{size}.txt"),
            *("--truth", folder / f"{truth[size]}.txt"),
        ]

    def plans(self):
        """What is planned for each instruction at hand, by its number and text."""
        folder = ROOT / "crates/trials/data/instructions"
        cases = []
        for path in sorted(folder.glob("*.jsonl")):
            for line in path.read_text().splitlines():
                case = json.loads(line)
                cases.append((path.stem, folder / f"{case.get('map') or 'estate'}.osm", case))
        shared = self.data / "language/instructions.json"
        small = self.data / "openbench/small/small.osm"
        cases += [(shared.stem, small, case) for case in json.loads(shared.read_text())]

        def plan(case):
            source, osm, case = case
            command = [self.binary, "plan", "--map", str(osm), case["instruction"]]
            ran = subprocess.run(command, capture_output=True)
            words = ran.stdout if ran.returncode == 0 else f"status {ran.returncode}".encode()
            return source, case["instruction"], words.decode()

        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            planned = list(pool.map(plan, cases))
        return {f"{i}: {source}: {text}": words for i, (source, text, words) in enumerate(planned)}

    def world(self, extract, around, seed):
        """Hashes of a generated world: its files, a picture from above, what sensors see in it."""
        name = extract.split(".")[0]
        folder = self.folder / "worlds" / name
        where = ["--around", around, "--radius", 120]
        osm = self.data / "osm" / extract
        self.call("world", "generate", "--map", osm, *where, "--seed", seed, "--out", folder)
        picture = folder.with_suffix(".png")
        self.call("world", "show", folder, "--out", picture)
        drive = folder.with_suffix(".mcap")
        self.call("record", folder, "--minutes", 0.25, "--seed", seed, "--out", drive)
        files = sorted(path for path in folder.iterdir() if path.is_file())
        return {path.name: sha256(path) for path in [*files, picture, drive]}

    def routes(self):
        """Hashes of the answers to a thousand requests for routes."""
        osm = self.data / "osm" / ROUTES_MAP
        command = [self.binary, "serve", "--map", str(osm), "--listen", "127.0.0.1:0"]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT) as server:
            try:
                address = next(word for line in server.stdout for word in addresses(line))
                with open(ROOT / "benchmarks/routing/pairs.csv") as rows:
                    return [answer(address, row) for row in csv.reader(rows)]
            finally:
                server.terminate()

    def record(self):
        """All entries of the manifest."""
        entries = {}
        for suite, seed in SUITES:
            name = f"{suite}-{seed}"
            entries[name] = self.once(name, lambda: self.suite(name, [suite], seed))
        for size, seeds in PUBLISHED_SEEDS.items():
            for seed in seeds:
                name = f"published-{size}-{seed}"
                entries[name] = self.once(name, lambda: self.suite(name, self.published(size), seed))
        entries["plans"] = self.once("plans", self.plans)
        for extract, around, seed in WINDOWS:
            name = f"world-{extract.split('.')[0]}"
            entries[name] = self.once(name, lambda: self.world(extract, around, seed))
        entries["routes"] = self.once("routes", self.routes)
        return entries


def compared(value):
    """`value` without what no two runs of two commits share."""
    if isinstance(value, dict):
        return {k: compared(v) for k, v in value.items() if k not in LEFT_OUT}
    if isinstance(value, list):
        return [compared(item) for item in value]
    return value


def actions_of(path):
    """The chain over an episode's states, and a hash over its velocities."""
    actions = json.loads(path.read_text())
    driven = json.dumps(actions["driven"], sort_keys=True).encode()
    return {"chain": actions["chain"], "velocities": hashlib.sha256(driven).hexdigest()}


def sha256(path):
    """Of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def addresses(line):
    """Words of a line of output that are addresses to connect to."""
    words = line.decode().replace("http://", "").split()
    return [word.rstrip("/.,") for word in words if word.startswith("127.0.0.1:")]


def answer(address, row):
    """Hash of a server's answer to a request for a route."""
    lon, lat, to_lon, to_lat = row
    url = f"http://{address}/route/v1/foot/{lon},{lat};{to_lon},{to_lat}?steps=true&geometries=geojson"
    try:
        with urllib.request.urlopen(url) as response:
            body = response.read()
    except urllib.error.HTTPError as error:
        body = error.read()
    return hashlib.sha256(body).hexdigest()


def translated(text, table):
    """`text` with the old names in it replaced by the new ones."""
    for old, new in table.items():
        text = text.replace(old, new)
    return text


def renamed(value, table):
    """`value` with old names replaced in keys and texts."""
    if isinstance(value, dict):
        return {translated(k, table): renamed(v, table) for k, v in value.items()}
    if isinstance(value, list):
        return [renamed(item, table) for item in value]
    return translated(value, table) if isinstance(value, str) else value


def differences(old, new, added, where=""):
    """Where two values differ, as lines of text. Keys that only the new one has are counted in
    `added`: what a commit reports in addition does not change what it computes."""
    if isinstance(old, dict) and isinstance(new, dict):
        for key in sorted(old.keys() | new.keys()):
            if key not in old:
                added[key] += 1
            elif key not in new:
                yield f"{where}/{key}: only in the old one"
            else:
                yield from differences(old[key], new[key], added, f"{where}/{key}")
    elif isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        for i, pair in enumerate(zip(old, new)):
            yield from differences(*pair, added, f"{where}/{i}")
    elif old != new:
        yield f"{where}: {str(old)[:200]} -> {str(new)[:200]}"


def main():
    """Entry point."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    commands = parser.add_subparsers(dest="command", required=True)
    record = commands.add_parser("record", help="run a binary and write its manifest")
    record.add_argument("binary", type=pathlib.Path)
    record.add_argument("data", type=pathlib.Path, help="folder with openbench, osm, language")
    record.add_argument("folder", type=pathlib.Path, help="for runs and manifest.json")
    compare = commands.add_parser("compare", help="print where two manifests differ")
    compare.add_argument("old", type=pathlib.Path)
    compare.add_argument("new", type=pathlib.Path)
    compare.add_argument("--names", type=pathlib.Path, help="TOML table: old name = new name")
    arguments = parser.parse_args()
    if arguments.command == "record":
        arguments.folder.mkdir(parents=True, exist_ok=True)
        recorder = Recorder(arguments.binary.resolve(), arguments.data, arguments.folder)
        manifest = json.dumps(recorder.record(), indent=1, sort_keys=True)
        (arguments.folder / "manifest.json").write_text(manifest)
        return
    names = tomllib.loads(arguments.names.read_text()) if arguments.names else {}
    old = renamed(compared(json.loads(arguments.old.read_text())), names)
    added = collections.Counter()
    found = list(differences(old, compared(json.loads(arguments.new.read_text())), added))
    for key, count in sorted(added.items()):
        print(f"only in the new one: {key} ({count} times)")
    print("\n".join(found) if found else "identical")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""The results of measure.sh as tables: python3 tables.py FOLDER

Prints Markdown: a line for each row of measure.sh and each of its peers. Then come, for registration
alone, a line for each world, and times and errors along the way.
"""

import json
import pathlib
import sys

HEAD = [
    "row", "by", "drives", "3 m after 0 / 20 / 40 / 60 m", "1 m after 40 m", "yaw 2°", "accepted",
    "fixes", "wrong", "inside 95 %", "NEES", "wall 0.5 m",
]


def percent(share, digits=0):
    return "–" if share is None else f"{100 * share:.{digits}f} %"


def line(cells):
    return "| " + " | ".join(cells) + " |"


def header(names):
    return "\n".join([line(names), line(["---"] * len(names))])


def scores(one):
    """The cells of a report."""
    within = [one["recall"][f"{metres}m"]["3"] for metres in (0, 20, 40, 60)]
    nees = one["nees_mean"]
    return [
        str(one["n"]),
        " / ".join(percent(share).removesuffix(" %") for share in within) + " %",
        percent(one["recall"]["40m"]["1"]),
        percent(one["yaw"]["2"]),
        percent(one["accepted"], 1),
        f"{one['fixes']:,}",
        str(one["wrong_5m"]),
        percent(one["inside_95"], 1),
        "–" if nees is None else f"{nees:.1f}",
        percent(one["wall_relative"]["0.5"], 1),
    ]


def main():
    """Entry point."""
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    paths = sorted(pathlib.Path(sys.argv[1]).glob("*.json"))
    reports = {path.stem: json.loads(path.read_text()) for path in paths}
    print(header(HEAD))
    for row, one in reports.items():
        print(line([row, "registration", *scores(one)]))
        for peer, other in one.get("peers", {}).items():
            print(line([row, peer, *scores(other)]))
    print("\n" + header(["row", "world", *HEAD[2:]]))
    for row, one in reports.items():
        for world, apart in one["worlds"].items():
            print(line([row, world, *scores(apart)]))
    names = ["row", "rejected", "while located: ms, median / 99 %", "to find: ms, median / 99 %"]
    print("\n" + header([*names, "along: located", "within 1 m", "at 95 %"]))
    for row, one in reports.items():
        cells = [row, percent(one["rejected_off_map"], 1)]
        for kind in ("ms", "find_ms"):
            times = [one[f"{kind}_p50"], one[f"{kind}_p99"]]
            cells.append(" / ".join("–" if ms is None else f"{ms:.1f}" for ms in times))
        along = one["along"]
        cells += [percent(along["located"], 1), percent(along["within_1m"], 1)]
        cells.append("–" if along["p95_m"] is None else f"{along['p95_m']:.2f} m")
        print(line(cells))


if __name__ == "__main__":
    main()

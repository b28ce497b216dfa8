#!/usr/bin/env python3
"""Draws how often poses of a given probability are right, and what trusting them costs.

    openbench bench localization WORLD... --level city --start block --examples FILE.jsonl
    python3 benchmarks/localization/reliability.py OUT.svg FILE.jsonl...

Left, the reliability diagram: the best place after each five metres of all drives, by probability.
Right, risk over coverage. For each probability, coverage is the share of poses above it, and risk
is the share of these that is wrong. Prints both as numbers.
"""

import math
import sys

from candidates import RIGHT_M, binned, drives, error, places

LIMITS = [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.98]
COVERAGES = [0.2, 0.4, 0.6, 0.8, 0.9, 1.0]
#: Ends of the logarithmic axis of wrong poses.
MOST_RISK, LEAST_RISK = 1.0, 1e-4
#: Standard deviations of an interval of 95 %.
Z = 1.96
SIDE, MARGIN, GAP = 300, 60, 90


def best_places(paths):
    """Probability of the best place of each attempt, and whether it is right."""
    return [best(ones) for attempts in drives(paths).values() for ones in attempts]


def best(ones):
    found = places([one["pose"] for one in ones], [one["probability"] for one in ones])
    index, probability = found[0]
    return probability, error(ones[index]) < RIGHT_M


def wilson(right, count):
    """Interval of 95 % of a share."""
    share, square = right / count, Z * Z / count
    middle = (share + square / 2) / (1 + square)
    half = Z / (1 + square) * math.sqrt(share * (1 - share) / count + square / (4 * count))
    return middle - half, middle + half


def reliability(judged):
    """Mean probability, share that is right, its interval, and number, for each bin."""
    for _, ones in binned(judged, LIMITS, lambda one: one[0]):
        right = sum(one[1] for one in ones)
        mean = sum(one[0] for one in ones) / len(ones)
        yield mean, right / len(ones), wilson(right, len(ones)), len(ones)


def risks(judged):
    """Coverage and risk, poses of high probability first."""
    wrong, curve = 0, []
    for number, (_, right) in enumerate(sorted(judged, reverse=True), 1):
        wrong += not right
        curve.append((number / len(judged), wrong / number))
    return curve


class Chart:
    """A square with two axes; x and y go from 0 to 1."""

    def __init__(self, left, title, labels, ticks):
        self.left, self.parts = left, []
        self.text(0.5, 1.05, title, "middle")
        self.text(0.5, -0.16, labels[0], "middle")
        x, y = self.at(-0.16, 0.5)
        rotated = f'transform="rotate(-90 {x:.1f} {y:.1f})"'
        place = f'x="{x:.1f}" y="{y:.1f}" text-anchor="middle"'
        self.parts.append(f"<text {place} {rotated}>{labels[1]}</text>")
        for at, label in ticks[0]:
            self.line([(at, 0), (at, 1)], "grid")
            self.text(at, -0.07, label, "middle")
        for at, label in ticks[1]:
            self.line([(0, at), (1, at)], "grid")
            self.text(-0.02, at - 0.015, label, "end")

    def at(self, x, y):
        return self.left + x * SIDE, MARGIN / 2 + (1 - y) * SIDE

    def text(self, x, y, words, anchor):
        px, py = self.at(x, y)
        self.parts.append(f'<text x="{px:.1f}" y="{py:.1f}" text-anchor="{anchor}">{words}</text>')

    def line(self, points, kind):
        path = " ".join(f"{x:.1f},{y:.1f}" for x, y in (self.at(*point) for point in points))
        self.parts.append(f'<polyline class="{kind}" points="{path}"/>')

    def dot(self, x, y):
        px, py = self.at(x, y)
        self.parts.append(f'<circle cx="{px:.1f}" cy="{py:.1f}" r="3"/>')


def reliability_chart(bins):
    shares = [(i / 5, f"{20 * i}") for i in range(6)]
    labels = ("probability of the best pose, %", "right, %")
    chart = Chart(MARGIN, "Reliability", labels, (shares, shares))
    chart.line([(0, 0), (1, 1)], "ideal")
    for mean, share, (low, high), _ in bins:
        chart.line([(mean, low), (mean, high)], "error")
        chart.dot(mean, share)
    return chart


def risk_chart(curve):
    decades = round(math.log10(MOST_RISK / LEAST_RISK))
    ticks = [(i / decades, f"{100 * LEAST_RISK * 10**i:g}") for i in range(decades + 1)]
    shares = [(i / 5, f"{20 * i}") for i in range(6)]
    labels = ("coverage: poses that are trusted, %", "risk: wrong ones of them, %")
    chart = Chart(MARGIN + SIDE + GAP, "Risk over coverage", labels, (shares, ticks))

    def height(risk):
        return math.log10(max(risk, LEAST_RISK) / LEAST_RISK) / decades

    # A point for each half percent is fine enough.
    step = max(1, len(curve) // 200)
    chart.line([(coverage, height(risk)) for coverage, risk in curve[::step] + curve[-1:]], "curve")
    return chart


STYLE = """<style>
text { font: 12px sans-serif; fill: #333 }
polyline { fill: none }
.grid { stroke: #ddd }
.ideal { stroke: #999; stroke-dasharray: 4 4 }
.error { stroke: #2a6fb0; stroke-width: 1.5 }
.curve { stroke: #b0402a; stroke-width: 2 }
circle { fill: #2a6fb0 }
</style>"""


def main():
    """Entry point."""
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    judged = best_places(sys.argv[2:])
    bins, curve = list(reliability(judged)), risks(judged)
    print(f"{len(judged)} best poses")
    for mean, share, (low, high), count in bins:
        print(f"said {mean:.3f}, right {share:.3f} ({low:.3f} to {high:.3f}) of {count}")
    for coverage in COVERAGES:
        _, risk = curve[max(0, round(coverage * len(curve)) - 1)]
        print(f"of the {100 * coverage:.0f} % most probable, {100 * risk:.2f} % are wrong")
    width, height = 2 * SIDE + GAP + MARGIN + 20, SIDE + 1.5 * MARGIN
    parts = reliability_chart(bins).parts + risk_chart(curve).parts
    with open(sys.argv[1], "w") as file:
        file.write(
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}">\n{STYLE}\n'
            f'<rect width="{width}" height="{height}" fill="#fff"/>\n'
            + "\n".join([*parts, "</svg>"])
            + "\n"
        )


if __name__ == "__main__":
    main()

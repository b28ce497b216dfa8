#!/usr/bin/env python3
"""Fits the probabilities of candidate poses, and tries rules by which a pose is accepted.

    openbench bench localization WORLD... --level good --start block --examples FILE.jsonl
    python3 benchmarks/localization/fit.py FILE.jsonl...

Probabilities are a conditional logit (McFadden 1974) over the candidates of an attempt and one
more choice: none of them. Each world is judged with weights that were fitted to the others. Prints
the weights for all worlds together, how many poses are right at each probability, and what each
rule accepts along the drives. Needs NumPy.
"""

import collections
import json
import math
import sys

import numpy

#: A candidate nearer than this to the truth is right, metres and radians.
RIGHT_M, RIGHT_RAD = 3.0, 0.15
#: Strength of the penalty on large weights.
RIDGE = 1e-3
#: Poses of one hypothesis agree within this, metres and radians.
SAME_M, SAME_RAD = 3.0, 0.1
#: As in registration/hypothesis.rs: least information along any direction, and distance of places
#: where few buildings are seen.
LEAST_INFORMATION = 0.15
FEW_BUILDINGS, FEW_APART_M = 3, 15.0
#: Indices of two features: log(1 + number of buildings) and log(0.1 + least information).
BUILDINGS, INFORMATION = 7, 8


class Attempt:
    """The candidates after some metres of a drive."""

    def __init__(self, ones):
        self.metres = ones[0]["metres"]
        self.features = numpy.array([one["features"] for one in ones])
        self.starts = [one["start"] for one in ones]
        self.errors = numpy.array([error(one) for one in ones])
        best = int(self.errors.argmin())
        self.right = best if self.errors[best] < RIGHT_M else -1
        self.probabilities = None


def error(one):
    """Metres from the truth; far if the heading is wrong or the robot beside the map."""
    if one["error_m"] is None or one["error_rad"] > RIGHT_RAD:
        return 1e9
    return one["error_m"]


def drives(paths):
    """The attempts of each drive, by world, level, start and number."""
    grouped = collections.defaultdict(lambda: collections.defaultdict(list))
    for path in paths:
        with open(path) as file:
            for line in file:
                world, level, start, one = json.loads(line)
                key = (world, level, start, one["case"])
                grouped[key][one["metres"]].append(one)
    return {
        key: [Attempt(ones) for _, ones in sorted(attempts.items())]
        for key, attempts in grouped.items()
    }


def probabilities(features, weights):
    logits = numpy.append(features @ weights, 0.0)
    values = numpy.exp(logits - logits.max())
    return (values / values.sum())[:-1]


def fit(attempts):
    """Newton's method on the penalized likelihood."""
    count = attempts[0].features.shape[1]
    weights = numpy.zeros(count)
    scale = 1.0 / len(attempts)
    for _ in range(60):
        gradient = -RIDGE * weights
        hessian = RIDGE * numpy.eye(count)
        for one in attempts:
            p = probabilities(one.features, weights)
            mean = p @ one.features
            gradient -= scale * mean
            if one.right >= 0:
                gradient += scale * one.features[one.right]
            hessian += scale * ((one.features.T * p) @ one.features - numpy.outer(mean, mean))
        step = numpy.linalg.solve(hessian, gradient)
        weights += step
        if numpy.abs(step).max() < 1e-6:
            break
    return weights


def is_same(a, b):
    turn = math.remainder(a[2] - b[2], math.tau)
    return math.hypot(a[0] - b[0], a[1] - b[1]) < SAME_M and abs(turn) < SAME_RAD


def accepted(attempts, rule):
    """The first attempt whose best pose is accepted, and its error; None without one."""
    bank = []
    for attempt in attempts:
        order = numpy.argsort(-attempt.probabilities)
        following = []
        for i in order:
            start, p = attempt.starts[i], attempt.probabilities[i]
            known = [past for other, past in bank if is_same(start, other)]
            following.append((start, (known[0] if known else []) + [(attempt.metres, p)]))
        bank = following
        if bank and is_certain(bank[0][1], attempt.features[order[0]], rule):
            return attempt.metres, attempt.errors[order[0]]
    return None


def is_certain(confirmations, features, rule):
    if math.exp(features[INFORMATION]) - 0.1 < LEAST_INFORMATION:
        return False
    least_apart = FEW_APART_M if math.exp(features[BUILDINGS]) - 1.0 < FEW_BUILDINGS - 0.5 else 0.0
    now = confirmations[-1][1]
    return any(
        now >= limit and places(confirmations, limit, max(apart, least_apart)) >= count
        for limit, count, apart in rule
    )


def places(confirmations, limit, apart):
    """At how many places so far apart the probability was so high."""
    last, count = -math.inf, 0
    for metres, p in confirmations:
        if p >= limit and metres - last >= apart:
            last, count = metres, count + 1
    return count


#: Each a list of probability, number of places, metres between them.
RULES = {
    "0.998 | 2 x 0.98 | 3 x 0.95 / 10 m": [(0.998, 1, 0), (0.98, 2, 10), (0.95, 3, 10)],
    "0.9995 | 2 x 0.98 | 3 x 0.95 / 10 m": [(0.9995, 1, 0), (0.98, 2, 10), (0.95, 3, 10)],
    "0.9999 | 2 x 0.95 | 3 x 0.9 / 10 m": [(0.9999, 1, 0), (0.95, 2, 10), (0.9, 3, 10)],
    "0.9999 | 2 x 0.97 | 3 x 0.9 / 10 m": [(0.9999, 1, 0), (0.97, 2, 10), (0.9, 3, 10)],
    # The one of registration/hypothesis.rs.
    "0.9999 | 2 x 0.98 | 3 x 0.95 / 10 m": [(0.9999, 1, 0), (0.98, 2, 10), (0.95, 3, 10)],
    "0.9999 | 2 x 0.98 | 3 x 0.95 / 15 m": [(0.9999, 1, 0), (0.98, 2, 15), (0.95, 3, 15)],
}


def main():
    found = drives(sys.argv[1:])
    worlds = sorted({key[0] for key in found})
    for world in worlds:
        others = [one for key, ones in found.items() if key[0] != world for one in ones]
        weights = fit(others)
        for key, ones in found.items():
            if key[0] == world:
                for one in ones:
                    one.probabilities = probabilities(one.features, weights)
    judged = []
    for ones in found.values():
        for one in ones:
            best = int(one.probabilities.argmax())
            judged.append((one.probabilities[best], one.errors[best]))
    print("probability of the best pose: attempts, share that is right")
    limits = [0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 0.95, 0.98, 0.99, 0.995, 0.998, 1.0]
    for low, high in zip(limits, limits[1:]):
        ones = [one for one in judged if low <= one[0] < high]
        if ones:
            right = sum(error < RIGHT_M for _, error in ones)
            mean = sum(one[0] for one in ones) / len(ones)
            print(f"{low:5}-{high:<5} {len(ones):6} {right / len(ones):.3f} for {mean:.3f}")
    for name, rule in RULES.items():
        print(name)
        table = collections.defaultdict(list)
        for key, ones in found.items():
            table[key[2], key[1]].append(accepted(ones, rule))
        for key, ones in sorted(table.items()):
            within = [
                sum(one is not None and one[0] < metres + 1 for one in ones) / len(ones)
                for metres in (0, 20, 40, 60)
            ]
            wrong = sum(one is not None and one[1] >= 5.0 for one in ones)
            shares = " ".join(f"{100 * share:4.0f}" for share in within)
            print(f"  {key[0]:>6} {key[1]:>5} {len(ones):5} drives, accepted {shares} %, {wrong} wrong")
    weights = fit([one for ones in found.values() for one in ones])
    print("[" + ", ".join(f"{value:.3f}" for value in weights) + "]")


main()

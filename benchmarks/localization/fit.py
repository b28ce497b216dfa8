#!/usr/bin/env python3
"""Fits the probabilities of candidate poses, and tries rules by which a pose is accepted.

    openbench bench localization WORLD... --level good --start block --examples FILE.jsonl
    python3 benchmarks/localization/fit.py FILE.jsonl...

Probabilities are a conditional logit (McFadden 1974) over the candidates of an attempt and one
more choice: none of them. Poses of one place are judged together, with the sum of their
probabilities. Each world is judged with weights that were fitted to the others. Prints the weights
for all worlds together, how many poses are right at each probability, and what each rule accepts
along the drives. Needs NumPy.
"""

import collections
import math
import sys

import numpy

from candidates import RIGHT_M, binned, carried, drives, error, is_same, places

#: Strength of the penalty on large weights.
RIDGE = 1e-4
#: An attempt beside the map counts so much. Half of all attempts are there, so that what rejects
#: them is learnt; of robots that get a map, few are. As in registration/probability.rs, the odds of
#: none of the candidates are higher by as much where nothing is known of the start.
BESIDE = 0.2
#: As in registration/hypothesis.rs: a pose that becomes less probable is confirmed anew,
DOUBTFUL = 0.9
#: least information along any direction, distance of places where few buildings are seen, and the
#: fewest that are told by several places.
LEAST_INFORMATION = 0.15
FEW_BUILDINGS, FEW_APART_M, LEAST_BUILDINGS = 4, 15.0, 2
#: Attempts come every five metres; so far from a distance they count as there.
HALF_A_LEG_M = 2.5


class Attempt:
    """The candidates after some metres of a drive."""

    def __init__(self, ones, is_beside):
        self.share = BESIDE if is_beside else 1.0
        self.odds_of_none = 1.0 / self.share
        self.metres = ones[0]["metres"]
        self.features = numpy.array([one["features"] for one in ones])
        self.buildings = [one["buildings"] for one in ones]
        self.weakest = [one["weakest"] for one in ones]
        self.poses = [one["pose"] for one in ones]
        self.odom = ones[0]["odom"]
        self.errors = numpy.array([error(one) for one in ones])
        #: Several poses of one place may be right.
        self.is_right = self.errors < RIGHT_M


class Place:
    """The best pose of a place, with the probability of all poses there."""

    def __init__(self, attempt, index, probability):
        self.least_information = attempt.weakest[index]
        self.buildings = attempt.buildings[index]
        self.pose, self.odom = attempt.poses[index], attempt.odom
        self.error = attempt.errors[index]
        self.probability = probability


def probabilities(features, weights, odds_of_none):
    logits = numpy.append(features @ weights, math.log(odds_of_none))
    values = numpy.exp(logits - logits.max())
    return (values / values.sum())[:-1]


def fit(attempts):
    """Newton's method on the penalized likelihood: that one of the right candidates is chosen, or
    none of them where none is right."""
    features, is_there, is_right = arrays(attempts)
    shares = numpy.array([one.share for one in attempts])
    shares /= shares.sum()
    weights = numpy.zeros(features.shape[2])
    likelihood = -math.inf
    step = numpy.zeros_like(weights)
    for _ in range(100):
        every = Choice(features, is_there, weights + step, shares)
        right = Choice(features, is_right, weights + step, shares)
        reached = right.log_odds - every.log_odds - 0.5 * RIDGE * ((weights + step) ** 2).sum()
        if reached < likelihood:
            # The likelihood is not concave, and the step was too long.
            step *= 0.5
            continue
        weights = weights + step
        likelihood = reached
        gradient = right.mean - every.mean - RIDGE * weights
        hessian = every.covariance - right.covariance + RIDGE * numpy.eye(len(weights))
        if numpy.linalg.eigvalsh(hessian)[0] <= 0.0:
            hessian = every.covariance + RIDGE * numpy.eye(len(weights))
        step = numpy.linalg.solve(hessian, gradient)
        if numpy.abs(step).max() < 1e-6:
            return weights
    sys.exit("the fit does not converge")


def arrays(attempts):
    """Features of all candidates, which of them there are, and which are right. The last one of
    each attempt is none of them."""
    most = max(len(one.features) for one in attempts)
    features = numpy.zeros((len(attempts), most + 1, attempts[0].features.shape[1]))
    is_there = numpy.zeros(features.shape[:2], bool)
    is_right = numpy.zeros(features.shape[:2], bool)
    for i, one in enumerate(attempts):
        count = len(one.features)
        features[i, :count] = one.features
        is_there[i, :count] = True
        is_right[i, :count] = one.is_right
    is_there[:, -1] = True
    is_right[:, -1] = ~is_right.any(axis=1)
    return features, is_there, is_right


class Choice:
    """What is chosen among some of the candidates: mean and covariance of its features, and the
    logarithm of their odds together, over attempts that have their shares."""

    def __init__(self, features, among, weights, shares):
        logits = numpy.where(among, features @ weights, -numpy.inf)
        most = logits.max(axis=1, keepdims=True)
        odds = numpy.exp(logits - most)
        self.log_odds = shares @ (most[:, 0] + numpy.log(odds.sum(axis=1)))
        chosen = odds / odds.sum(axis=1, keepdims=True)
        means = numpy.einsum("ij,ijk->ik", chosen, features)
        weighted = features * (chosen * shares[:, None])[:, :, None]
        squares = numpy.tensordot(weighted, features, ([0, 1], [0, 1]))
        self.mean = shares @ means
        self.covariance = squares - (means * shares[:, None]).T @ means


def judged_by(attempt, weights):
    """The places of an attempt, the most probable one first."""
    chances = probabilities(attempt.features, weights, attempt.odds_of_none)
    found = places(attempt.poses, chances)
    return [Place(attempt, i, probability) for i, probability in found]


def accepted(attempts, rule):
    """The first place that is accepted, as metres driven and its error; None without one. Takes
    the metres and the places of each attempt."""
    bank = []
    for metres, found in attempts:
        following = []
        for place in found:
            known = (past for other, past in bank if continues(place, other))
            past = next(known, []) if place.probability >= DOUBTFUL else []
            following.append((place, past + [(metres, place.probability)]))
        bank = following
        if bank and is_certain(bank[0][1], found[0], rule):
            return metres, found[0].error
    return None


def continues(place, earlier):
    """Whether the robot, if it was at the earlier place, is at this one now."""
    return is_same(place.pose, carried(earlier.pose, earlier.odom, place.odom))


def is_certain(confirmations, place, rule):
    if place.least_information < LEAST_INFORMATION:
        return False
    least_apart = FEW_APART_M if place.buildings < FEW_BUILDINGS else 0.0
    now = confirmations[-1][1]
    return any(
        now >= limit and distant(confirmations, limit, max(apart, least_apart)) >= count
        for limit, count, apart in rule
        if count == 1 or place.buildings >= LEAST_BUILDINGS
    )


def distant(confirmations, limit, apart):
    """At how many places so far apart the probability was so high."""
    last, count = -math.inf, 0
    for metres, p in confirmations:
        if p >= limit and metres - last >= apart:
            last, count = metres, count + 1
    return count


#: Each a list of probability, number of places, metres between them.
RULES = {
    "0.999 | 2 x 0.99 | 3 x 0.98 / 10 m": [(0.999, 1, 0), (0.99, 2, 10), (0.98, 3, 10)],
    "0.9999 | 2 x 0.98 | 3 x 0.95 / 10 m": [(0.9999, 1, 0), (0.98, 2, 10), (0.95, 3, 10)],
    "0.9999 | 2 x 0.99 | 3 x 0.97 / 10 m": [(0.9999, 1, 0), (0.99, 2, 10), (0.97, 3, 10)],
    # The one of registration/hypothesis.rs.
    "0.9999 | 2 x 0.99 | 3 x 0.98 / 10 m": [(0.9999, 1, 0), (0.99, 2, 10), (0.98, 3, 10)],
    "0.9999 | 2 x 0.99 | 4 x 0.95 / 10 m": [(0.9999, 1, 0), (0.99, 2, 10), (0.95, 4, 10)],
}


def main():
    read = drives(sys.argv[1:])
    found = {
        key: [Attempt(ones, key[2] == "off") for ones in attempts] for key, attempts in read.items()
    }
    judged = judge(found)
    print_reliability(
        [
            (ones[0], attempt.share)
            for key, attempts in found.items()
            for attempt, (_, ones) in zip(attempts, judged[key])
        ]
    )
    for name, rule in RULES.items():
        print(name)
        table = collections.defaultdict(list)
        for key, ones in judged.items():
            table[key[2], key[1]].append(accepted(ones, rule))
        for key, ones in sorted(table.items()):
            within = [
                sum(one is not None and one[0] < metres + HALF_A_LEG_M for one in ones) / len(ones)
                for metres in (0, 20, 40, 60)
            ]
            wrong = sum(one is not None and one[1] >= 5.0 for one in ones)
            shares = " ".join(f"{100 * share:4.0f}" for share in within)
            row = f"  {key[0]:>6} {key[1]:>5} {len(ones):5} drives"
            print(f"{row}, accepted {shares} %, {wrong} wrong")
    weights = fit([one for ones in found.values() for one in ones])
    print("[" + ", ".join(f"{value:.3f}" for value in weights) + "]")


def judge(found):
    """Metres and places of each attempt of each drive, with weights fitted to other worlds."""
    judged = {}
    for world in sorted({key[0] for key in found}):
        others = [one for key, ones in found.items() if key[0] != world for one in ones]
        weights = fit(others)
        for key, ones in found.items():
            if key[0] == world:
                judged[key] = [(one.metres, judged_by(one, weights)) for one in ones]
    return judged


def print_reliability(attempts):
    print("probability of the best place: attempts, share that is right")
    limits = [0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 0.95, 0.98, 0.99, 0.995, 0.998]
    for low, ones in binned(attempts, limits, lambda one: one[0].probability):
        every = sum(share for _, share in ones)
        right = sum(share for place, share in ones if place.error < RIGHT_M) / every
        mean = sum(share * place.probability for place, share in ones) / every
        print(f"from {low:<5} {len(ones):6} {right:.3f} for {mean:.3f}")


main()

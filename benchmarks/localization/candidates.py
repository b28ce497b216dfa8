"""Candidate poses as `openbench bench localization --examples FILE.jsonl` writes them."""

import collections
import json
import math

#: A candidate nearer than this to the truth is right, metres and radians.
RIGHT_M, RIGHT_RAD = 3.0, 0.15
#: Poses of one place agree within this, metres and radians, as in registration/hypothesis.rs.
SAME_M, SAME_RAD = 3.0, 0.1


def drives(paths):
    """The candidates of each drive by world, level, start, number and file: a list of attempts in
    the order of the metres driven, each a list of candidates. Rows of one level and start differ in
    the place whose map the robot got, so files are kept apart."""
    grouped = collections.defaultdict(lambda: collections.defaultdict(list))
    for path in paths:
        with open(path) as file:
            for line in file:
                world, level, start, one = json.loads(line)
                key = world, level, start, one["case"], path
                grouped[key][one["metres"]].append(one)
    return {key: [ones for _, ones in sorted(tries.items())] for key, tries in grouped.items()}


def error(one):
    """Metres from the truth; far if the heading is wrong or the robot beside the map."""
    if one["error_m"] is None or one["error_rad"] > RIGHT_RAD:
        return 1e9
    return one["error_m"]


def is_same(a, b):
    """Whether two poses are at one place."""
    turn = math.remainder(a[2] - b[2], math.tau)
    return math.hypot(a[0] - b[0], a[1] - b[1]) < SAME_M and abs(turn) < SAME_RAD


def carried(pose, before, now):
    """Where a robot is on the map that was at `pose` there, by its poses in `odom`."""
    forward, left = turned(now[0] - before[0], now[1] - before[1], -before[2])
    x, y = turned(forward, left, pose[2])
    return pose[0] + x, pose[1] + y, pose[2] + now[2] - before[2]


def turned(x, y, angle):
    cosine, sine = math.cos(angle), math.sin(angle)
    return cosine * x - sine * y, sine * x + cosine * y


def places(poses, probabilities):
    """Poses of different places, the most probable one first, as `distinct` of
    registration/hypothesis.rs: the index of the best pose of each place, and the sum of the
    probabilities there."""
    sums = {}
    for i in sorted(range(len(poses)), key=lambda i: -probabilities[i]):
        known = next((k for k in sums if is_same(poses[k], poses[i])), i)
        sums[known] = sums.get(known, 0.0) + probabilities[i]
    return sorted(sums.items(), key=lambda place: -place[1])


def binned(judged, limits, probability):
    """Those of the judged with a probability from one limit up to the next; rounding may give more
    than 1."""
    for low, high in zip(limits, [*limits[1:], math.inf]):
        ones = [one for one in judged if low <= probability(one) < high]
        if ones:
            yield low, ones

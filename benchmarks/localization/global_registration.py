#!/usr/bin/env python3
"""Global registration by KISS-Matcher, refined by small_gicp, for `bench localization --peer`.

    pip install kiss-matcher small_gicp numpy
    openbench bench localization medium-102 --peer benchmarks/localization/global_registration.py

Both packages compare clouds of points in space, so walls and facades are raised to 3 m. What was
seen on the last 40 m is compared with all walls that may be in sight, again after each 5 m. Of the
matcher's pose and the last one, which odometry carries on, that with more points near walls is
kept, after both are refined.
"""

import json
import math
import os
import sys

import kiss_matcher
import numpy as np
import small_gicp

#: Sides of voxels and distances between points, metres. The matcher's other settings are its own.
VOXEL_M = 1.0
SPACING_M = 0.5
HEIGHTS_M = np.arange(0.0, 3.01, SPACING_M)
#: So much of the way is compared: 8 stretches of 5 m.
STRETCHES = 8
#: Walls farther away are not compared.
REACH_M = 80.0
#: With fewer points than this nothing is compared.
FEWEST = 10
#: Points farther from all walls are left out of the refinement.
FARTHEST_M = 4.0


def raised(points):
    """Points on the ground, repeated up to the height of a storey."""
    return np.array([[x, y, z] for x, y in points for z in HEIGHTS_M]).reshape(-1, 3)


def sampled(walls):
    """Points on walls."""
    points = []
    for x0, y0, x1, y1 in walls:
        count = max(1, math.ceil(math.hypot(x1 - x0, y1 - y0) / SPACING_M))
        points += [
            (x0 + (x1 - x0) * i / count, y0 + (y1 - y0) * i / count) for i in range(count)
        ]
    return np.array(points).reshape(-1, 2)


def matrix(x, y, yaw):
    """A pose in the plane as a transform of space."""
    cosine, sine = math.cos(yaw), math.sin(yaw)
    return np.array([[cosine, -sine, 0, x], [sine, cosine, 0, y], [0, 0, 1, 0], [0, 0, 0, 1.0]])


def flat(transform):
    """The pose in the plane that a transform of space is nearest to."""
    yaw = math.atan2(transform[1, 0], transform[0, 0])
    return [float(transform[0, 3]), float(transform[1, 3]), yaw]


class Matcher:
    """Finds the robot anew after each stretch."""

    def __init__(self, walls, guess, knows_heading, within_m):
        del knows_heading  # The matcher needs no heading.
        #: Clouds are about the first guess: the matcher computes in single precision.
        self.middle = np.array([*guess[:2], 0.0])
        points = sampled(walls) - self.middle[:2]
        # The way is short beside what may be in sight.
        self.walls = raised(points[np.linalg.norm(points, axis=1) < within_m + REACH_M])
        self.target = prepared(self.walls) if len(self.walls) else None
        #: From the frame of odometry to the map.
        self.to_map = None
        self.guess = guess
        self.seen = []

    def take(self, end, facades):
        """The pose at the end of a stretch."""
        self.seen = [*self.seen, facades][-STRETCHES:]
        if self.to_map is None:
            self.to_map = matrix(*self.guess) @ np.linalg.inv(matrix(*end))
        points = [tuple(point) for stretch in self.seen for point in stretch]
        if len(points) > FEWEST and self.target is not None:
            self.match(raised(points))
        return flat(self.to_map @ matrix(*end))

    def match(self, points):
        """Estimates the transform anew: the pose so far and that of the matcher are refined."""
        carried = self.to_map.copy()
        carried[:3, 3] -= self.middle
        source = prepared(points)
        firsts = [carried, *matched(points, self.walls)]
        results = [refined(self.target, source, first) for first in firsts]
        best = max(results, key=lambda one: (one.num_inliers, -one.error))
        x, y, yaw = flat(best.T_target_source)
        self.to_map = matrix(x + self.middle[0], y + self.middle[1], yaw)


def prepared(points):
    """A cloud for GICP, thinned out, with its tree."""
    return small_gicp.preprocess_points(points, VOXEL_M / 2)


def matched(points, walls):
    """The transform that the matcher finds, if any."""
    matcher = kiss_matcher.KISSMatcher(kiss_matcher.KISSMatcherConfig(VOXEL_M, use_quatro=True))
    found = matcher.estimate(list(points.astype(np.float32)), list(walls.astype(np.float32)))
    if not found.valid:
        return []
    transform = np.eye(4)
    transform[:3, :3], transform[:3, 3] = found.rotation, np.ravel(found.translation)
    return [transform]


def refined(target, source, first):
    """A transform refined by GICP."""
    (walls, tree), (points, _) = target, source
    return small_gicp.align(
        walls, points, tree, first, "GICP", max_correspondence_distance=FARTHEST_M
    )


def main():
    """Entry point."""
    # What the packages print goes to the standard error.
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    matcher = None
    for line in sys.stdin:
        request = json.loads(line)
        if "begin" in request:
            matcher = Matcher(**request["begin"])
            answer = {}
        else:
            answer = {"pose": matcher.take(**request["stretch"])}
        print(json.dumps(answer), file=answers, flush=True)


if __name__ == "__main__":
    main()

"""Do two engines hit the same? Counts, and the largest differences, over arrays of ranges in metres with 0 for no hit."""

import numpy as np

TOLERANCE = 1e-3  # metres
JITTER = 1e-5  # radians: half a millimetre at 50 m, a hundredth of what one beam of the sensor covers
COPIES = 16


def compare(ours, theirs, max_range):
    """How well the ranges agree, and the indices of the rays on which they do not."""
    ours, theirs = ours.astype(np.float64), theirs.astype(np.float64)
    # A hit within the tolerance of the end of the range may be a miss for the other.
    limit = max_range - TOLERANCE
    misses = [(a == 0.0) | (a >= limit) for a in (ours, theirs)]
    both_hit = (ours > 0.0) & (theirs > 0.0)
    difference = np.where(both_hit, np.abs(ours - theirs), 0.0)
    agree = np.where(both_hit, difference <= TOLERANCE, misses[0] & misses[1])
    wrong = np.flatnonzero(~agree)
    largest = np.argsort(difference)[::-1][:5]
    return {
        "agree_share": float(agree.mean()),
        "hit_or_miss_agree_share": float((both_hit | (misses[0] & misses[1])).mean()),
        "disagreeing_rays": int(len(wrong)),
        "median_difference_m": float(np.median(difference[both_hit])) if both_hit.any() else None,
        "largest_differences_m": [
            {"ray": int(i), "ours": float(ours[i]), "theirs": float(theirs[i])} for i in largest if difference[i] > 0.0
        ],
    }, wrong


def unexplained(dump, rays, distances):
    """Of `rays`, those whose range of ours is not among what rays turned by up to JITTER meet, and thus is wrong rather than at an edge.

    `distances(origins, directions)` casts; `max_range` stands for no hit there and here.
    """
    if len(rays) == 0:
        return rays
    rng = np.random.default_rng(1)
    directions = np.repeat(dump.directions[rays].astype(np.float64), COPIES, axis=0)
    directions += rng.uniform(-JITTER, JITTER, directions.shape)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    met = distances(np.repeat(dump.origins[rays], COPIES, axis=0), directions.astype(np.float32)).reshape(-1, COPIES)
    ours = np.where(dump.ranges[rays] > 0.0, dump.ranges[rays], dump.max_range)
    within = (ours >= met.min(axis=1) - TOLERANCE) & (ours <= met.max(axis=1) + TOLERANCE)
    return rays[~within]

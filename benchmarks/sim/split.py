"""Cuts triangles into compact parts, for engines that are faster with many small meshes than with one, or cannot take a large one."""

import numpy as np


def parts(triangles, most):
    """Index arrays of at most `most` triangles each: halved at the median of the widest axis of their middles until small enough."""
    middles = triangles.mean(axis=1)
    done, waiting = [], [np.arange(len(triangles))]
    while waiting:
        part = waiting.pop()
        if len(part) <= most:
            done.append(part)
            continue
        axis = int(np.argmax(np.ptp(middles[part], axis=0)))
        order = part[np.argsort(middles[part, axis], kind="stable")]
        waiting += [order[: len(order) // 2], order[len(order) // 2 :]]
    return done

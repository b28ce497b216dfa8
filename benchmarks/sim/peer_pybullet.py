"""Bullet through PyBullet, without a server: static concave meshes and `rayTestBatch` on one thread.

`rayTestBatch` takes Python lists and gives tuples, which costs time of its own. The same rays are therefore also cast in an empty world; `binding_seconds` is
that time, and a second rate is stated without it.
"""

from importlib.metadata import version

import numpy as np
import pybullet

import split

RAYS = 16_000  # at once; of 16,384 (MAX_RAY_INTERSECTION_BATCH_SIZE_STREAMING) or more, rayTestBatch drops the rest without a word
CUTS = (40_000, 5_000, 500)  # most triangles in a mesh; createCollisionShape takes 131,072 corners


class PyBullet:
    name = "PyBullet"
    version = version("pybullet")

    def __init__(self, dump, most):
        self.dump, self.most = dump, min(most, len(dump.triangles))
        origins = dump.origins.astype(np.float64)
        ends = origins + dump.directions.astype(np.float64) * dump.max_range
        self.batches = [(origins[i : i + RAYS].tolist(), ends[i : i + RAYS].tolist()) for i in range(0, len(origins), RAYS)]
        self.empty = pybullet.connect(pybullet.DIRECT)
        self.client = pybullet.connect(pybullet.DIRECT)
        meshes = self.add_scene(most)
        self.note = f"{meshes} mesh" if meshes == 1 else f"{meshes} meshes"

    def add_scene(self, most):
        cut = split.parts(self.dump.triangles, most)
        for part in cut:
            vertices, corners = np.unique(self.dump.triangles[part].reshape(-1, 3), axis=0, return_inverse=True)
            shape = pybullet.createCollisionShape(
                pybullet.GEOM_MESH,
                vertices=vertices.tolist(),
                indices=corners.ravel().tolist(),
                flags=pybullet.GEOM_FORCE_CONCAVE_TRIMESH,
                physicsClientId=self.client,
            )
            pybullet.createMultiBody(0.0, shape, physicsClientId=self.client)
        return len(cut)

    def cast(self):
        return [pybullet.rayTestBatch(a, b, numThreads=1, physicsClientId=self.client) for a, b in self.batches]

    def cast_nothing(self):
        """The same calls where there is nothing to hit: what the binding alone costs."""
        return [pybullet.rayTestBatch(a, b, numThreads=1, physicsClientId=self.empty) for a, b in self.batches]

    def ranges(self, answers):
        hits = [hit for answer in answers for hit in answer]
        fractions = np.array([hit[2] if hit[0] >= 0 else 0.0 for hit in hits])
        return fractions * self.dump.max_range

    def close(self):
        pybullet.disconnect(self.client)
        pybullet.disconnect(self.empty)


def variants(dump):
    for most in CUTS:
        if most == CUTS[0] or most < len(dump.triangles):
            yield lambda most=most: PyBullet(dump, most)

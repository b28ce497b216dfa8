"""Embree through embreex: one ray after another with `rtcIntersect1`, called directly (trimesh's wrapper would add to it)."""

from importlib.metadata import version

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore import EmbreeDevice
from embreex.rtcore_scene import EmbreeScene


class Embreex:
    """`robust` is Embree's watertight test at edges, embreex's default; without it Embree is faster."""

    name = "embreex"
    version = version("embreex")

    def __init__(self, dump, robust):
        self.note = "robust, its default" if robust else "not robust"
        self.dump, self.most = dump, len(dump.triangles)
        self.scene = EmbreeScene(EmbreeDevice(), robust=robust)
        self.mesh = TriangleMesh(self.scene, dump.triangles)

    def cast(self):
        return self.distances(self.dump.origins, self.dump.directions)

    def ranges(self, distances):
        return np.where(distances < self.dump.max_range, distances, 0.0)

    def distances(self, origins, directions):
        """Of any rays, in metres; `max_range` where nothing is hit. The first call builds the tree."""
        return self.scene.run(origins, directions, dists=self.dump.max_range, query="DISTANCE")


def variants(dump):
    yield lambda: Embreex(dump, robust=True)
    yield lambda: Embreex(dump, robust=False)

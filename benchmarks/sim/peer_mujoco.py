"""MuJoCo: static mesh geoms of the world body and `mj_multiRay`, one call for all rays of an origin.

MuJoCo has a bounding volume hierarchy within each mesh and tells from afar which geoms a bundle of rays can meet, so what is fastest depends on how the
scene is cut into meshes. Several cuts are tried, and the fastest counts.
"""

from importlib.metadata import version

import mujoco
import numpy as np

import split

CUTS = (1_000_000_000, 20_000, 5_000, 1_000, 250)  # most triangles in a mesh


class MuJoCo:
    name = "MuJoCo"
    version = version("mujoco-core")

    def __init__(self, dump, most):
        self.dump, self.most = dump, min(most, len(dump.triangles))
        spec = mujoco.MjSpec()
        meshes = add_scene(spec, dump.triangles, most)
        self.note = f"{meshes} mesh" if meshes == 1 else f"{meshes} meshes"
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        mujoco.mj_forward(self.model, self.data)
        self.found = np.full(len(dump.origins), -1.0)
        self.geoms = np.full(len(dump.origins), -1, dtype=np.int32)
        directions = dump.directions.astype(np.float64)
        self.bundles = [
            (dump.origins[s.start].astype(np.float64), directions[s].ravel(), self.geoms[s], self.found[s])
            for s in dump.shared_origins()
        ]

    def cast(self):
        for origin, directions, geoms, found in self.bundles:
            many_rays(self.model, self.data, origin, directions, geoms, found, self.dump.max_range)
        return self.found

    def ranges(self, found):
        return np.where((found > 0.0) & (found < self.dump.max_range), found, 0.0)


def many_rays(model, data, origin, directions, geoms, found, cutoff, exclude=-1):
    """`mj_multiRay` against every geom but those of body `exclude`; `found` receives metres, -1 for none."""
    mujoco.mj_multiRay(model, data, origin, directions, None, True, exclude, geoms, found, None, len(found), cutoff)


def add_scene(spec, triangles, most):
    """Adds the triangles to the world as meshes of at most `most` that rays see and nothing touches; returns how many meshes."""
    cut = split.parts(triangles, most)
    for index, part in enumerate(cut):
        vertices, corners = np.unique(triangles[part].reshape(-1, 3), axis=0, return_inverse=True)
        mesh = spec.add_mesh(name=f"part{index}")
        mesh.uservert = vertices.ravel().astype(np.float64)
        mesh.userface = corners.ravel().astype(np.int32)
        # Walls without thickness have no volume to take an inertia from.
        mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
        geom = spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=f"part{index}")
        geom.contype = geom.conaffinity = 0
    return len(cut)


def variants(dump):
    for most in CUTS:
        if most >= CUTS[0] or most < len(dump.triangles):
            yield lambda most=most: MuJoCo(dump, most)

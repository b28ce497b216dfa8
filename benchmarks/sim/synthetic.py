"""A small dump made without `openbench`, for tests: boxes on a ground, rays of a few scans, and ranges by testing every triangle in float64."""

import json

import numpy as np

SIDES = np.array([[0, 1, 3], [0, 3, 2], [4, 7, 5], [4, 6, 7], [0, 5, 1], [0, 4, 5], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]])


def boxes(count, rng, extent):
    """`count` boxes on a square ground of half side `extent` metres, as triangles."""
    low = np.column_stack([rng.uniform(-extent, extent, (count, 2)), np.zeros(count)])
    size = rng.uniform([0.2, 0.2, 0.2], [6.0, 6.0, 12.0], (count, 3))
    unit = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    corners = low[:, None, :] + unit[None, :, :] * size[:, None, :]
    e = 2.0 * extent
    ground = np.array([[[-e, -e, 0], [e, -e, 0], [e, e, 0]], [[-e, -e, 0], [e, e, 0], [-e, e, 0]]])
    return np.concatenate([ground, corners[:, SIDES].reshape(-1, 3, 3)]).astype(np.float32)


def scans(places, rays, rng):
    """Origins and directions of scans from `places` (n x 3, metres): elevations of a MID-360, azimuths by the golden angle."""
    azimuth = np.arange(rays) * 2.399963
    elevation = np.radians(rng.uniform(-7.0, 52.0, rays))
    level = np.cos(elevation)
    directions = np.column_stack([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)])
    return np.repeat(places, rays, axis=0).astype(np.float32), np.tile(directions, (len(places), 1)).astype(np.float32)


def ranges(triangles, origins, directions, max_range):
    """Nearest hits by Moeller and Trumbore's test (Fast, Minimum Storage Ray/Triangle Intersection, 1997) of every triangle."""
    a, b, c = (triangles[:, k].astype(np.float64) for k in range(3))
    e1, e2 = b - a, c - a
    found = np.zeros(len(origins), dtype=np.float32)
    for i, (o, d) in enumerate(zip(origins.astype(np.float64), directions.astype(np.float64))):
        p = np.cross(d, e2)
        det = np.einsum("ij,ij->i", e1, p)
        with np.errstate(divide="ignore", invalid="ignore"):
            s = o - a
            u = np.einsum("ij,ij->i", s, p) / det
            q = np.cross(s, e1)
            v = q @ d / det
            t = np.einsum("ij,ij->i", e2, q) / det
            t = t[(u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0) & (t < max_range)]
        found[i] = t.min() if len(t) else 0.0
    return found


def write(folder, triangles, origins, directions, hits, max_range):
    for name, values in [("triangles", triangles), ("origins", origins), ("directions", directions), ("ranges", hits)]:
        np.ascontiguousarray(values, dtype="<f4").tofile(folder / f"{name}.f32")
    meta = {"max_range": max_range, "rays": len(origins), "triangles": len(triangles), "scans": len(np.unique(origins, axis=0)), "ours": {}}
    (folder / "meta.json").write_text(json.dumps(meta))

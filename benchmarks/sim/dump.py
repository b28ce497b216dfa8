"""What `openbench bench sim --dump` leaves: a scene's triangles, LiDAR rays in the order in which the sensor fires them, and our hits.

Binary files are little endian 32-bit floats: `triangles.f32` (n x 9, metres), `origins.f32` and `directions.f32` (m x 3, unit directions),
`ranges.f32` (m, metres, 0 where nothing is within `max_range`). `meta.json` has the counts and our own speed.
"""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np


class BadDump(Exception):
    """A file of the dump is missing or says something else than `meta.json`."""


@dataclass
class Dump:
    triangles: np.ndarray  # (n, 3, 3) float32, metres
    origins: np.ndarray  # (m, 3) float32, metres
    directions: np.ndarray  # (m, 3) float32, unit vectors
    ranges: np.ndarray  # (m,) float32, metres; 0: no hit
    max_range: float  # metres
    scans: int
    ours: dict  # our own figures, by name

    def shared_origins(self):
        """Slices of consecutive rays with one origin: a scan each, for peers that cast from a point."""
        starts = np.flatnonzero(np.any(self.origins[1:] != self.origins[:-1], axis=1)) + 1
        edges = [0, *starts.tolist(), len(self.origins)]
        return [slice(a, b) for a, b in zip(edges, edges[1:])]


def read(folder):
    """The dump in `folder`, checked; raises BadDump with the file's name."""
    folder = Path(folder)
    meta = _meta(folder / "meta.json")
    triangles = _floats(folder / "triangles.f32", meta["triangles"], 9).reshape(-1, 3, 3)
    origins = _floats(folder / "origins.f32", meta["rays"], 3)
    directions = _floats(folder / "directions.f32", meta["rays"], 3)
    ranges = _floats(folder / "ranges.f32", meta["rays"], 1).ravel()
    if np.abs(np.linalg.norm(directions.astype(np.float64), axis=1) - 1.0).max() > 1e-4:
        raise BadDump(f"{folder / 'directions.f32'}: directions must have length 1")
    if ranges.min() < 0.0 or ranges.max() > meta["max_range"] * 1.0001:
        raise BadDump(f"{folder / 'ranges.f32'}: a range is not within 0 and {meta['max_range']} m")
    return Dump(triangles, origins, directions, ranges, float(meta["max_range"]), int(meta["scans"]), meta["ours"])


def _meta(path):
    try:
        meta = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise BadDump(f"{path}: {error}") from error
    missing = [key for key in ("max_range", "rays", "triangles", "scans", "ours") if key not in meta]
    if missing:
        raise BadDump(f"{path}: no {', '.join(missing)}")
    if meta["rays"] < 1 or meta["triangles"] < 1:
        raise BadDump(f"{path}: a dump needs rays and triangles")
    return meta


def _floats(path, rows, columns):
    try:
        values = np.fromfile(path, dtype="<f4")
    except OSError as error:
        raise BadDump(f"{path}: {error}") from error
    if values.size != rows * columns:
        raise BadDump(f"{path}: {values.size} floats, but meta.json says {rows} x {columns}")
    if not np.isfinite(values).all():
        raise BadDump(f"{path}: holds a value that is not finite")
    return np.ascontiguousarray(values.reshape(rows, columns), dtype=np.float32)

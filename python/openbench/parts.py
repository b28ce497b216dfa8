"""The parts of the baseline, for other programs: maps, routes, language, costmaps, local planners
and LiDAR-inertial odometry.

Coordinates are metres in `map`, x east and y north; angles are radians, counter-clockwise from x;
times of sensors are nanoseconds. Arrays are NumPy's or what NumPy makes into one. What has no plan,
route or path raises `openbench.PlanningError`.

    from openbench.parts import Costmap, LocalPlanner, Map

    map = Map.read("town.osm")
    x, y = map.locate("building3", "unit1")
    route = map.route((0.0, 0.0), (x, y))
    costmap = Costmap(map, (-20.0, -20.0), (60.0, 60.0))
    path = costmap.plan((0.0, 0.0), route["points"][-1])
    planner = LocalPlanner("teb")
    velocity = planner.plan(0.0, (0.0, 0.0, 0.0), (0.0, 0.0), path)
"""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from typing import Any, NamedTuple, Optional, TypedDict

import numpy as np
import numpy.typing as npt

from openbench import _openbench
from openbench._openbench import Costmap as _Costmap
from openbench._openbench import Estimate, Obstacle, Odometry

__all__ = [
    "Building",
    "Costmap",
    "Estimate",
    "LocalPlanner",
    "Map",
    "Obstacle",
    "Odometry",
    "Route",
]

Floats = npt.NDArray[np.float64]


class Building(NamedTuple):
    """A building of a map."""

    name: Optional[str]
    #: Corners (n, 2), counter-clockwise.
    outline: Floats


class Route(TypedDict):
    """A route over roads, from the place on a road nearest to the start to that of the goal."""

    #: Points (n, 2).
    points: Floats
    #: Metres.
    distance: float
    #: Seconds.
    duration: float
    #: Names of the roads, without repetition.
    names: list[str]


class Map:
    """OpenStreetMap data in metres."""

    def __init__(self, data: bytes, georeference: str | None = None) -> None:
        """The map of OSM XML or PBF. Its frame is the usual one, or that of a georeference such as
        `utm:33N,-544700,-5362000` or `tangent:48.4,15.6`."""
        self.native = _openbench.Map(data, georeference)

    @staticmethod
    def read(path: str | os.PathLike[str], georeference: str | None = None) -> Map:
        """The map of a file."""
        map = Map.__new__(Map)
        map.native = _openbench.Map.read(path, georeference)
        return map

    @property
    def georeference(self) -> str:
        """The frame of all coordinates."""
        return self.native.georeference

    @property
    def buildings(self) -> list[Building]:
        """All buildings, by their numbers in OpenStreetMap."""
        return [Building(name, outline) for name, outline in self.native.buildings()]

    def locate(self, building: str, unit: str | None = None) -> tuple[float, float] | None:
        """The door of an address, or the middle of its building if the map lacks the door; `None`
        if it lacks both, or has several such buildings."""
        return self.native.locate(building, unit)

    def to_map(self, lonlat: npt.ArrayLike) -> Floats:
        """Degrees (n, 2), longitude first, as metres."""
        return self.native.to_map(lonlat)

    def to_lonlat(self, points: npt.ArrayLike) -> Floats:
        """Metres (n, 2) as degrees, longitude first."""
        return self.native.to_lonlat(points)

    def route(self, start: npt.ArrayLike, goal: npt.ArrayLike) -> Route:
        """The fastest route for a delivery robot."""
        route: Route = self.native.route(_pair(start), _pair(goal))
        return route

    def plan(
        self, instruction: str, start: npt.ArrayLike = (0.0, 0.0)
    ) -> list[dict[str, Any]]:
        """The deliveries of an instruction, in driving order from `start`, as the grammar
        understands it: the keys of `openbench plan --json`, `building`, `unit` and `problem` among
        them."""
        plan = json.loads(self.native.plan(instruction, _pair(start)))
        deliveries: list[dict[str, Any]] = plan["deliveries"]
        return deliveries


class Costmap:
    """The ground of an area of a map, with the cost of driving over it."""

    def __init__(self, map: Map, low: npt.ArrayLike, high: npt.ArrayLike) -> None:
        """The area between a south-western and a north-eastern corner, with the map's buildings,
        barriers and water, for the benchmark's robot."""
        self.native = _Costmap(map.native, _pair(low), _pair(high))

    @property
    def cell(self) -> float:
        """Side of a cell, metres."""
        return self.native.cell

    @property
    def origin(self) -> tuple[float, float]:
        """South-western corner of the first cell."""
        return self.native.origin

    @property
    def costs(self) -> npt.NDArray[np.float32]:
        """Cost of each cell relative to open ground, rows from the south; infinite where the
        robot does not fit."""
        return self.native.costs()

    def observe(self, points: npt.ArrayLike, sensor: npt.ArrayLike) -> None:
        """Takes in the points (n, 3) of a scan in `map`, z above the ground, measured from
        `sensor`. What it sees through becomes free."""
        x, y, z = np.asarray(sensor, float)
        rows = np.asarray(points, float).reshape(-1, 3)
        self.native.observe(rows, (float(x), float(y), float(z)))

    def plan(self, start: npt.ArrayLike, goal: npt.ArrayLike) -> Floats:
        """The cheapest path (n, 2), by A*."""
        return self.native.plan(_pair(start), _pair(goal))


class LocalPlanner:
    """Turns a path into velocities, one call for each observation."""

    def __init__(self, name: str = "teb", seed: int = 1) -> None:
        """`teb` (Timed Elastic Bands), `follower` (pure pursuit) or `mppi`, for the benchmark's
        robot."""
        self.native = _openbench.LocalPlanner(name, seed)

    def plan(
        self,
        time: float,
        pose: npt.ArrayLike,
        velocity: npt.ArrayLike,
        path: npt.ArrayLike,
        obstacles: Sequence[Obstacle] = (),
        final_yaw: float | None = None,
    ) -> tuple[float, float] | None:
        """The velocity to drive with now, m/s and rad/s; `None` at the end of the path.

        time: seconds, growing from call to call.
        pose, velocity: of the robot: x, y, yaw; m/s and rad/s.
        path: points (n, 2), which begin near the robot.
        final_yaw: heading at the end; any if `None`.
        """
        x, y, yaw = np.asarray(pose, float)
        here = (float(x), float(y), float(yaw))
        points = np.asarray(path, float).reshape(-1, 2)
        return self.native.plan(
            time, here, _pair(velocity), points, list(obstacles), final_yaw
        )

    def reset(self) -> None:
        """Forgets what was planned before: the next path is unrelated to the last."""
        self.native.reset()


def _pair(numbers: npt.ArrayLike) -> tuple[float, float]:
    first, second = np.asarray(numbers, float)
    return float(first), float(second)

"""The part of the package that is written in Rust."""

from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from typing import Any, final

import numpy as np
import numpy.typing as npt

__all__ = [
    "Adapter",
    "Costmap",
    "EnvironmentOptions",
    "Environments",
    "Estimate",
    "InputError",
    "LocalPlanner",
    "Map",
    "Obstacle",
    "Odometry",
    "OpenBenchError",
    "PlanningError",
    "PolicyEnd",
    "ProtocolError",
    "Run",
    "__version__",
    "main",
    "set_module",
]

__version__: str

class OpenBenchError(Exception): ...
class InputError(OpenBenchError): ...
class PlanningError(OpenBenchError): ...
class ProtocolError(OpenBenchError): ...

def main(arguments: Sequence[str]) -> int: ...
def set_module(file: str | PathLike[str]) -> None: ...

@final
class PolicyEnd:
    @staticmethod
    def of_standard_streams() -> PolicyEnd: ...
    def hello(self, program: str) -> None: ...
    def receive(self) -> tuple[str, dict[str, Any]] | None: ...
    def scan(
        self,
    ) -> (
        tuple[
            int,
            npt.NDArray[np.float32],
            npt.NDArray[np.uint32],
            npt.NDArray[np.uint8],
            npt.NDArray[np.uint8],
        ]
        | None
    ): ...
    def image(self) -> tuple[int, npt.NDArray[np.uint8]] | None: ...
    def ready(self, reports: str) -> None: ...
    def refuse(self, give_up: str) -> None: ...
    def drive(self, linear: float, angular: float, reports: str) -> None: ...
    def act(self, action: str, reports: str) -> None: ...
    def finished(self, map: bytes | None) -> None: ...
    def failed(self, detail: str) -> None: ...

# Name, conditions by key, and the seed of what they draw.
_Suite = tuple[str, Sequence[tuple[str, str]], int]

@final
class Run:
    def __new__(cls, suite: _Suite, agent: str) -> Run: ...
    def stop(self) -> None: ...
    def drive(
        self,
        seed: int,
        jobs: int,
        timeout: float,
        out: str | PathLike[str] | None,
        start: Callable[[PolicyEnd], None],
    ) -> str: ...

@final
class EnvironmentOptions:
    def __new__(
        cls,
        *,
        observations: Sequence[str],
        goal: str,
        start: tuple[float, float] | None,
        steps: int,
        actions: str,
        arrival: float | None,
        rewards: Mapping[str, float],
        range_image: tuple[int, int],
        one_firing_in: int,
        pose: str,
        time_limit: float | None,
    ) -> EnvironmentOptions: ...

@final
class Adapter:
    """Between a policy and the sensor data of a run."""

    def __new__(
        cls,
        options: EnvironmentOptions,
        robot: str,
        start: tuple[float, float, float],
        goal: tuple[float, float] | None,
    ) -> Adapter: ...
    @property
    def wants_scans(self) -> bool: ...
    @property
    def pose(self) -> tuple[float, float, float] | None: ...
    def take(
        self,
        time: float,
        imu: npt.ArrayLike,
        wheels: npt.ArrayLike,
        scan: tuple[float, npt.ArrayLike, npt.ArrayLike] | None,
    ) -> None: ...
    def is_ready(self, time: float) -> bool: ...
    def observation(self) -> dict[str, npt.NDArray[Any]]: ...
    def begin(self, action: tuple[float, float]) -> None: ...
    def velocity(self, time: float) -> tuple[float, float]: ...

_Stepped = tuple[
    dict[str, npt.NDArray[Any]],
    npt.NDArray[np.float64],
    npt.NDArray[np.bool_],
    npt.NDArray[np.bool_],
    list[tuple[int, dict[str, npt.NDArray[Any]], str]],
]

@final
class Environments:
    def __new__(
        cls,
        suite: _Suite,
        options: EnvironmentOptions,
        count: int,
        threads: int,
        autoreset: bool,
    ) -> Environments: ...
    def close(self) -> None: ...
    def reset(
        self, beginnings: Sequence[tuple[int | None, int | None] | None]
    ) -> dict[str, npt.NDArray[Any]]: ...
    def step(self, actions: npt.NDArray[np.float64]) -> _Stepped: ...
    def send(self, index: int, action: Sequence[float]) -> None: ...
    def receive(self, count: int) -> tuple[npt.NDArray[np.int64], _Stepped]: ...
    def episode(self, index: int) -> tuple[str, str, float]: ...
    def map(self) -> bytes: ...
    def picture(self, index: int) -> npt.NDArray[np.uint8] | None: ...
    def privileged(self, index: int) -> tuple[list[float], float | None] | None: ...

@final
class Map:
    def __new__(cls, data: bytes, georeference: str | None = None) -> Map: ...
    @staticmethod
    def read(path: str | PathLike[str], georeference: str | None = None) -> Map: ...
    @property
    def georeference(self) -> str: ...
    def buildings(self) -> list[tuple[str | None, npt.NDArray[np.float64]]]: ...
    def locate(self, building: str, unit: str | None = None) -> tuple[float, float] | None: ...
    def to_map(self, lonlat: npt.ArrayLike) -> npt.NDArray[np.float64]: ...
    def to_lonlat(self, points: npt.ArrayLike) -> npt.NDArray[np.float64]: ...
    def route(self, start: tuple[float, float], goal: tuple[float, float]) -> Any: ...
    def plan(self, instruction: str, start: tuple[float, float]) -> str: ...

@final
class Costmap:
    def __new__(
        cls, map: Map, low: tuple[float, float], high: tuple[float, float]
    ) -> Costmap: ...
    @property
    def cell(self) -> float: ...
    @property
    def origin(self) -> tuple[float, float]: ...
    def observe(self, points: npt.ArrayLike, sensor: tuple[float, float, float]) -> None: ...
    def costs(self) -> npt.NDArray[np.float32]: ...
    def plan(
        self, start: tuple[float, float], goal: tuple[float, float]
    ) -> npt.NDArray[np.float64]: ...

@final
class Obstacle:
    """What a robot must not touch: convex, perhaps with rounded corners, perhaps moving."""

    def __new__(
        cls,
        corners: npt.ArrayLike,
        rounding: float = 0.0,
        velocity: tuple[float, float] | None = None,
    ) -> Obstacle: ...

@final
class LocalPlanner:
    def __new__(cls, name: str = "teb", seed: int = 1) -> LocalPlanner: ...
    def plan(
        self,
        time: float,
        pose: tuple[float, float, float],
        velocity: tuple[float, float],
        path: npt.ArrayLike,
        obstacles: Sequence[Obstacle],
        final_yaw: float | None = None,
    ) -> tuple[float, float] | None: ...
    def reset(self) -> None: ...

@final
class Odometry:
    """LiDAR-inertial odometry: how a body has moved since the start."""

    def __new__(
        cls,
        imu: npt.ArrayLike | None = None,
        lidar: npt.ArrayLike | None = None,
        *,
        gyro_noise: float | None = None,
        accel_noise: float | None = None,
        range_noise: float | None = None,
        angle_noise: float | None = None,
        typical_speed: float | None = None,
        min_range: float | None = None,
    ) -> Odometry: ...
    def imu(
        self, stamps: npt.ArrayLike, gyro: npt.ArrayLike, accel: npt.ArrayLike
    ) -> list[Estimate]: ...
    def scan(
        self, stamp: int, points: npt.ArrayLike, offsets: npt.ArrayLike
    ) -> list[Estimate]: ...
    def speed(
        self,
        stamp: int,
        velocity: Sequence[float],
        deviation: Sequence[float],
        turn: float,
    ) -> None: ...
    @property
    def refused(self) -> dict[str, int]: ...

@final
class Estimate:
    """Where a body was at the end of a scan."""

    @property
    def stamp(self) -> int: ...
    @property
    def pose(self) -> npt.NDArray[np.float64]: ...
    @property
    def velocity(self) -> npt.NDArray[np.float64]: ...
    @property
    def covariance(self) -> npt.NDArray[np.float64]: ...
    @property
    def status(self) -> str: ...
    @property
    def points(self) -> int: ...

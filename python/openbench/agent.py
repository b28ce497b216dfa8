"""What an agent sees and decides, as in the Rust crate `openbench-core`."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from openbench._openbench import PolicyEnd

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Address:
    """A door: a building and, where it has several doors, a unit."""

    building: str
    unit: str | None = None


@dataclass(frozen=True)
class Drive:
    """Drive with this velocity until the next observation.

    linear: forward, m/s. angular: counter-clockwise, rad/s.
    """

    linear: float
    angular: float


@dataclass(frozen=True)
class Deliver:
    """Declares the parcel for this address delivered, here and now."""

    address: Address


@dataclass(frozen=True)
class GiveUp:
    """Gives up a delivery, or all that are left."""

    detail: str
    address: Address | None = None
    cause: str = "agent_error"


Action = Drive | Deliver | GiveUp | Sequence[float]


@dataclass(frozen=True)
class Scan:
    """A LiDAR scan, one row a return. Points are in `livox_frame` of their own instants."""

    stamp: float
    points: npt.NDArray[np.float32]
    offsets: Floats
    reflectivity: npt.NDArray[np.uint8]
    line: npt.NDArray[np.uint8]


@dataclass(frozen=True)
class Briefing:
    """All that an agent gets before an episode.

    `start` is a pose in `map` (m, m, rad) with the covariance of its error, or `None`: then
    `start_area` is a disc in which the robot starts (x, y and radius in m), or `None` if it may
    start anywhere.
    """

    instruction: str | None
    point: tuple[float, float] | None
    map: bytes
    georeference: dict[str, Any]
    start: tuple[float, float, float] | None
    start_covariance: list[list[float]] | None
    start_area: tuple[float, float, float] | None
    robot: dict[str, Any]
    time_limit: float
    seed: int


@dataclass
class Observation:
    """The sensor data since the last observation."""

    time: float
    imu: Floats
    wheels: Floats
    has_scan: bool
    _end: PolicyEnd
    gnss: Any = None
    _reports: list[dict[str, Any]] = field(default_factory=list)
    _scan: Scan | None = None
    _image: npt.NDArray[np.uint8] | None = None
    _image_asked: bool = False

    @property
    def scan(self) -> Scan | None:
        """The LiDAR scan, if one was completed since the last observation."""
        if self.has_scan and self._scan is None:
            arrays = self._end.scan()
            if arrays is not None:
                stamp, points, offsets, reflectivity, line = arrays
                seconds = np.asarray(offsets * 1e-9, dtype=np.float64)
                self._scan = Scan(stamp * 1e-9, points, seconds, reflectivity, line)
        return self._scan

    @property
    def image(self) -> npt.NDArray[np.uint8] | None:
        """The camera's image of this instant, if its rate allows one; rendered on request."""
        if not self._image_asked:
            self._image_asked = True
            image = self._end.image()
            self._image = None if image is None else image[1]
        return self._image

    def report_pose(self, x: float, y: float, yaw: float) -> None:
        """Reports where the agent takes itself to be, in `map`."""
        self._reports.append({"pose": {"pose": {"x": x, "y": y, "yaw": yaw}}})

    def note(self, text: str) -> None:
        """Writes a line into the log."""
        self._reports.append({"note": text})


class Agent(Protocol):
    """The control program of a delivery robot; a class with these methods is one."""

    def begin(self, briefing: Briefing) -> GiveUp | None:
        """Reads the map and the goal; `GiveUp` refuses the episode."""
        ...

    def act(self, observation: Observation) -> Action:
        """Decides what to do until the next observation, 50 ms later."""
        ...


def address_json(address: Address | None) -> dict[str, str | None] | None:
    """An address as the protocol has it."""
    return None if address is None else {"building": address.building, "unit": address.unit}


def give_up_json(give_up: GiveUp) -> str:
    """A surrender as the protocol has it."""
    content = {
        "address": address_json(give_up.address),
        "cause": give_up.cause,
        "detail": give_up.detail,
    }
    return json.dumps(content)

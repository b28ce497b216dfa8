"""The part of the package that is written in Rust."""

from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from typing import Any, final

import numpy as np
import numpy.typing as npt

__all__ = [
    "EnvironmentOptions",
    "Environments",
    "InputError",
    "OpenBenchError",
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

@final
class Run:
    def __new__(cls, suite: str, agent: str) -> Run: ...
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
        arrival: float | None,
        rewards: Mapping[str, float],
        range_image: tuple[int, int],
        pose: str,
        time_limit: float | None,
    ) -> EnvironmentOptions: ...

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
        suite: str,
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
    def episode(self, index: int) -> str: ...
    def map(self) -> bytes: ...
    def picture(self, index: int) -> npt.NDArray[np.uint8] | None: ...
    def privileged(self, index: int) -> tuple[list[float], float | None] | None: ...

"""Scores agents of this process."""

from __future__ import annotations

import json
import operator
import os
import threading
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, overload

from openbench._openbench import InputError, PolicyEnd, Run
from openbench._serving import serve
from openbench.agent import Agent
from openbench.conditions import Conditions, written


@overload
def evaluate(
    agent: Callable[[], Agent],
    suite: str = "small",
    *,
    seed: int = 0,
    jobs: int = 1,
    timeout: float = 60.0,
    out: str | os.PathLike[str] | None = None,
    conditions: Conditions | None = None,
) -> dict[str, Any]: ...


@overload
def evaluate(
    agent: Callable[[], Agent],
    suite: str = "small",
    *,
    seeds: Iterable[int],
    jobs: int = 1,
    timeout: float = 60.0,
    out: str | os.PathLike[str] | None = None,
    conditions: Conditions | None = None,
) -> dict[int, dict[str, Any]]: ...


def evaluate(
    agent: Callable[[], Agent],
    suite: str = "small",
    *,
    seed: int = 0,
    seeds: Iterable[int] | None = None,
    jobs: int = 1,
    timeout: float = 60.0,
    out: str | os.PathLike[str] | None = None,
    conditions: Conditions | None = None,
) -> dict[str, Any] | dict[int, dict[str, Any]]:
    """Runs a suite with an agent and returns the content of `results.json`.

    agent: a class, or anything that makes an agent; each episode gets its own.
    suite: a built-in suite, a suite file, or the folder of a world.
    seed: seed of all random draws; with small, medium and large one other than 0 also draws another
        neighbourhood of that kind.
    seeds: several of them, one run each; returns the results of each seed by its number.
    jobs: how many episodes run in parallel; results do not depend on it.
    timeout: how long an action may take, seconds.
    out: a folder for results, report and recordings, which is replaced; each of several seeds gets
        a folder `seed-N` in it, beside which there must be no other runs. `None` writes nothing.
    conditions: what makes the suite harder: levels, as in `{"map": "city"}`, or numbers, as in
        `{"map.shift_m": 3}`.

    An exception of the agent ends the run and is raised.
    """
    if seeds is not None and seed != 0:
        raise TypeError("write seed or seeds")
    name = getattr(agent, "__name__", type(agent).__name__)
    run = Run((suite, written(conditions), seed), f"python:{name}")
    if seeds is None:
        return _drive(run, agent, seed, jobs, timeout, out)
    numbers = [operator.index(number) for number in seeds]
    if any(number < 0 for number in numbers):
        raise ValueError("seeds: numbers from 0")
    if out is not None:
        _refuse_other_runs(Path(out), numbers)
    folders = {number: None if out is None else Path(out) / f"seed-{number}" for number in numbers}
    return {
        number: _drive(run, agent, number, jobs, timeout, folder)
        for number, folder in folders.items()
    }


def _refuse_other_runs(out: Path, seeds: list[int]) -> None:
    """Refuses a folder whose other runs would be taken for some of these seeds."""
    ours = {f"seed-{seed}" for seed in seeds}
    others = [path.name for path in out.glob("seed-*") if path.name not in ours]
    if (out / "results.json").exists() or others:
        found = ", ".join(sorted(others)) or "a single run"
        raise InputError(f"{out} has {found}; choose another folder, or remove it")


def _drive(
    run: Run,
    agent: Callable[[], Agent],
    seed: int,
    jobs: int,
    timeout: float,
    out: str | os.PathLike[str] | None,
) -> dict[str, Any]:
    """The results of one seed."""
    errors: list[BaseException] = []

    def failed(error: BaseException) -> None:
        errors.append(error)
        run.stop()

    def start(end: PolicyEnd) -> None:
        # A daemon, so that an agent that never returns does not keep the process.
        threading.Thread(target=serve, args=(end, agent, failed), daemon=True).start()

    try:
        results = run.drive(seed, jobs, timeout, out, start)
    except KeyboardInterrupt:
        if errors:
            raise errors[0] from None
        raise
    parsed: dict[str, Any] = json.loads(results)
    return parsed

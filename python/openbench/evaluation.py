"""Scores agents of this process."""

from __future__ import annotations

import json
import os
import threading
from collections.abc import Callable
from typing import Any

from openbench._openbench import PolicyEnd, Run
from openbench._serving import serve
from openbench.agent import Agent


def evaluate(
    agent: Callable[[], Agent],
    suite: str = "small",
    *,
    seed: int = 0,
    jobs: int = 1,
    timeout: float = 60.0,
    out: str | os.PathLike[str] | None = None,
) -> dict[str, Any]:
    """Runs a suite with an agent and returns the content of `results.json`.

    agent: a class, or anything that makes an agent; each episode gets its own.
    suite: a built-in suite, a suite file, or the folder of a world.
    jobs: how many episodes run in parallel; results do not depend on it.
    timeout: how long an action may take, seconds.
    out: a folder for results, report and recordings, which is replaced; `None` writes nothing.

    An exception of the agent ends the run and is raised.
    """
    name = getattr(agent, "__name__", type(agent).__name__)
    run = Run(suite, f"python:{name}")
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

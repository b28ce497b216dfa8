"""Lets an agent answer the benchmark's messages."""

from __future__ import annotations

import json
import random
import traceback
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from openbench.agent import (
    Agent,
    Briefing,
    Deliver,
    Drive,
    GiveUp,
    Observation,
    address_json,
    give_up_json,
)

if TYPE_CHECKING:
    from openbench._openbench import PolicyEnd


def serve(
    end: PolicyEnd,
    make: Callable[[], Agent],
    failed: Callable[[BaseException], None] = lambda _: None,
) -> None:
    """Answers until there are no more messages; each episode gets a new agent."""
    agent: Agent | None = None
    while (message := end.receive()) is not None:
        name, content = message
        try:
            if name == "begin":
                agent = make()
                begin(end, agent, content)
            elif agent is None:
                end.failed(f"{name} before begin")
            elif name == "act":
                act(end, agent, content)
            else:
                finish = getattr(agent, "finish", None)
                end.finished(finish() if finish else None)
                agent = None
        except Exception as error:
            end.failed("".join(traceback.format_exception_only(error)).strip())
            failed(error)


def begin(end: PolicyEnd, agent: Agent, content: dict[str, Any]) -> None:
    seed = content["seed"]
    # An agent that draws random numbers draws the same ones when its run is checked.
    random.seed(seed)
    np.random.seed(seed % 2**32)
    outcome = agent.begin(
        Briefing(
            instruction=content.get("instruction"),
            point=content.get("point"),
            map=content["map"],
            georeference=json.loads(content["georeference"]),
            start=content["start"],
            start_covariance=content["start_covariance"],
            start_area=content["start_area"],
            robot=json.loads(content["robot"]),
            time_limit=content["time_limit"],
            seed=seed,
        )
    )
    if isinstance(outcome, GiveUp):
        end.refuse(give_up_json(outcome))
    else:
        end.ready("")


def act(end: PolicyEnd, agent: Agent, content: dict[str, Any]) -> None:
    observation = Observation(
        time=content["time"],
        imu=content["imu"],
        wheels=content["wheels"],
        has_scan=content["has_scan"],
        gnss=content.get("gnss"),
        _end=end,
    )
    action = agent.act(observation)
    reports = json.dumps(observation._reports) if observation._reports else ""
    if isinstance(action, Drive):
        end.drive(action.linear, action.angular, reports)
    elif isinstance(action, Deliver):
        end.act(json.dumps({"delivered": address_json(action.address)}), reports)
    elif isinstance(action, GiveUp):
        end.act(f'{{"give_up": {give_up_json(action)}}}', reports)
    else:
        linear, angular = action
        end.drive(float(linear), float(angular), reports)

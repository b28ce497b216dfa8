"""Policies of environments as agents."""

from __future__ import annotations

from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

import openbench
from openbench.envs import POINT_GOAL, Settings
from openbench.policy_agent import PolicyAgent

POINTS = """
name = "points"
goal = "point"

[world.builtin]
name = "small"
seed = 1

[[episodes]]
instruction = "Box to unit 1, building 1."
deliveries = [{ building = "building1", unit = "unit1" }]
"""


@pytest.fixture
def points(tmp_path: Path) -> str:
    suite = tmp_path / "points.toml"
    suite.write_text(POINTS)
    return str(suite)


class Straight(PolicyAgent):
    """Turns to the goal and drives."""

    settings = POINT_GOAL
    seen: ClassVar[list[dict[str, Any]]] = []

    def decide(self, observation: dict[str, Any]) -> Any:
        self.seen.append(observation)
        forward, left = observation["goal"]
        bearing = np.arctan2(left, forward)
        return np.array([0.5 * max(np.cos(bearing), 0.0), np.clip(2.0 * bearing, -1.0, 1.0)])


def test_a_policy_sees_what_its_environment_shows_and_declares_where_it_arrives(points: str) -> None:
    Straight.seen.clear()
    results = openbench.evaluate(Straight, points)
    space = Settings(**POINT_GOAL).observation_space()
    assert all(space.contains(observation) for observation in Straight.seen)
    ways = [float(np.hypot(*observation["goal"])) for observation in Straight.seen]
    assert ways[-1] < 1.2 < ways[0] - 3.0
    (delivery,) = openbench.deliveries(results)
    # Its wheels turned on while a wall held the robot: it declared where it took itself to be.
    assert delivery["failure"] == "wrong_place", delivery


def test_an_action_lasts_its_steps(points: str) -> None:
    class Nervous(PolicyAgent):
        settings: ClassVar[dict[str, Any]] = {"observations": ("image",), "steps": 5}
        images: ClassVar[list[Any]] = []

        def decide(self, observation: dict[str, Any]) -> Any:
            self.images.append(observation["image"])
            return np.array([0.1, 0.0, float(len(self.images) > 4)])

    results = openbench.evaluate(Nervous, points)
    assert len(Nervous.images) == 5 and Nervous.images[-1].std() > 5
    # Four actions of five steps, and the step that declares.
    assert results["episodes"][0]["sim_seconds"] == pytest.approx(4 * 0.25 + 0.05, abs=0.11)


def test_what_a_policy_was_not_trained_for_is_refused() -> None:
    results = openbench.evaluate(Straight, "small")
    details = {delivery["failure_detail"] for delivery in openbench.deliveries(results)}
    assert len(details) == 1 and 'goal = "point"' in details.pop()

    class Nameless(PolicyAgent):
        def decide(self, observation: dict[str, Any]) -> Any:
            return np.zeros(3)

    with pytest.raises(NotImplementedError, match="address"):
        openbench.evaluate(Nameless, "small")

"""Agents that decide as a policy of an environment does."""

from __future__ import annotations

import json
from typing import Any, ClassVar

import numpy as np
from gymnasium import spaces

from openbench._openbench import Adapter
from openbench.agent import Action, Address, Briefing, Deliver, Drive, GiveUp, Observation
from openbench.envs import Array, Observations, Settings


class PolicyAgent:
    """An agent that sees what an environment of its `settings` shows, and whose actions mean the
    same as there: what was trained in the one is scored as the other.

        class Trained(PolicyAgent):
            settings = openbench.envs.POINT_GOAL

            def decide(self, observation):
                return my_network(observation)

    With a setting `arrival` the environment declares by the truth. The agent declares when the goal
    is that near to where it takes itself to be.
    """

    settings: ClassVar[dict[str, Any]] = {}
    #: The space of actions, as the environment has it.
    action_space: spaces.Box

    def decide(self, observation: Observations) -> Array:
        """The action after an observation, both as the environment's spaces have them."""
        raise NotImplementedError

    def address(self, briefing: Briefing) -> Address:
        """The address that is declared. Point goals need none; for instructions write this."""
        if briefing.point is None:
            raise NotImplementedError("which address? write a method `address`")
        return Address("goal")

    def begin(self, briefing: Briefing) -> GiveUp | None:
        """Begins an episode."""
        self._settings = Settings(**self.settings)
        self.action_space = self._settings.action_space()
        if self._settings.goal == "point" and briefing.point is None:
            return GiveUp('the policy was trained for points; write goal = "point" in the suite')
        if self._settings.arrival is not None and "goal" not in self._settings.observations:
            raise ValueError('arrival: it is seen from the observation "goal"')
        sees_pose = {"pose", "goal"} & set(self._settings.observations)
        if briefing.start is None and sees_pose:
            return GiveUp("a pose is needed, and the start is not given", cause="lost")
        self._address = self.address(briefing)
        robot = json.dumps(briefing.robot)
        self._adapter = Adapter(
            self._settings.options,
            robot,
            briefing.start or (0.0, 0.0, 0.0),
            briefing.point,
        )
        self._image: Array = np.zeros((480, 640, 3), np.uint8)
        self._steps_left = 0
        return None

    def act(self, observation: Observation) -> Action:
        """Decides where an action ends, and drives it until then."""
        self._take(observation)
        if self._steps_left == 0:
            if not self._adapter.is_ready(observation.time):
                return Drive(0.0, 0.0)
            decided = self._decide(observation)
            if isinstance(decided, Deliver):
                return decided
            self._adapter.begin(decided)
            self._steps_left = self._settings.steps
        self._steps_left -= 1
        return Drive(*self._adapter.velocity(observation.time))

    def _take(self, observation: Observation) -> None:
        scan = observation.scan if self._adapter.wants_scans else None
        arrays = None if scan is None else (scan.stamp, scan.points, scan.offsets)
        self._adapter.take(observation.time, observation.imu, observation.wheels, arrays)
        pose = self._adapter.pose
        if pose is not None:
            observation.report_pose(*pose)

    def _decide(self, observation: Observation) -> tuple[float, float] | Deliver:
        seen = {key: value[0] for key, value in self._adapter.observation().items()}
        if "image" in seen:
            image = observation.image
            self._image = self._image if image is None else image
            seen["image"] = self._image
        if self._has_arrived(seen):
            return Deliver(self._address)
        (numbers,) = self._settings.actions(np.asarray(self.decide(seen))[None], 1)
        first, second, declares = (float(number) for number in numbers)
        return Deliver(self._address) if declares > 0.5 else (first, second)

    def _has_arrived(self, seen: Observations) -> bool:
        arrival = self._settings.arrival
        return arrival is not None and bool(np.hypot(*seen["goal"]) <= arrival)

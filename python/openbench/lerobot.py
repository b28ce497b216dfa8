"""Environments with the names of LeRobot, for its EnvHub: `from openbench.lerobot import make_env`.

An observation has `pixels` (the camera) and `agent_pos` (speeds from the wheels, then the estimated
pose relative to the start; with a point goal also forward and left of the goal).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium import spaces
from gymnasium.vector.utils import batch_space

from openbench.envs import Array, DeliveryVectorEnv, Observations

#: Simulated seconds of an episode.
TIME_LIMIT = 300.0
#: Steps of 50 ms that an action lasts: the camera has ten images a second.
STEPS = 2


class Episode:
    """What LeRobot asks of one environment of several."""

    def __init__(self, envs: LeRobotVectorEnv, index: int) -> None:
        self._envs, self._index = envs, index

    @property
    def task_description(self) -> str:
        """The instruction."""
        instruction: str = self._envs.instructions[self._index]
        return instruction

    @property
    def task(self) -> str:
        """The name of the task."""
        return "openbench/Delivery-v0"


class LeRobotVectorEnv(DeliveryVectorEnv):
    """Deliveries with LeRobot's names for observations, tasks and limits."""

    def __init__(self, num_envs: int = 1, suite: str = "small", **settings: Any) -> None:
        goal = ("goal",) if settings.get("goal") == "point" else ()
        defaults: dict[str, Any] = {
            "observations": ("image", "wheels", "pose", *goal),
            "steps": STEPS,
            "time_limit": TIME_LIMIT,
        }
        super().__init__(num_envs, suite, **{**defaults, **settings})
        width = 5 if self.settings.goal == "instruction" else 7
        self.single_observation_space = spaces.Dict(
            {
                "pixels": spaces.Box(0, 255, (480, 640, 3), np.uint8),
                "agent_pos": spaces.Box(-1e6, 1e6, (width,), np.float32),
            }
        )
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.instructions = [""] * num_envs
        self.envs = [Episode(self, index) for index in range(num_envs)]
        self._starts = np.zeros((num_envs, 3))
        limit = settings.get("time_limit", TIME_LIMIT)
        self._max_episode_steps = int(limit / (0.05 * self.settings.steps))

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Observations, dict[str, Any]]:
        """As of `DeliveryVectorEnv`."""
        observations, infos = super().reset(seed=seed, options=options)
        begun = infos.get("_instruction", np.zeros(self.num_envs, dtype=bool))
        self._begin(begun, observations, infos)
        return self._named(observations), infos

    def step(self, actions: Array) -> tuple[Observations, Array, Array, Array, dict[str, Any]]:
        """As of `DeliveryVectorEnv`."""
        observations, rewards, terminations, truncations, infos = super().step(actions)
        ended = terminations | truncations
        if ended.any():
            for index in np.flatnonzero(ended):
                last = infos["final_obs"][index]
                batched = {key: value[None] for key, value in last.items()}
                named = self._named(batched, self._starts[index][None])
                infos["final_obs"][index] = {key: value[0] for key, value in named.items()}
            self._begin(ended, observations, infos)
        return self._named(observations), rewards, terminations, truncations, infos

    def call(self, name: str, *args: Any, **kwargs: Any) -> tuple[Any, ...]:
        """An attribute of each environment, or what its method returns."""
        if name == "_max_episode_steps":
            return (self._max_episode_steps,) * self.num_envs
        if name == "render":
            return tuple(self._environments.picture(i) for i in range(self.num_envs))
        values = [getattr(episode, name) for episode in self.envs]
        return tuple(value(*args, **kwargs) if callable(value) else value for value in values)

    def get_attr(self, name: str) -> tuple[Any, ...]:
        """An attribute of each environment."""
        return self.call(name)

    def _begin(self, begun: Array, observations: Observations, infos: dict[str, Any]) -> None:
        for index in np.flatnonzero(begun):
            self.instructions[index] = str(infos["instruction"][index])
            self._starts[index] = observations["pose"][index]

    def _named(self, observations: Observations, starts: Array | None = None) -> Observations:
        moved = observations["pose"] - (self._starts if starts is None else starts)
        parts = [observations["wheels"], moved]
        if "goal" in observations:
            parts.append(observations["goal"])
        state = np.concatenate(parts, axis=1).astype(np.float32)
        return {"pixels": observations["image"], "agent_pos": state}


def make_env(
    n_envs: int = 1, use_async_envs: bool = False, cfg: Any = None
) -> LeRobotVectorEnv:
    """What EnvHub calls. The environments always run on threads of Rust."""
    return LeRobotVectorEnv(n_envs)

"""Environments for stable-baselines3, on threads of Rust instead of processes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium import spaces
from stable_baselines3.common.vec_env.base_vec_env import VecEnv

from openbench.envs import Array, DeliveryVectorEnv, Observations


def unscaled(actions: Array, box: spaces.Box) -> Array:
    """Actions between -1 and 1 as a space has them."""
    share = (np.clip(actions, -1.0, 1.0) + 1.0) / 2.0
    scaled: Array = box.low + share * (box.high - box.low)
    return scaled


def normal(observations: Observations, moments: Observations) -> Observations:
    """Observations as `VecNormalize` gives them to a policy, by mean and variance of each."""
    return {
        key: np.clip(
            (observations[key] - mean) / np.sqrt(variance + 1e-8), -10.0, 10.0
        ).astype(np.float32)
        for key, (mean, variance) in moments.items()
    }


class DeliveryVecEnv(VecEnv):  # type: ignore[misc]
    """A `DeliveryVectorEnv` as stable-baselines3 expects it; actions are between -1 and 1."""

    def __init__(self, envs: DeliveryVectorEnv) -> None:
        self.envs = envs
        box = envs.single_action_space
        assert isinstance(box, spaces.Box)
        self._box = box
        actions = spaces.Box(-1.0, 1.0, box.shape, np.float32)
        super().__init__(envs.num_envs, envs.single_observation_space, actions)
        self._actions = np.zeros((envs.num_envs, *box.shape))
        self._returns = np.zeros(envs.num_envs)
        self._lengths = np.zeros(envs.num_envs, dtype=int)
        self._seed: int | None = None

    def reset(self) -> dict[str, Array]:
        observations, _ = self.envs.reset(seed=self._seed)
        self._seed = None
        self._returns[:], self._lengths[:] = 0.0, 0
        return observations

    def seed(self, seed: int | None = None) -> Sequence[int | None]:
        self._seed = seed
        return [None if seed is None else seed + i for i in range(self.num_envs)]

    def step_async(self, actions: Array) -> None:
        self._actions = unscaled(actions, self._box)

    def step_wait(self) -> tuple[dict[str, Array], Array, Array, list[dict[str, Any]]]:
        observations, rewards, terminations, truncations, given = self.envs.step(self._actions)
        self._returns += rewards
        self._lengths += 1
        done = terminations | truncations
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for index in np.flatnonzero(done):
            infos[index] = {
                "terminal_observation": given["final_obs"][index],
                "TimeLimit.truncated": bool(truncations[index]),
                "is_success": bool(given["final_info"]["is_success"][index]),
                "episode": {"r": self._returns[index], "l": self._lengths[index], "t": 0.0},
            }
            self._returns[index], self._lengths[index] = 0.0, 0
        return observations, rewards.astype(np.float32), done, infos

    def close(self) -> None:
        self.envs.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        return [getattr(self.envs, attr_name)] * len(list(self._get_indices(indices)))

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        setattr(self.envs, attr_name, value)

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **kw: Any) -> list[Any]:
        result = getattr(self.envs, method_name)(*args, **kw)
        return [result] * len(list(self._get_indices(indices)))

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        return [False] * len(list(self._get_indices(indices)))

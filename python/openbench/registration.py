"""Environments by name."""

from __future__ import annotations

from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from openbench.envs import DeliveryEnv


def make(suite: str = "small", *, seed: int | None = None, **settings: Any) -> DeliveryEnv:
    """An environment of a suite; `openbench.envs.DeliveryEnv` describes the settings."""
    from gymnasium.utils import seeding

    from openbench.envs import DeliveryEnv

    env = DeliveryEnv(suite, **settings)
    if seed is not None:
        env.np_random, _ = seeding.np_random(seed)
    return env


def register_environments() -> None:
    """Registers the environments with `gymnasium`, if that is installed."""
    if find_spec("gymnasium") is None:
        return
    import gymnasium as gym

    gym.register(
        "openbench/Delivery-v0",
        entry_point="openbench.envs:DeliveryEnv",
        vector_entry_point="openbench.envs:DeliveryVectorEnv",
    )
    gym.register(
        "openbench/PointGoal-v0",
        entry_point="openbench.envs:point_goal",
        vector_entry_point="openbench.envs:point_goal_vector",
    )

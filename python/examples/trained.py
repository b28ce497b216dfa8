"""A policy that ppo.py has trained, as an agent of the benchmark:

    openbench run points.toml --agent python:trained.py:Trained --out runs/trained

It reads POLICY.zip and POLICY.npz, where POLICY is a variable of the environment.
"""

from __future__ import annotations

import functools
import os
from typing import Any

import numpy as np
import torch
from stable_baselines3 import PPO

from openbench.envs import POINT_GOAL
from openbench.policy_agent import PolicyAgent
from openbench.stable_baselines import normal, unscaled


@functools.cache
def policy() -> tuple[Any, dict[str, Any]]:
    """The policy, and the mean and the variance of each observation."""
    path = os.environ["POLICY"]
    torch.set_num_threads(1)
    with np.load(f"{path}.npz") as moments:
        return PPO.load(path, device="cpu").policy, dict(moments)


class Trained(PolicyAgent):
    settings = {**POINT_GOAL, "pose": "odometry"}

    def decide(self, observation: dict[str, Any]) -> Any:
        network, moments = policy()
        action, _ = network.predict(normal(observation, moments), deterministic=True)
        return unscaled(action, self.action_space)

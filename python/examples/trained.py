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
        seen = {}
        for key, (mean, variance) in moments.items():
            normal = (observation[key] - mean) / np.sqrt(variance + 1e-8)
            seen[key] = np.clip(normal, -10.0, 10.0).astype(np.float32)
        action, _ = network.predict(seen, deterministic=True)
        box = self.action_space
        return box.low + (np.clip(action, -1.0, 1.0) + 1.0) / 2.0 * (box.high - box.low)

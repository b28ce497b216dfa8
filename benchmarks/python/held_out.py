"""Scores policies of ppo.py on episodes that they were not trained on: held_out.py FOLDER

Deterministic actions, 208 episodes of each suite; seeds begin at 11,000.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import torch
from stable_baselines3 import PPO

import openbench.envs
from openbench.stable_baselines import DeliveryVecEnv

ENVIRONMENTS = 16
#: The first ones of each environment, so that short episodes do not count more.
EPISODES_EACH = 13


def success(policy: Path, suite: str, seed: int) -> float:
    """Share of the episodes that succeed."""
    envs = openbench.envs.point_goal_vector(ENVIRONMENTS, suite=suite, threads=2)
    env = DeliveryVecEnv(envs)
    env.seed(seed)
    network = PPO.load(policy.with_suffix(".zip"), device="cpu").policy
    moments = dict(np.load(policy.with_suffix(".npz")))
    won: list[bool] = []
    counts = np.zeros(ENVIRONMENTS, int)
    observations = env.reset()
    while (counts < EPISODES_EACH).any():
        seen = {}
        for key, (mean, variance) in moments.items():
            normal = (observations[key] - mean) / np.sqrt(variance + 1e-8)
            seen[key] = np.clip(normal, -10.0, 10.0).astype(np.float32)
        actions, _ = network.predict(seen, deterministic=True)
        observations, _, done, infos = env.step(actions)
        for index in np.flatnonzero(done):
            if counts[index] < EPISODES_EACH:
                won.append(infos[index]["is_success"])
                counts[index] += 1
    env.close()
    return float(np.mean(won))


def main() -> None:
    torch.set_num_threads(1)
    for number, policy in enumerate(sorted(Path(sys.argv[1]).glob("seed-*.zip"))):
        for suite in ("small", "medium", "large"):
            share = success(policy.with_suffix(""), suite, 11_000 + number)
            print(f"{policy.stem:8} {suite:8} {100 * share:5.1f} %", flush=True)


if __name__ == "__main__":
    main()

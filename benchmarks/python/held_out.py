"""Scores policies of ppo.py, and one by hand, on episodes that none was trained on:

    held_out.py FOLDER

Deterministic actions, 208 episodes of each suite; seeds begin at 11,000.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import torch
from stable_baselines3 import PPO

import openbench.envs
from openbench.envs import BACKWARD, FORWARD, TURN
from openbench.stable_baselines import DeliveryVecEnv, normal

ENVIRONMENTS = 16
FIRST_SEED = 11_000
#: The first ones of each environment, so that short episodes do not count more.
EPISODES_EACH = 13


def success(decide: Callable[[Any], Any], suite: str, seed: int) -> float:
    """Share of the episodes that succeed."""
    envs = openbench.envs.point_goal_vector(ENVIRONMENTS, suite=suite, threads=2)
    env = DeliveryVecEnv(envs)
    env.seed(seed)
    won: list[bool] = []
    counts = np.zeros(ENVIRONMENTS, int)
    observations = env.reset()
    while (counts < EPISODES_EACH).any():
        observations, _, done, infos = env.step(decide(observations))
        for index in np.flatnonzero(done):
            if counts[index] < EPISODES_EACH:
                won.append(infos[index]["is_success"])
                counts[index] += 1
    env.close()
    return float(np.mean(won))


def by_hand(observations: Any) -> Any:
    """Turns to the door and goes, with actions between -1 and 1."""
    forward, left = observations["goal"].T
    bearing = np.arctan2(left, forward)
    speed = FORWARD * np.maximum(np.cos(bearing), 0.0)
    scaled = 2.0 * (speed + BACKWARD) / (FORWARD + BACKWARD) - 1.0
    return np.stack([scaled, 2.0 * bearing / TURN], axis=1)


def trained(path: Path) -> Callable[[Any], Any]:
    """What a policy of a folder decides."""
    network = PPO.load(path, device="cpu").policy
    moments = dict(np.load(path.with_suffix(".npz")))
    return lambda seen: network.predict(normal(seen, moments), deterministic=True)[0]


def main() -> None:
    torch.set_num_threads(1)
    rows = [("by hand", by_hand, FIRST_SEED)]
    for number, path in enumerate(sorted(Path(sys.argv[1]).glob("seed-*.zip"))):
        rows.append((path.stem, trained(path), FIRST_SEED + number))
    for name, decide, seed in rows:
        for suite in ("small", "medium", "large"):
            share = success(decide, suite, seed)
            print(f"{name:8} {suite:8} {100 * share:5.1f} %", flush=True)


if __name__ == "__main__":
    main()

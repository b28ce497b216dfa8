"""Trains a policy for a short point goal with PPO (stable-baselines3): ppo.py SEED FOLDER [MINUTES]

The robot begins 1.5 to 6 m from a door, at any heading, sees a coarse image of distances, the
speeds of its wheels and where the door is, and has 60 s. Writes the returns and rates of success of
the training's episodes to FOLDER/seed-SEED.csv; beside it the policy, seed-SEED.zip, and mean and
variance of each observation, seed-SEED.npz. trained.py makes an agent of both.
"""

from __future__ import annotations

import csv
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecNormalize

import openbench.envs
from openbench.stable_baselines import DeliveryVecEnv

ENVIRONMENTS = 16
MINUTES = 5.0
#: Episodes over which a row of the curve is a mean.
WINDOW = 100


class Curve(BaseCallback):
    """Writes a row for each hundred episodes."""

    def __init__(self, path: Path, minutes: float) -> None:
        super().__init__()
        self.path = path
        self.seconds = 60.0 * minutes
        self.rows: list[dict[str, Any]] = []
        self.episodes: list[tuple[float, bool]] = []
        self.began = time.monotonic()

    def _on_step(self) -> bool:
        for info in self.locals["infos"]:
            if "episode" in info:
                self.episodes.append((info["episode"]["r"], info["is_success"]))
        while len(self.episodes) >= WINDOW:
            window, self.episodes = self.episodes[:WINDOW], self.episodes[WINDOW:]
            returns, successes = zip(*window)
            row = {
                "steps": self.num_timesteps,
                "seconds": round(time.monotonic() - self.began, 1),
                "return": round(float(np.mean(returns)), 3),
                "success": round(float(np.mean(successes)), 3),
            }
            self.rows.append(row)
            print(row, flush=True)
            with self.path.open("w", newline="") as file:
                writer = csv.DictWriter(file, fieldnames=list(row))
                writer.writeheader()
                writer.writerows(self.rows)
        return time.monotonic() - self.began < self.seconds


def main() -> None:
    seed, folder = int(sys.argv[1]), Path(sys.argv[2])
    minutes = float(sys.argv[3]) if len(sys.argv) > 3 else MINUTES
    folder.mkdir(parents=True, exist_ok=True)
    # The other core simulates.
    torch.set_num_threads(1)
    envs = openbench.envs.point_goal_vector(ENVIRONMENTS, threads=2)
    env = VecNormalize(DeliveryVecEnv(envs), norm_obs_keys=["range_image", "goal", "wheels"])
    env.seed(seed)
    model = PPO(
        "MultiInputPolicy",
        env,
        seed=seed,
        n_steps=64,
        batch_size=128,
        n_epochs=10,
        gamma=0.99,
        learning_rate=3e-4,
        policy_kwargs={"net_arch": [64, 64]},
    )
    # The callback ends it.
    model.learn(10**9, callback=Curve(folder / f"seed-{seed}.csv", minutes))
    model.save(folder / f"seed-{seed}.zip")
    moments: dict[str, Any] = {}
    for key, rms in env.obs_rms.items():
        moments[key] = np.stack([rms.mean, rms.var])
    np.savez(folder / f"seed-{seed}.npz", **moments)


if __name__ == "__main__":
    main()

"""Environments answer what LeRobot's evaluation asks for, in its order."""

from __future__ import annotations

import numpy as np

from openbench.lerobot import make_env


def test_the_calls_of_an_evaluation_are_answered() -> None:
    envs = make_env(n_envs=2)
    observations, _ = envs.reset(seed=[1, 2], options={"lerobot_new_rollout": True})
    assert envs.observation_space.contains(observations)
    assert envs.call("_max_episode_steps") == (3000, 3000)
    assert all("unit" in text for text in envs.call("task_description"))
    assert envs.envs[0].task_description == envs.call("task_description")[0]
    observations, *_ = envs.step(np.tile([0.1, 0.0, 0.0], (2, 1)))
    assert envs.observation_space.contains(observations)
    _, _, terminations, _, infos = envs.step(np.tile([0.0, 0.0, 1.0], (2, 1)))
    # The first environment has one delivery, the second a sequence.
    assert list(terminations) == [True, False]
    assert infos["final_info"]["is_success"].tolist() == [False, False]
    assert envs.single_observation_space.contains(infos["final_obs"][0])

"""Environments keep the contracts of `gymnasium`."""

from __future__ import annotations

import math
import multiprocessing
import threading
import warnings
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env, data_equivalence
from gymnasium.vector import AutoresetMode

import openbench
from openbench.envs import DeliveryEnv, DeliveryVectorEnv

#: Warnings of the checker about spaces that are as they should be.
EXPECTED = ("infinity", "symmetric", "not wrapped")
ALL = ("image", "points", "range_image", "imu", "wheels", "pose", "goal")


@pytest.mark.parametrize("name", ["openbench/Delivery-v0", "openbench/PointGoal-v0"])
def test_the_checker_of_gymnasium_is_content(name: str) -> None:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        check_env(gym.make(name, disable_env_checker=True).unwrapped)
    said = [str(warning.message) for warning in caught]
    assert [text for text in said if not any(word in text for word in EXPECTED)] == []


def test_each_observation_is_in_its_space() -> None:
    env = openbench.make("small", seed=1, observations=ALL, goal="point", start=(2.0, 5.0))
    observation, info = env.reset()
    assert set(observation) == {*ALL, "health", "point_count"}
    for _ in range(4):
        assert env.observation_space.contains(observation)
        observation, *_ = env.step(np.array([0.2, 0.1, 0.0]))
    assert observation["image"].std() > 5
    assert observation["range_image"].min() < 40
    assert 1_000 < observation["point_count"] <= 20_000
    assert info["open_address"].startswith("unit")


def test_fewer_rays_give_fewer_points_of_the_same_scan_and_are_named() -> None:
    def last(one_firing_in: int) -> tuple[Any, Any]:
        env = DeliveryEnv(
            "small", observations=("points",), one_firing_in=one_firing_in, time_limit=0.5
        )
        env.reset(seed=1)
        while True:
            observation, _, terminated, truncated, info = env.step(np.zeros(3))
            if terminated or truncated:
                return observation["points"][: observation["point_count"]], info

    (whole, _), (part, info) = last(1), last(8)
    assert len(whole) > 1_000 and 7 * len(part) < len(whole) < 9 * len(part)
    assert {tuple(point) for point in part} <= {tuple(point) for point in whole}
    assert info["one_firing_in"] == 8


def test_the_same_seed_gives_the_same_episode() -> None:
    def drive(seed: int) -> list[Any]:
        env = gym.make("openbench/PointGoal-v0")
        seen: list[Any] = [env.reset(seed=seed)]
        env.action_space.seed(seed)
        return seen + [env.step(env.action_space.sample()) for _ in range(20)]

    assert data_equivalence(drive(3), drive(3), exact=True)
    assert not data_equivalence(drive(3), drive(4), exact=True)


def test_the_end_has_the_scores_of_the_judge() -> None:
    env = DeliveryEnv("small")
    env.reset(seed=0, options={"episode": 2})
    _, reward, terminated, truncated, info = env.step(np.array([0.0, 0.0, 1.0]))
    assert terminated and not truncated and reward < -4
    assert info["is_success"] is False and info["uses_truth"] is False
    assert info["deliveries"][0]["failure"] == "wrong_place"
    with pytest.raises(RuntimeError, match="reset first"):
        env.step(np.array([0.0, 0.0, 0.0]))


def vector(count: int = 3, **settings: Any) -> DeliveryVectorEnv:
    env = gym.make_vec(
        "openbench/PointGoal-v0", num_envs=count, time_limit=1.0, threads=2, **settings
    )
    assert isinstance(env, DeliveryVectorEnv)
    return env


def test_a_vector_does_what_its_environments_do_alone() -> None:
    many = vector()
    observations, infos = many.reset(seed=5)
    assert many.observation_space.contains(observations)
    assert many.metadata["autoreset_mode"] is AutoresetMode.SAME_STEP
    assert infos["_instruction"].all()
    ended = False
    for step in range(8):
        actions = np.full((3, 2), 0.1 * step)
        before = observations
        observations, rewards, terminations, truncations, infos = many.step(actions)
        assert many.observation_space.contains(observations)
        assert rewards.shape == terminations.shape == truncations.shape == (3,)
        for key in observations:
            assert not np.shares_memory(before[key], observations[key])
        if truncations.any():
            ended = True
            assert (infos["_final_info"] == truncations).all()
            final = infos["final_info"]["is_success"]
            assert final.dtype == bool and final.shape == (3,)
            last = infos["final_obs"][0]
            assert many.single_observation_space.contains(last)
            assert not np.array_equal(last["range_image"], observations["range_image"][0])
    assert ended


def test_some_of_a_vector_can_be_reset() -> None:
    many = vector()
    first, _ = many.reset(seed=1)
    mask = np.array([False, True, False])
    options = {"reset_mask": mask, "something": "else"}
    second, _ = many.reset(seed=7, options=options)
    same = [np.array_equal(first["goal"][i], second["goal"][i]) for i in range(3)]
    assert same == [True, False, True]


def test_steps_of_a_vector_can_be_received_one_by_one() -> None:
    many = vector()
    many.reset(seed=1)
    many.send(2, np.array([0.1, 0.0]))
    with pytest.raises(RuntimeError, match="at work"):
        many.send(2, np.array([0.1, 0.0]))
    numbers, observations, *_ = many.receive(1)
    assert list(numbers) == [2] and observations["goal"].shape == (1, 2)


@pytest.mark.parametrize(
    ("action", "problem"),
    [
        (np.array([0.1, 0.0]), "shape"),
        ([0.1, 0.0, np.nan], "finite"),
        ([[0.1, 0.0, 0.0]], "shape"),
        (["fast", "left", "no"], "could not convert"),
    ],
)
def test_a_wrong_action_is_an_error_and_the_episode_goes_on(action: Any, problem: str) -> None:
    env = DeliveryEnv("small")
    env.reset(seed=0)
    with pytest.raises(ValueError, match=problem):
        env.step(action)
    env.step(np.array([0.1, 0.0, 0.0]))


@pytest.mark.parametrize(
    "settings",
    [
        {"observations": ["lidar"]},
        {"goal": "home"},
        {"observations": ["goal"]},
        {"one_firing_in": 0},
        {"one_firing_in": 101},
        {"pose": "gps"},
        {"rewards": {"speed": 1.0}},
        {"steps": 0},
        {"start": (3.0, 2.0)},
        {"arrival": 5.0},
        {"range_image": (0, 10)},
        {"time_limit": -1.0},
        {"time_limit": float("nan")},
        {"rewards": {"progress": float("inf")}},
    ],
)
def test_a_wrong_setting_is_refused_with_what_to_write(settings: dict[str, Any]) -> None:
    with pytest.raises(openbench.InputError):
        DeliveryEnv("small", **settings)


def test_an_unknown_suite_names_those_that_there_are() -> None:
    with pytest.raises(openbench.InputError, match="small, medium"):
        DeliveryEnv("tiny")


def test_conditions_change_the_map_and_not_the_world() -> None:
    def env(**settings: Any) -> DeliveryEnv:
        return openbench.make("small", seed=1, observations=("image",), **settings)

    right = env()
    wrong = env(conditions={"map": "city"}, world_seed=3)
    assert wrong.map != right.map
    assert wrong.map == env(conditions={"map": "city"}, world_seed=3).map
    assert wrong.map != env(conditions={"map": "city"}, world_seed=4).map
    seen = [env.reset()[0]["image"] for env in (right, wrong)]
    assert np.array_equal(*seen)


@pytest.mark.parametrize(
    ("conditions", "problem"),
    [
        ({"map": "village"}, "write one of exact, good, city, poor"),
        ({"map.shift_m": -1}, "give a number from 0 to 100"),
        ({"season": "winter"}, "there is no such condition"),
    ],
)
def test_a_condition_that_there_is_not_is_refused(conditions: Any, problem: str) -> None:
    with pytest.raises(openbench.InputError, match=problem):
        openbench.make("small", conditions=conditions)


def test_a_pose_needs_a_start() -> None:
    env = openbench.make("small", observations=("pose",), conditions={"start": "block"})
    with pytest.raises(openbench.InputError, match="gives no pose to begin with"):
        env.reset()


def test_a_closed_environment_says_so() -> None:
    env = DeliveryEnv("small")
    env.reset(seed=0)
    env.close()
    env.close()
    with pytest.raises(RuntimeError, match="closed"):
        env.step(np.array([0.0, 0.0, 0.0]))


def test_two_threads_on_one_environment_are_an_error_and_no_deadlock() -> None:
    many = vector(8)
    many.reset(seed=0)
    errors: list[Exception] = []

    def drive() -> None:
        try:
            for _ in range(20):
                many.step(np.zeros((8, 2)))
        except RuntimeError as error:
            errors.append(error)

    threads = [threading.Thread(target=drive) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
        assert not thread.is_alive()
    assert all("another thread" in str(error) for error in errors)
    many.step(np.zeros((8, 2)))


def in_child(env: DeliveryEnv, queue: Any) -> None:
    try:
        env.step(np.array([0.0, 0.0, 0.0]))
        queue.put("no error")
    except RuntimeError as error:
        queue.put(str(error))


def test_a_fork_cannot_use_its_parents_environment() -> None:
    env = DeliveryEnv("small")
    env.reset(seed=0)
    context = multiprocessing.get_context("fork")
    queue = context.Queue()
    child = context.Process(target=in_child, args=(env, queue))
    child.start()
    assert "belongs to the process" in queue.get(timeout=60)
    child.join(60)
    env.step(np.array([0.0, 0.0, 0.0]))


def test_a_picture_can_be_rendered() -> None:
    env = DeliveryEnv("small", render_mode="rgb_array")
    env.reset(seed=0)
    picture = env.render()
    assert picture is not None
    assert picture.shape == (480, 640, 3) and picture.dtype == np.uint8
    assert picture.std() > 5


def test_a_waypoint_is_driven_to() -> None:
    env = DeliveryEnv("small", actions="waypoint", observations=("pose",), steps=60)
    assert env.action_space.shape == (3,)
    before = env.reset(seed=3)[0]["pose"]
    after = env.step(np.array([0.4, 0.0, 0.0]))[0]["pose"]
    assert abs(math.dist(before[:2], after[:2]) - 0.4) < 0.15
    env.close()
    with pytest.raises(openbench.InputError, match="pose"):
        openbench.make("small", actions="waypoint")
    with pytest.raises(openbench.InputError, match="velocity, waypoint"):
        openbench.make("small", actions="joints")

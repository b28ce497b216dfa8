"""How fast environments are: speed.py [SECONDS]

Point goals in `medium` with images of distances, a step an action. Times are of the wall; the
machine should do nothing else.
"""

from __future__ import annotations

import multiprocessing
import os
import sys
import time
from typing import Any

import numpy as np

import openbench
from openbench.envs import DeliveryVectorEnv

SETTINGS: dict[str, Any] = {
    "observations": ("range_image", "goal", "wheels"),
    "goal": "point",
    "steps": 1,
}
STEP_S = 0.05
ENVIRONMENTS = 8


def actions(count: int, step: int) -> Any:
    turn = 0.3 if step // 200 % 3 == 0 else -0.1
    return np.tile([0.3, turn, 0.0], (count, 1))


def single(seconds: float, **settings: Any) -> float:
    """Simulated seconds in a second of one environment."""
    env = openbench.make("medium", seed=0, **{**SETTINGS, **settings})
    env.reset()
    steps, began = 0, time.perf_counter()
    while time.perf_counter() - began < seconds:
        _, _, terminated, truncated, _ = env.step(actions(1, steps)[0])
        steps += 1
        if terminated or truncated:
            env.reset()
    return steps * STEP_S / (time.perf_counter() - began)


def in_process(seconds: float, queue: Any) -> None:
    queue.put(single(seconds))


def processes(count: int, seconds: float) -> float:
    """The sum over independent processes with an environment each."""
    context = multiprocessing.get_context("spawn")
    queue = context.Queue()
    children = [context.Process(target=in_process, args=(seconds, queue)) for _ in range(count)]
    for child in children:
        child.start()
    total: float = sum(queue.get() for _ in children)
    for child in children:
        child.join()
    return total


def vector(threads: int) -> DeliveryVectorEnv:
    env = DeliveryVectorEnv(ENVIRONMENTS, "medium", threads=threads, **SETTINGS)
    env.reset(seed=0)
    return env


def synchronous(seconds: float, threads: int) -> float:
    env = vector(threads)
    steps, began = 0, time.perf_counter()
    while time.perf_counter() - began < seconds:
        env.step(actions(ENVIRONMENTS, steps))
        steps += 1
    speed = steps * ENVIRONMENTS * STEP_S / (time.perf_counter() - began)
    env.close()
    return speed


def asynchronous(seconds: float, threads: int) -> float:
    env = vector(threads)
    for index in range(ENVIRONMENTS):
        env.send(index, actions(1, 0)[0])
    steps, began = 0, time.perf_counter()
    while time.perf_counter() - began < seconds:
        numbers, *_ = env.receive(1)
        steps += 1
        env.send(int(numbers[0]), actions(1, steps // ENVIRONMENTS)[0])
    speed = steps * STEP_S / (time.perf_counter() - began)
    env.close()
    return speed


def python_share(steps: int) -> float:
    """Share of a step's time that Python takes, by timing the call into Rust apart."""
    env = openbench.make("medium", seed=0, **SETTINGS)
    env.reset()
    inner = env._environments
    spent = 0.0

    class Timed:
        def step(self, rows: Any) -> Any:
            nonlocal spent
            began = time.perf_counter()
            try:
                return inner.step(rows)
            finally:
                spent += time.perf_counter() - began

        def __getattr__(self, name: str) -> Any:
            return getattr(inner, name)

    env._environments = Timed()  # type: ignore[assignment]
    began = time.perf_counter()
    for step in range(steps):
        env.step(actions(1, step)[0])
    whole = time.perf_counter() - began
    return 1.0 - spent / whole


def main() -> None:
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 20.0
    cores = len(os.sched_getaffinity(0))
    print(f"{cores} cores; simulated seconds in a second, medium, range image and point goal")
    one = single(seconds)
    print(f"one environment, wheels       {one:7.1f}")
    print(f"one environment, odometry     {single(seconds, pose='odometry'):7.1f}")
    print(f"share of Python in a step     {100 * python_share(2000):7.1f} %")
    two = processes(2, seconds)
    print(f"two processes                 {two:7.1f}")
    fast = asynchronous(seconds, 2)
    share = 100 * fast / two
    print(f"{ENVIRONMENTS} asynchronous, two threads   {fast:7.1f}   {share:.0f} % of them")
    single_thread = synchronous(seconds, 1)
    print(f"{ENVIRONMENTS} synchronous, one thread     {single_thread:7.1f}")
    both = synchronous(seconds, 2)
    ratio = both / single_thread
    print(f"{ENVIRONMENTS} synchronous, two threads    {both:7.1f}   {ratio:.2f} times")


if __name__ == "__main__":
    main()

"""Episodes of the benchmark as `gymnasium` environments.

`openbench/Delivery-v0` is one environment, and with `gymnasium.make_vec` several on threads of
Rust. `openbench/PointGoal-v0` begins near a door whose place is known: a short task for a first
policy.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import gymnasium as gym
import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from openbench._openbench import EnvironmentOptions, Environments
from openbench.conditions import Conditions, written

Array = npt.NDArray[Any]
Observations = dict[str, Any]

#: Limits of the robot: forward and backward, m/s, and turning, rad/s.
FORWARD, BACKWARD, TURN = 0.5, 0.2, 1.0
#: Farthest waypoint along each axis, metres.
REACH = 5.0
#: Range of the LiDAR, metres.
RANGE = 50.0
#: Samples of the IMU in a step of 50 ms.
IMU_SAMPLES = 5


class Settings:
    """What an environment observes, asks and rewards; see `DeliveryEnv`."""

    def __init__(
        self,
        *,
        observations: Sequence[str] = ("range_image", "wheels"),
        goal: str = "instruction",
        start: tuple[float, float] | None = None,
        steps: int = 1,
        actions: str = "velocity",
        arrival: float | None = None,
        rewards: dict[str, float] | None = None,
        range_image: tuple[int, int] = (8, 120),
        one_firing_in: int = 1,
        pose: str = "wheels",
        time_limit: float | None = None,
        privileged: bool = False,
    ) -> None:
        self.observations = tuple(observations)
        self.goal = goal
        self.steps = steps
        self.kind = actions
        self.arrival = arrival
        self.range_image = range_image
        self.one_firing_in = one_firing_in
        self.privileged = privileged
        self.options = EnvironmentOptions(
            observations=list(observations),
            goal=goal,
            start=start,
            steps=steps,
            actions=actions,
            arrival=arrival,
            rewards=rewards or {},
            range_image=range_image,
            one_firing_in=one_firing_in,
            pose=pose,
            time_limit=time_limit,
        )

    def observation_space(self) -> spaces.Dict:
        """The space of one observation."""
        space: dict[str, spaces.Space[Any]] = {}
        if "image" in self.observations:
            space["image"] = spaces.Box(0, 255, (480, 640, 3), np.uint8)
        if "points" in self.observations:
            space["points"] = spaces.Box(-RANGE - 1, RANGE + 1, (20_000, 3), np.float32)
            space["point_count"] = spaces.Box(0, 20_000, (), np.int64)
        if "range_image" in self.observations:
            space["range_image"] = spaces.Box(0.0, RANGE + 1, self.range_image, np.float32)
        if "imu" in self.observations:
            shape = (IMU_SAMPLES * self.steps, 6)
            space["imu"] = spaces.Box(-1000.0, 1000.0, shape, np.float32)
        if "wheels" in self.observations:
            space["wheels"] = spaces.Box(-100.0, 100.0, (2,), np.float32)
        if "pose" in self.observations:
            space["pose"] = spaces.Box(-1e8, 1e8, (3,), np.float64)
            space["health"] = spaces.Discrete(3)
        if "goal" in self.observations:
            space["goal"] = spaces.Box(-1e6, 1e6, (2,), np.float32)
        return spaces.Dict(space)

    def action_space(self) -> spaces.Box:
        """The space of one action: linear, m/s, angular, rad/s, or a waypoint, and whether to
        declare."""
        if self.kind == "waypoint":
            low, high = [-REACH, -REACH], [REACH, REACH]
        else:
            low, high = [-BACKWARD, -TURN], [FORWARD, TURN]
        if self.arrival is None:
            low, high = [*low, 0.0], [*high, 1.0]
        return spaces.Box(np.array(low), np.array(high), dtype=np.float64)

    def actions(self, given: Array, count: int) -> npt.NDArray[np.float64]:
        """Actions as the environments take them."""
        width = 3 if self.arrival is None else 2
        actions = np.asarray(given, dtype=np.float64)
        if actions.shape != (count, width):
            raise ValueError(
                f"actions have shape {actions.shape}; expected {(count, width)}, "
                "in each row the numbers of the action space"
            )
        if width == 2:
            actions = np.concatenate([actions, np.zeros((count, 1))], axis=1)
        return np.ascontiguousarray(actions)


class DeliveryVectorEnv(VectorEnv[Observations, Array, Array]):
    """Several environments in one world, on threads that do not wait for Python."""

    metadata: dict[str, Any] = {
        "render_modes": ["rgb_array"],
        "render_fps": 20,
        "autoreset_mode": AutoresetMode.SAME_STEP,
    }

    def __init__(
        self,
        num_envs: int = 1,
        suite: str = "small",
        *,
        threads: int | None = None,
        render_mode: str | None = None,
        conditions: Conditions | None = None,
        world_seed: int = 0,
        **settings: Any,
    ) -> None:
        self.settings = Settings(**settings)
        self.num_envs = num_envs
        self.render_mode = render_mode
        self.single_observation_space = self.settings.observation_space()
        self.single_action_space = self.settings.action_space()
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._environments = Environments(
            (suite, written(conditions), world_seed),
            self.settings.options,
            num_envs,
            threads or num_envs,
            autoreset=True,
        )
        self._observations: Observations = {}

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Observations, dict[str, Any]]:
        """Begins an episode in each environment, or in those of `options["reset_mask"]`."""
        seeds = _seeds(seed, self.num_envs)
        options = options or {}
        mask = options.get("reset_mask", np.ones(self.num_envs, dtype=bool))
        episode = options.get("episode")
        begin = [(seeds[i], episode) if mask[i] else None for i in range(self.num_envs)]
        begun = self._environments.reset(begin)
        if all(mask):
            observations = begun
        else:
            observations = {key: value.copy() for key, value in self._observations.items()}
            for key, value in begun.items():
                observations[key][mask] = value
        self._observations = observations
        infos: dict[str, Any] = {}
        for i in range(self.num_envs):
            if mask[i]:
                infos = self._add_info(infos, self._info(i), i)
        return observations, infos

    def step(
        self, actions: Array
    ) -> tuple[Observations, Array, Array, Array, dict[str, Any]]:
        """A step of each; where an episode ends, the next one begins in the same step."""
        rows = self.settings.actions(actions, self.num_envs)
        return self._stepped(range(self.num_envs), self._environments.step(rows))

    def send(self, index: int, action: Array) -> None:
        """Lets one environment begin a step, whose result `receive` returns."""
        row = self.settings.actions(np.asarray(action)[None], 1)[0]
        self._environments.send(index, (row[0], row[1], row[2]))

    def receive(
        self, count: int
    ) -> tuple[Array, Observations, Array, Array, Array, dict[str, Any]]:
        """The first `count` steps that are done: numbers of environments, then as `step`."""
        numbers, stepped = self._environments.receive(count)
        return numbers, *self._stepped(numbers, stepped)

    def _stepped(
        self, numbers: Any, stepped: Any
    ) -> tuple[Observations, Array, Array, Array, dict[str, Any]]:
        observations, rewards, terminations, truncations, ends = stepped
        infos: dict[str, Any] = {}
        for row, last, scores in ends:
            final = {key: value[0] for key, value in last.items()}
            ended = {"final_obs": final, "final_info": final_info(scores, self.settings)}
            infos = self._add_info(infos, ended, row)
            # Of the episode that has begun.
            infos = self._add_info(infos, self._info(int(numbers[row])), row)
        if self.settings.privileged:
            for row, number in enumerate(numbers):
                infos = self._add_info(infos, self._privileged(int(number)), row)
        self._observations = observations
        return observations, rewards, terminations, truncations, infos

    def _info(self, index: int) -> dict[str, Any]:
        info = info_of(self._environments.episode(index))
        return {**info, **self._privileged(index)} if self.settings.privileged else info

    def _privileged(self, index: int) -> dict[str, Any]:
        known = self._environments.privileged(index)
        if known is None:
            return {}
        pose, left = known
        return {"true_pose": np.array(pose), "way_left": -1.0 if left is None else left}

    def render(self) -> tuple[Array, ...] | None:
        """A picture of each, from the robot's camera."""
        if self.render_mode != "rgb_array":
            return None
        pictures = (self._environments.picture(i) for i in range(self.num_envs))
        return tuple(picture for picture in pictures if picture is not None)

    def close_extras(self, **kwargs: Any) -> None:
        """Ends the threads."""
        self._environments.close()


class DeliveryEnv(gym.Env[Observations, Array]):
    """Deliveries of a suite.

    suite: a built-in suite, a suite file, or the folder of a world.
    conditions: what makes the suite harder: levels, as in `{"map": "city"}`, or numbers, as in
        `{"map.shift_m": 3}`.
    world_seed: seed of what the conditions draw for all episodes alike, such as the map.
        Another neighbourhood is another suite: `"medium-7"`.
    observations: any of `image`, `points`, `range_image`, `imu`, `wheels`, `pose` (with `health`)
        and `goal`.
    goal: `instruction`, or `point`: the place before the door, seen from the estimated pose.
    start: least and largest way to the door at the beginning, m; `None` for the world's start.
    steps: how many steps of 50 ms an action lasts.
    actions: `velocity`, or `waypoint`: metres ahead and to the left, to where the robot drives by
        pure pursuit from where it takes itself to be; it needs `pose` or `goal` among the
        observations.
    arrival: distance to the door at which the environment itself declares the delivery, m; the
        action is then two numbers. `None` leaves it to the policy.
    rewards: weights of `progress` (per metre), `success`, `failure`, `contact` and `time` (per
        second).
    range_image: its rows and columns.
    one_firing_in: the LiDAR casts the four rays of one firing in so many, 1 to 100. Rays are most of
        the time of a step, and a coarse range image needs few; `info` names it beside the scores.
    pose: where poses come from: `wheels`, or `odometry` by LiDAR and IMU.
    time_limit: simulated seconds from the first observation to truncation.
    privileged: whether `info` has the true pose and the length of the way that is left.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 20}

    def __init__(
        self,
        suite: str = "small",
        *,
        render_mode: str | None = None,
        conditions: Conditions | None = None,
        world_seed: int = 0,
        **settings: Any,
    ) -> None:
        self.settings = Settings(**settings)
        self.render_mode = render_mode
        self.observation_space = self.settings.observation_space()
        self.action_space = self.settings.action_space()
        self._environments = Environments(
            (suite, written(conditions), world_seed),
            self.settings.options,
            1,
            1,
            autoreset=False,
        )
        self._running = False

    @property
    def map(self) -> bytes:
        """The public map, OSM XML."""
        return self._environments.map()

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observations, dict[str, Any]]:
        """Begins an episode: that of `options["episode"]`, or one that is drawn."""
        super().reset(seed=seed)
        episode = (options or {}).get("episode")
        drawn = int(self.np_random.integers(2**63))
        observations = self._environments.reset([(drawn, episode)])
        self._running = True
        return _only(observations), self._info()

    def step(self, action: Array) -> tuple[Observations, float, bool, bool, dict[str, Any]]:
        """Does an action; `info` has the scores at the end."""
        if not self._running:
            raise RuntimeError("there is no episode: call reset first, and after each end")
        rows = self.settings.actions(np.asarray(action)[None], 1)
        observations, rewards, terminations, truncations, ends = self._environments.step(rows)
        for _, observations, scores in ends:
            info = final_info(scores, self.settings)
            self._running = False
        if not ends:
            info = self._info()
        return (
            _only(observations),
            float(rewards[0]),
            bool(terminations[0]),
            bool(truncations[0]),
            info,
        )

    def render(self) -> Array | None:
        """A picture from the robot's camera."""
        return self._environments.picture(0) if self.render_mode == "rgb_array" else None

    def close(self) -> None:
        """Ends the environment."""
        self._environments.close()

    def _info(self) -> dict[str, Any]:
        info = info_of(self._environments.episode(0))
        known = self._environments.privileged(0) if self.settings.privileged else None
        if known is not None:
            info["true_pose"] = np.array(known[0])
            info["way_left"] = known[1]
        return info


def info_of(episode: tuple[str, str, float]) -> dict[str, Any]:
    """What is known of an episode: its instruction, open address and time."""
    instruction, open_address, time = episode
    return {"instruction": instruction, "open_address": open_address, "time": time}


def final_info(text: str, settings: Settings) -> dict[str, Any]:
    """The scores of an episode that has ended, whether the truth was used besides rewards, and how
    coarse the LiDAR was."""
    outcome: dict[str, Any] = json.loads(text)
    uses_truth = settings.privileged or settings.arrival is not None
    return {**outcome, "uses_truth": uses_truth, "one_firing_in": settings.one_firing_in}


def _only(observations: Observations) -> Observations:
    return {key: value[0] for key, value in observations.items()}


def _seeds(seed: int | Sequence[int | None] | None, count: int) -> list[int | None]:
    if seed is None:
        return [None] * count
    if isinstance(seed, int):
        return [seed + i for i in range(count)]
    if len(seed) != count:
        raise ValueError(f"there are {count} environments and {len(seed)} seeds")
    return list(seed)


def point_goal(**settings: Any) -> DeliveryEnv:
    """A short task: a door a few metres away whose place is known. Results of its episodes are those
    of training: the environment declares by the truth, and the LiDAR has an eighth of its rays."""
    return DeliveryEnv(**{**POINT_GOAL, **settings})


def point_goal_vector(num_envs: int = 1, **settings: Any) -> DeliveryVectorEnv:
    """Several of `point_goal`."""
    return DeliveryVectorEnv(num_envs, **{**POINT_GOAL, **settings})


#: Settings of `openbench/PointGoal-v0`.
POINT_GOAL: dict[str, Any] = {
    "observations": ("range_image", "goal", "wheels"),
    "goal": "point",
    "start": (1.5, 6.0),
    "steps": 4,
    "arrival": 1.0,
    "range_image": (2, 36),
    "one_firing_in": 8,
    "time_limit": 60.0,
}

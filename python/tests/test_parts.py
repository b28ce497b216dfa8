"""The parts of the baseline on arrays."""

from __future__ import annotations

import math
import threading

import numpy as np
import pytest

import openbench
from openbench.parts import Costmap, LocalPlanner, Map, Obstacle, Odometry

#: A house of 11 m by 11 m with one door, and a street past it; a second house stands alone.
OSM = b"""<osm version="0.6">
  <node id="1" lat="0" lon="0"/><node id="2" lat="0" lon="0.0001"/>
  <node id="3" lat="0.0001" lon="0.0001"/><node id="4" lat="0.0001" lon="0"/>
  <node id="5" lat="0" lon="0.00005"><tag k="entrance" v="yes"/><tag k="ref" v="1"/></node>
  <node id="6" lat="-0.0001" lon="-0.0003"/><node id="7" lat="-0.0001" lon="0.0005"/>
  <way id="9"><nd ref="1"/><nd ref="5"/><nd ref="2"/><nd ref="3"/><nd ref="4"/><nd ref="1"/>
    <tag k="building" v="yes"/><tag k="name" v="building3"/></way>
  <way id="10"><nd ref="6"/><nd ref="7"/>
    <tag k="highway" v="residential"/><tag k="name" v="Long Lane"/></way>
</osm>"""
FRAME = "tangent:0,0"


@pytest.fixture
def town() -> Map:
    return Map(OSM, FRAME)


def test_a_map_has_buildings_addresses_and_degrees(town: Map) -> None:
    (building,) = town.buildings
    assert building.name == "building3" and building.outline.shape == (5, 2)
    door = town.locate("building3", "1")
    assert door is not None and math.dist(door, (5.57, 0.0)) < 0.1
    assert town.locate("building4") is None
    assert town.georeference.startswith("tangent:")
    metres = town.to_map([[0.0001, 0.0]])
    assert abs(metres[0, 0] - 11.13) < 0.02
    assert np.allclose(town.to_lonlat(metres), [[0.0001, 0.0]], atol=1e-12)


def test_routes_and_plans(town: Map) -> None:
    route = town.route((-30.0, -10.0), (40.0, -12.0))
    assert route["names"] == ["Long Lane"] and 60.0 < route["distance"] < 80.0
    assert route["points"].shape[1] == 2
    (delivery,) = town.plan("Bring the box to unit 1, building 3")
    assert (delivery["building"], delivery["unit"]) == ("building3", "1")
    with pytest.raises(openbench.PlanningError):
        town.plan("la la la")
    with pytest.raises(openbench.PlanningError):
        town.route((-30.0, -10.0), (9000.0, 0.0))


def test_a_path_leads_around_a_building_and_what_a_scan_sees(town: Map) -> None:
    costmap = Costmap(town, (-20.0, -20.0), (30.0, 30.0))
    rows, columns = costmap.costs.shape
    assert rows * costmap.cell >= 50.0 and columns * costmap.cell >= 50.0
    straight = math.dist((-5.0, 5.0), (16.0, 5.0))

    def length(path: np.ndarray) -> float:
        return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())

    around = costmap.plan((-5.0, 5.0), (16.0, 5.0))
    assert length(around) > straight + 2.0
    before = length(costmap.plan((-15.0, -15.0), (-5.0, -15.0)))
    wall = [[-10.0, y, 0.3] for y in np.arange(-18.0, -12.0, 0.05)]
    costmap.observe(wall, (-15.0, -15.0, 0.25))
    assert length(costmap.plan((-15.0, -15.0), (-5.0, -15.0))) > before + 1.0
    with pytest.raises(openbench.PlanningError):
        costmap.plan((-5.0, 5.0), (500.0, 5.0))


@pytest.mark.parametrize("name", ["teb", "follower", "mppi"])
def test_a_planner_drives_to_the_end_around_an_obstacle(name: str) -> None:
    planner = LocalPlanner(name)
    pose, velocity, time = (0.0, 0.0, 0.0), (0.0, 0.0), 0.0
    path = [[0.0, 0.0], [4.0, 0.0]]
    # In the way of the planner that drives around it; pure pursuit would wait before it.
    pillar = [Obstacle([[2.0, 0.1]], rounding=0.2)] if name == "teb" else []
    nearest = math.inf
    while math.dist(pose[:2], (4.0, 0.0)) > 0.3 and time < 60.0:
        decided = planner.plan(time, pose, velocity, path, pillar)
        assert decided is not None
        velocity = decided
        x, y, yaw = pose
        yaw += 0.05 * velocity[1]
        pose = (
            x + 0.05 * velocity[0] * math.cos(yaw),
            y + 0.05 * velocity[0] * math.sin(yaw),
            yaw,
        )
        nearest = min(nearest, math.dist(pose[:2], (2.0, 0.1)))
        time += 0.05
    assert time < 60.0
    if pillar:
        assert nearest > 0.3
    planner.reset()
    assert planner.plan(time, (4.0, 0.0, 0.0), (0.0, 0.0), path) is None


def test_odometry_sees_that_a_body_rests() -> None:
    # The ground half a metre below the LiDAR, a wall 4 m to the left, one 5 m ahead.
    i = np.arange(3000)
    a, b = i // 3 % 40 * 0.1 - 2.0, i // 120 * 0.1 - 0.4
    flat = np.zeros(3000)
    surfaces = ((a, b, flat - 0.5), (a, flat + 4.0, b), (flat + 5.0, a, b))
    kinds = [np.stack(columns, 1) for columns in surfaces]
    points = np.choose((i % 3)[:, None], kinds)
    odometry, estimates = Odometry(), []
    for scan in range(30):
        stamps = 10_000_000 * (10 * scan + np.arange(10))
        estimates += odometry.imu(stamps, np.zeros((10, 3)), [[0.0, 0.0, 9.81]] * 10)
        estimates += odometry.scan(int(stamps[0]), points, i * 30_000)
    last = estimates[-1]
    assert last.status == "tracking" and last.points > 100
    assert np.linalg.norm(last.pose[:3, 3]) < 0.01
    assert last.covariance.shape == (6, 6) and last.velocity.shape == (3,)


def test_what_cannot_be_used_is_an_exception(town: Map) -> None:
    for broken in (b"", b"<osm", b"\xff\xfe"):
        with pytest.raises(openbench.InputError):
            Map(broken, FRAME)
    with pytest.raises(openbench.InputError):
        Map(OSM, "moon")
    with pytest.raises(openbench.InputError, match="nowhere.osm"):
        Map.read("nowhere.osm")
    with pytest.raises(ValueError, match="lonlat"):
        town.to_map([[1.0, 2.0, 3.0]])
    with pytest.raises(ValueError, match="goal"):
        town.route((0.0, 0.0), (math.nan, 0.0))
    with pytest.raises(openbench.InputError, match="zigzag"):
        LocalPlanner("zigzag")
    with pytest.raises(openbench.PlanningError):
        LocalPlanner().plan(0.0, (0.0, 0.0, math.nan), (0.0, 0.0), [[0.0, 0.0], [1.0, 0.0]])
    with pytest.raises(ValueError, match="corners"):
        Obstacle([[0.0, math.inf]])
    with pytest.raises(ValueError, match="lidar"):
        Odometry(lidar=np.ones((4, 4)))
    with pytest.raises(ValueError, match="gyro"):
        Odometry().imu([0, 1], np.zeros((1, 3)), np.zeros((2, 3)))
    with pytest.raises(ValueError, match="offsets"):
        Odometry().scan(0, np.zeros((2, 3)), [0])
    with pytest.raises(ValueError, match="stamps: write integers, nanoseconds"):
        Odometry().imu([0.0, 0.5], np.zeros((2, 3)), np.zeros((2, 3)))
    with pytest.raises(ValueError, match="negative"):
        Odometry().imu([-1], np.zeros((1, 3)), np.zeros((1, 3)))
    with pytest.raises(openbench.PlanningError, match="no path"):
        LocalPlanner().plan(0.0, np.zeros(3), np.zeros(2), [])


def test_two_threads_share_a_costmap_and_an_odometry(town: Map) -> None:
    costmap, odometry = Costmap(town, (-20.0, -20.0), (30.0, 30.0)), Odometry()
    errors: list[BaseException] = []

    def work() -> None:
        try:
            for _ in range(20):
                costmap.observe(np.zeros((0, 3)), (0.0, -10.0, 0.3))
                costmap.plan((-5.0, -5.0), (-8.0, 5.0))
                odometry.imu([0], np.zeros((1, 3)), [[0.0, 0.0, 9.81]])
        except BaseException as error:
            errors.append(error)

    threads = [threading.Thread(target=work) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not errors
    # All but the first were not later than the last.
    assert odometry.refused["imu"] == 39

"""Tests of the comparison itself, on a small scene: .venv/bin/python -m unittest discover -s benchmarks/sim"""

import tempfile
import unittest
from pathlib import Path

import numpy as np

import agreement
import compare
import dump as dumps
import peer_embreex
import peer_mujoco
import peer_pybullet
import report
import split
import synthetic
import vehicle

MAX_RANGE = 50.0


def small_dump(folder):
    rng = np.random.default_rng(7)
    triangles = synthetic.boxes(60, rng, 40.0)
    places = np.array([[-60.0, 0.0, 0.3], [60.0, 3.0, 0.3], [0.0, -60.0, 0.3]])
    origins, directions = synthetic.scans(places, 700, rng)
    hits = synthetic.ranges(triangles, origins, directions, MAX_RANGE)
    synthetic.write(folder, triangles, origins, directions, hits, MAX_RANGE)
    return dumps.read(folder)


class Comparison(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.dump = small_dump(Path(cls.folder.name))

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def agree(self, engine):
        found, wrong = agreement.compare(self.dump.ranges, engine.ranges(engine.cast()), MAX_RANGE)
        return found, wrong

    def test_the_rays_hit_and_miss(self):
        self.assertGreater((self.dump.ranges > 0).mean(), 0.1)
        self.assertLess((self.dump.ranges > 0).mean(), 0.8)
        self.assertEqual([s.stop - s.start for s in self.dump.shared_origins()], [700, 700, 700])

    def test_every_engine_hits_what_testing_every_triangle_hits(self):
        for peer in (peer_embreex, peer_mujoco, peer_pybullet):
            for make in peer.variants(self.dump):
                engine = make()
                with self.subTest(engine.name, note=engine.note):
                    self.assertGreater(self.agree(engine)[0]["agree_share"], 0.998)

    def test_a_scene_cut_into_many_meshes_is_the_same_scene(self):
        for engine in (peer_mujoco.MuJoCo(self.dump, 50), peer_pybullet.PyBullet(self.dump, 50)):
            self.assertGreater(self.agree(engine)[0]["agree_share"], 0.998, engine.note)

    def test_ranges_that_are_wrong_are_found_and_not_taken_for_edges(self):
        engine = peer_embreex.Embreex(self.dump, robust=True)
        true = engine.ranges(engine.cast())
        hit = np.flatnonzero(true > 0)[::3]
        wrong = true.copy()
        wrong[hit] *= 0.9
        spoiled = dumps.Dump(**{**vars(self.dump), "ranges": wrong})
        found, rays = agreement.compare(wrong, true, MAX_RANGE)
        self.assertEqual(rays.tolist(), hit.tolist())
        self.assertLess(found["agree_share"], 0.999)
        self.assertGreater(len(agreement.unexplained(spoiled, rays, engine.distances)), 0.99 * len(hit))

    def test_a_hit_taken_for_a_miss_is_found(self):
        found, rays = agreement.compare(np.array([0.0, 5.0, 0.0]), np.array([5.0, 0.0, MAX_RANGE - 1e-4]), MAX_RANGE)
        self.assertEqual(rays.tolist(), [0, 1])
        self.assertAlmostEqual(found["hit_or_miss_agree_share"], 1 / 3)

    def test_parts_hold_every_triangle_once(self):
        parts = split.parts(self.dump.triangles, 50)
        self.assertLessEqual(max(map(len, parts)), 50)
        self.assertEqual(sorted(np.concatenate(parts).tolist()), list(range(len(self.dump.triangles))))

    def test_mujocos_robot_drives(self):
        robot = vehicle.real_time_factor(self.dump, 1000)
        self.assertAlmostEqual(robot["driven_m"], vehicle.SPEED * vehicle.SCANS * 0.1, delta=0.3)

    def test_too_few_of_embrees_ranges_are_a_problem_and_others_are_not(self):
        rows = [{"engine": "embreex", "note": "robust", "agree_share": 0.9989}, {"engine": "PyBullet", "note": "", "agree_share": 0.9}]
        self.assertEqual(len(list(compare.problems(rows))), 1)
        self.assertEqual(list(compare.problems([rows[0] | {"agree_share": 0.9991}])), [])

    def test_casting_alone_is_compared_where_it_was_measured_and_whole_scans_otherwise(self):
        self.assertEqual(report.our_rate({"lidar_mrays_per_core_second": 8.0, "cast_mrays_per_core_second": 12.0})[0], 12.0)
        self.assertEqual(report.our_rate({"lidar_mrays_per_core_second": 8.0}), (8.0, "whole LiDAR scans"))
        self.assertIsNone(report.our_rate({})[0])

    def test_a_file_that_is_too_short_is_named(self):
        folder = Path(self.folder.name) / "short"
        folder.mkdir()
        synthetic.write(folder, self.dump.triangles, self.dump.origins, self.dump.directions, self.dump.ranges[:-1], MAX_RANGE)
        with self.assertRaisesRegex(dumps.BadDump, "ranges.f32"):
            dumps.read(folder)


if __name__ == "__main__":
    unittest.main()

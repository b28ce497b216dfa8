#!/usr/bin/env python3
"""Solves pose graphs with our solver and GTSAM's: compare.py --openbench PATH FILE.g2o ...

GTSAM gets the same file, its first pose held by a tight prior, and both of its optimizers; the faster one counts. CPU seconds are of solving alone, the fastest of three goes on both sides. chi2 is
the sum of squared residuals in deviations, as each side says itself; ours once more by GTSAM's own graph, from the poses that we wrote.
"""

import argparse
import json
import subprocess
import tempfile
import time
from pathlib import Path

import gtsam

GOES = 3


def graph(path):
    """The factors, the first guess, and whether it is in space."""
    space = "VERTEX_SE3:QUAT" in path.read_text()
    factors, guess = gtsam.readG2o(str(path), space)
    return factors, guess, space


def held(factors, guess, space):
    """The same factors and a prior that keeps the first pose where it is."""
    factors, first = gtsam.NonlinearFactorGraph(factors), sorted(guess.keys())[0]
    noise = gtsam.noiseModel.Diagonal.Variances([1e-6] * (6 if space else 3))
    if space:
        factors.add(gtsam.PriorFactorPose3(first, guess.atPose3(first), noise))
    else:
        factors.add(gtsam.PriorFactorPose2(first, guess.atPose2(first), noise))
    return factors


def theirs(path):
    """chi2 and CPU seconds of GTSAM."""
    factors, guess, space = graph(path)
    with_prior = held(factors, guess, space)
    best = None
    for optimizer in (gtsam.GaussNewtonOptimizer, gtsam.LevenbergMarquardtOptimizer):
        for _ in range(GOES):
            began = time.process_time()
            result = optimizer(with_prior, guess).optimize()
            seconds = time.process_time() - began
            best = min(best or (float("inf"), 0), (seconds, 2 * factors.error(result)))
    return best[1], best[0]


def ours(openbench, path):
    """chi2 and CPU seconds of ours, and chi2 of our poses by GTSAM's reckoning."""
    best = None
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "solved.g2o"
        for _ in range(GOES):
            command = [openbench, "bench", "posegraph", path, "--json", "--out", out]
            said = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)
            best = min(best or said, said, key=lambda said: said["seconds"])
        factors, poses, _ = graph(out)
        return best["chi2"], best["seconds"], 2 * factors.error(poses)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("files", type=Path, nargs="+")
    parser.add_argument("--openbench", default="openbench")
    args = parser.parse_args()
    print("| graph | chi2 | the same by GTSAM's reckoning | GTSAM's | off by | CPU s | GTSAM | ratio |")
    print("|---|---:|---:|---:|---:|---:|---:|---:|")
    for path in args.files:
        chi2, seconds, again = ours(args.openbench, path)
        chi2_theirs, seconds_theirs = theirs(path)
        off = abs(chi2 - chi2_theirs) / chi2_theirs
        print(
            f"| {path.stem} | {chi2:.5f} | {again:.5f} | {chi2_theirs:.5f} | {100 * off:.4f} % "
            f"| {seconds:.3f} | {seconds_theirs:.3f} | {seconds / seconds_theirs:.2f} |",
            flush=True,
        )


main()

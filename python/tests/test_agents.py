"""Agents in Python are scored as agents in Rust are."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import openbench
from openbench import Address, Briefing, Deliver, Drive, GiveUp, Observation

AGENTS = Path(__file__).with_name("agents.py")
SUITE = """
name = "one-parcel"

[world.builtin]
name = "small"
seed = 1

[[episodes]]
instruction = "Box to unit 1, building 1"

[[episodes.deliveries]]
building = "building1"
unit = "unit1"
"""


@pytest.fixture
def suite(tmp_path: Path) -> str:
    """A suite of one delivery."""
    path = tmp_path / "suite.toml"
    path.write_text(SUITE)
    return str(path)


class Ahead:
    """Drives ahead for two seconds, then gives up."""

    def begin(self, briefing: Briefing) -> None:
        assert briefing.instruction and briefing.map.startswith(b"<?xml")
        assert briefing.robot["max_forward"] == 0.5

    def act(self, observation: Observation) -> Any:
        if observation.time >= 2.0:
            return GiveUp("enough", cause="door_not_found")
        return 0.3, 0.0


def command(*arguments: str, **options: Any) -> subprocess.CompletedProcess[str]:
    words = [sys.executable, "-m", "openbench", *arguments]
    return subprocess.run(words, capture_output=True, text=True, timeout=300, **options)


def test_an_agent_is_told_what_is_known_of_its_start(suite: str) -> None:
    told: list[Briefing] = []

    class Listens(Ahead):
        def begin(self, briefing: Briefing) -> None:
            told.append(briefing)

    for start in ("exact", "10m", "block", "map"):
        results = openbench.evaluate(Listens, suite, conditions={"start": start})
        assert results.get("conditions", {}).get("start", "exact") == start
    exact, vague, block, anywhere = told
    assert exact.start and exact.start_covariance == [[0.0] * 3] * 3
    assert vague.start and vague.start_covariance and vague.start_covariance[0][0] == 100.0
    assert block.start is None and block.start_area and block.start_area[2] == 75.0
    assert anywhere.start is None and anywhere.start_area is None


def test_results_come_as_a_dictionary() -> None:
    results = openbench.evaluate(Ahead, "small", jobs=2)
    assert results["agent"] == "python:Ahead"
    assert "Python program" in results["provenance"]["cannot_repeat"]
    assert len(results["deliveries"]) == 11
    causes = {delivery["failure"] for delivery in results["deliveries"]}
    assert causes == {"door_not_found"}
    assert 0.4 < results["deliveries"][0]["path_m"] < 0.6


def test_the_number_of_threads_changes_nothing() -> None:
    def scores(jobs: int) -> list[Any]:
        deliveries: list[Any] = openbench.evaluate(Ahead, "small", jobs=jobs)["deliveries"]
        return deliveries

    assert scores(1) == scores(2)


def test_an_agent_sees_scans_images_and_samples() -> None:
    seen: dict[str, Any] = {}

    class Looks(Ahead):
        def act(self, observation: Observation) -> Any:
            if observation.scan is not None and "scan" not in seen:
                seen["scan"] = observation.scan
                seen["image"] = observation.image
                seen["imu"], seen["wheels"] = observation.imu, observation.wheels
            observation.note("looked")
            observation.report_pose(0.0, 0.0, 0.0)
            return GiveUp("seen") if "scan" in seen else Drive(0.0, 0.0)

    openbench.evaluate(Looks, "small")
    scan = seen["scan"]
    assert scan.points.dtype == np.float32 and scan.points.shape[1] == 3
    assert len(scan.points) == len(scan.offsets) == len(scan.line) > 1_000
    assert seen["image"].shape == (480, 640, 3)
    assert seen["imu"].shape[1] == 7 and seen["wheels"].shape[1] == 3
    assert 9 < seen["imu"][:, 6].mean() < 10.5


def test_an_error_of_an_agent_is_raised_with_its_own_traceback() -> None:
    class Broken(Ahead):
        def act(self, observation: Observation) -> Any:
            return {"a": 1}["b"]

    with pytest.raises(KeyError, match="b"):
        openbench.evaluate(Broken, "small")


@pytest.mark.parametrize("answer", [(float("nan"), 0.0), (1.0,), "fast", None])
def test_an_answer_that_is_none_fails(answer: Any) -> None:
    class Odd(Ahead):
        def act(self, observation: Observation) -> Any:
            return answer

    try:
        results = openbench.evaluate(Odd, "small")
    except (TypeError, ValueError):
        return
    assert {delivery["failure"] for delivery in results["deliveries"]} == {"agent_error"}


def test_a_class_in_a_file_is_run_by_the_command_and_repeats(tmp_path: Path) -> None:
    run = command("run", "small", "--agent", f"python:{AGENTS}:Ahead", "--out", str(tmp_path))
    assert run.returncode == 0, run.stderr
    assert "what an agent prints" in run.stderr
    verified = command("verify", str(tmp_path), "--agent")
    assert verified.returncode == 0 and "the agent repeats them" in verified.stdout
    results = json.loads((tmp_path / "results.json").read_text())
    in_process = openbench.evaluate(Ahead, "small")
    assert results["deliveries"] == in_process["deliveries"]
    assert results["provenance"]["models"][0]["name"] == "agents.py"


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        (f"python:{AGENTS}:Nobody", "Nobody"),
        ("python:nowhere.py:Ahead", "no file nowhere.py"),
        (f"python:{AGENTS}", "FILE.py:CLASS"),
        ("program:/nowhere/policy", "/nowhere/policy"),
        ("program:", "program:COMMAND"),
    ],
)
def test_an_agent_that_cannot_begin_is_bad_input(name: str, problem: str) -> None:
    run = command("run", "small", "--agent", name)
    assert run.returncode == 2 and problem in run.stderr and run.stdout == ""


@pytest.mark.parametrize(
    ("name", "cause"),
    [("Raises", "ZeroDivisionError"), ("Exits", "exit status: 7"), ("Sleeps", "within 0.5 s")],
)
def test_an_agent_that_fails_fails_its_deliveries_and_the_run_goes_on(
    name: str, cause: str, suite: str, tmp_path: Path
) -> None:
    out = tmp_path / "run"
    agent = f"python:{AGENTS}:{name}"
    run = command("run", suite, "--agent", agent, "--set", "timeout=0.5", "--out", str(out))
    assert run.returncode == 0, run.stderr
    results = json.loads((out / "results.json").read_text())
    for delivery in results["deliveries"]:
        assert delivery["failure"] == "agent_error"
        assert cause in delivery["failure_detail"]


def test_an_interrupt_ends_an_evaluation() -> None:
    script = """
import openbench, signal, time
# A parent in the background may have left interrupts ignored.
signal.signal(signal.SIGINT, signal.default_int_handler)
class Slow:
    def begin(self, briefing): print("begun", flush=True)
    def act(self, observation): time.sleep(600)
openbench.evaluate(Slow, "small")
"""
    process = subprocess.Popen(
        [sys.executable, "-c", script], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "begun\n"
    os.kill(process.pid, signal.SIGINT)
    began = time.monotonic()
    _, said = process.communicate(timeout=60)
    assert "KeyboardInterrupt" in said
    # Far below the time for which it sleeps.
    assert time.monotonic() - began < 30


def test_addresses_and_declarations_reach_the_judge(suite: str) -> None:
    class Declares(Ahead):
        def act(self, observation: Observation) -> Any:
            return Deliver(Address("building1", "unit1"))

    results = openbench.evaluate(Declares, suite)
    assert [delivery["failure"] for delivery in results["deliveries"]] == ["wrong_place"]
    assert results["deliveries"][0]["declared_at"] is not None


def test_an_agent_in_rust_and_the_same_in_python_have_equal_results(
    suite: str, tmp_path: Path
) -> None:
    """Bit for bit: a class repeats what `omniscient` did."""
    out = tmp_path / "rust"
    assert command("run", suite, "--agent", "omniscient", "--out", str(out)).returncode == 0
    recording = json.loads((out / "episodes" / "000.actions.json").read_text())
    velocities = [
        Drive(span["velocity"]["linear"], span["velocity"]["angular"])
        for span in recording["driven"]
        for _ in range(span["steps"])
    ]
    delivered = {deed["step"] for deed in recording["deeds"] if "delivered" in deed["do"]}

    class Repeats(Ahead):
        def begin(self, briefing: Briefing) -> None:
            self.step = 0

        def act(self, observation: Observation) -> Any:
            step, self.step = self.step, self.step + 1
            if step in delivered:
                return Deliver(Address("building1", "unit1"))
            return velocities[step]

    mine = tmp_path / "mine"
    openbench.evaluate(Repeats, suite, out=mine)

    def known(run: Path) -> tuple[Any, Any]:
        actions = json.loads((run / "episodes" / "000.actions.json").read_text())
        return actions["chain"], json.loads((run / "results.json").read_text())["deliveries"]

    assert known(mine) == known(out)


def test_any_program_can_be_an_agent(suite: str, tmp_path: Path) -> None:
    agent = f"program:{sys.executable} -m openbench._child {AGENTS} Ahead"
    run = command("run", suite, "--agent", agent, "--out", str(tmp_path / "run"))
    assert run.returncode == 0, run.stderr
    results = json.loads((tmp_path / "run" / "results.json").read_text())
    assert results["deliveries"][0]["failure"] == "door_not_found"

"""Results as rows and frames."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

import openbench


def results(seed: int, **values: Any) -> dict[str, Any]:
    smoothness = {"stops": seed}
    delivery = {"building": "building1", "path_m": 3.5, "smoothness": smoothness, **values}
    return {"agent": "python:A", "suite": "small", "seed": seed, "deliveries": [delivery] * 2}


def test_rows_are_flat_and_alike() -> None:
    rows = openbench.deliveries(results(0), results(1, declared_at={"x": 1.0, "y": 2.0}))
    assert [row["seed"] for row in rows] == [0, 0, 1, 1]
    assert [row["declared_at_x"] for row in rows] == [None, None, 1.0, 1.0]
    assert {tuple(row) for row in rows} == {tuple(rows[0])}
    assert rows[3]["smoothness_stops"] == 1


def test_runs_are_read_from_folders(tmp_path: Path) -> None:
    for seed in (2, 10):
        folder = tmp_path / f"seed-{seed}"
        folder.mkdir()
        (folder / "results.json").write_text(json.dumps(results(seed)))
    assert [row["seed"] for row in openbench.deliveries(tmp_path)] == [2, 2, 10, 10]
    assert len(openbench.deliveries(tmp_path / "seed-2")) == 2
    assert len(openbench.deliveries(str(tmp_path / "seed-2" / "results.json"))) == 2
    with pytest.raises(FileNotFoundError, match="no results"):
        openbench.deliveries(tmp_path.parent)
    empty = tmp_path / "empty"
    empty.mkdir()
    with pytest.raises(FileNotFoundError, match="no results"):
        openbench.deliveries(empty)


def test_frames_have_a_row_for_each_delivery() -> None:
    runs = {0: results(0), 1: results(1, failure="stuck")}
    pandas_frame = openbench.to_pandas(runs)
    assert list(pandas_frame["seed"]) == [0, 0, 1, 1]
    polars_frame = openbench.to_polars(runs)
    assert polars_frame["failure"].to_list() == [None, None, "stuck", "stuck"]


class Nothing:
    def begin(self, briefing: openbench.Briefing) -> None: ...

    def act(self, observation: openbench.Observation) -> openbench.Action:
        return openbench.GiveUp("nothing")


def test_several_seeds_do_not_mix_with_other_runs(tmp_path: Path) -> None:
    (tmp_path / "seed-7").mkdir()
    with pytest.raises(openbench.InputError, match="seed-7"):
        openbench.evaluate(Nothing, "small", seeds=range(2), out=tmp_path)
    with pytest.raises(ValueError, match="seeds"):
        openbench.evaluate(Nothing, "small", seeds=[0, -1])
    runs = openbench.evaluate(Nothing, "small", seeds=[7], out=tmp_path)
    assert list(runs) == [7] and runs[7]["seed"] == 7
    assert {row["seed"] for row in openbench.deliveries(tmp_path)} == {7}

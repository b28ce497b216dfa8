"""Results of runs as rows, and as frames of pandas or polars."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Union

if TYPE_CHECKING:
    import pandas
    import polars

#: What `evaluate` returns, or the folder of a run or of several seeds, or a `results.json`.
Run = Union[Mapping[Any, Any], str, "os.PathLike[str]"]


def deliveries(*runs: Run) -> list[dict[str, Any]]:
    """A flat row for each delivery, with the agent, suite and seed of its run in front.

    What is nested in `results.json` has names with underscores: `smoothness_stops`. All rows have
    the same keys, `None` where a run has no such value.
    """
    rows = [row for run in runs for results in _each(run) for row in _rows(results)]
    keys = list(dict.fromkeys(key for row in rows for key in row))
    return [{key: row.get(key) for key in keys} for row in rows]


def to_pandas(*runs: Run) -> pandas.DataFrame:
    """The rows of `deliveries` as a frame of pandas."""
    import pandas

    return pandas.DataFrame(deliveries(*runs))


def to_polars(*runs: Run) -> polars.DataFrame:
    """The rows of `deliveries` as a frame of polars."""
    import polars

    # All rows, since a column may begin with values that are missing.
    return polars.DataFrame(deliveries(*runs), infer_schema_length=None)


def _each(run: Run) -> Iterator[Mapping[str, Any]]:
    if isinstance(run, Mapping):
        # One run, or the runs of several seeds.
        if "deliveries" in run:
            yield run
        else:
            yield from run.values()
        return
    path = Path(run)
    if path.is_dir():
        single = path / "results.json"
        several = sorted(path.glob("seed-*/results.json"), key=lambda file: _seed(file.parent))
        files = [single] if single.exists() else several
        if not files:
            raise FileNotFoundError(f"{path} has no results of a run")
    else:
        files = [path]
    for file in files:
        yield json.loads(file.read_text(encoding="utf-8"))


def _seed(folder: Path) -> int:
    number = folder.name.removeprefix("seed-")
    return int(number) if number.isdecimal() else -1


def _rows(results: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    run = {key: results[key] for key in ("agent", "suite", "seed")}
    for delivery in results["deliveries"]:
        yield {**run, **dict(_flat(delivery))}


def _flat(values: Mapping[str, Any], front: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in values.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{front}{key}_")
        else:
            yield front + key, value

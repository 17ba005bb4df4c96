"""Sweeps: metrics of a scene at many points."""

from __future__ import annotations

import csv
import json
import os
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from . import _native
from ._progress import Bar, watched

if TYPE_CHECKING:
    import pandas
    import polars
    import pyarrow
    from distributed import Client
    from numpy.typing import NDArray

#: The values of a key: numbers, or a range as the command line writes it.
Values: TypeAlias = "str | Sequence[float] | NDArray[Any]"
#: Largest number of threads of a sweep.
MAX_JOBS = 1024


class Sweep(Mapping[str, "NDArray[Any]"]):
    """Result of a sweep. As a mapping it contains the columns: `sweep["friction_ratio"]` has one value per point; keys of the scene are columns as well."""

    def __init__(self, folder: Path, scratch: tempfile.TemporaryDirectory[str] | None) -> None:
        #: Folder of the sweep, with `sweep.parquet`, `sweep.csv`, figures and `report.html`.
        self.folder = folder
        self._scratch = scratch
        #: Definition of this sweep: keys, metrics and their units, points, the scene with all its defaults.
        self.plan: dict[str, Any] = json.loads((folder / "plan.json").read_text())
        #: Unit of each column; `1` for a ratio or a count.
        self.units: dict[str, str] = {entry["key"]: entry["unit"] for entry in self.plan["keys"]} | {
            entry["metric"]: entry["unit"] for entry in self.plan["metrics"]
        }
        self._columns: dict[str, NDArray[Any]] = {}

    @property
    def keys_swept(self) -> list[str]:
        """Keys that differ from point to point; the last changes fastest."""
        return [entry["key"] for entry in self.plan["keys"]]

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values of each key, if the points are every combination: `sweep["friction_ratio"].reshape(sweep.shape)` is the map. Otherwise the number of
        points."""
        axes = self.plan["design"].get("axes")
        return tuple(axis["count"] for axis in axes) if axes else (self.plan["points"],)

    @cached_property
    def failures(self) -> list[tuple[int, str]]:
        """Points without a result, with the reason."""
        with open(self.folder / "failures.csv", newline="") as file:
            return [(int(row["point"]), row["failure"]) for row in csv.DictReader(file)]

    def to_arrow(self) -> pyarrow.Table:
        """Returns the rows as an Arrow table; needs `pip install sonoglide[arrow]`."""
        import pyarrow.parquet

        return pyarrow.parquet.read_table(self.folder / "sweep.parquet")

    def to_pandas(self) -> pandas.DataFrame:
        """Returns the rows as a pandas data frame, with the point's number as index."""
        return self.to_arrow().to_pandas().set_index("point")

    def to_polars(self) -> polars.DataFrame:
        """Returns the rows as a polars data frame."""
        import polars

        return polars.read_parquet(self.folder / "sweep.parquet")

    def __getitem__(self, column: str) -> NDArray[Any]:
        if column not in self.units:
            raise KeyError(f"this sweep has no column {column!r}; it has {', '.join(self.units)}")
        if column not in self._columns:
            self._columns[column] = np.frombuffer(_native.Sweep.column(os.fspath(self.folder), column))
        return self._columns[column]

    def __iter__(self) -> Iterator[str]:
        return iter(self.units)

    def __len__(self) -> int:
        return len(self.units)

    def __repr__(self) -> str:
        return f"<sonoglide.Sweep of {self.plan['scene']!r}: {self.plan['points']} points over {', '.join(self.keys_swept)}>"


def run(
    scene: _native.Scene,
    over: Mapping[str, Values],
    metrics: Sequence[str],
    sampled: tuple[int | None, Mapping[str, Sequence[float]] | None],
    output: str | None,
    jobs: int | None,
    client: Client | None,
    progress: Bar | None,
) -> Sweep:
    """Runs a sweep into its folder, locally or on a cluster, and reads it."""
    draws, points = sampled
    if not 0 <= (jobs or 0) <= MAX_JOBS:
        raise ValueError(f"jobs: {jobs} is not from 0 (one thread per processor) to {MAX_JOBS}")
    if (points is None) == (not over):
        raise ValueError("give either keys to sweep over or points")
    axes = [f"{key}={_written(values)}" for key, values in over.items()]
    sweep = _native.Sweep(scene, axes, draws, None if points is None else _table(points), list(metrics))
    scratch = None if output else tempfile.TemporaryDirectory(prefix="sonoglide-sweep-")
    folder = output or (scratch.name if scratch else "")
    if client is None:
        with watched(progress, sweep.count, lambda: sweep.done):
            sweep.run(folder, jobs or 0)
    else:
        from ._dask import run_on

        run_on(client, (scene.state(), axes, draws, None if points is None else _table(points), list(metrics)), sweep, folder)
    sweep.join(folder)
    return Sweep(Path(folder), scratch)


def _written(values: Values) -> str:
    """Formats values as on the command line; numbers are exact."""
    return values if isinstance(values, str) else ",".join(repr(float(value)) for value in values)


def _table(points: Mapping[str, Sequence[float]]) -> str:
    """Formats points as CSV: a line of keys, then a line per point."""
    columns = [[repr(float(value)) for value in values] for values in points.values()]
    if len({len(column) for column in columns}) > 1:
        raise ValueError("the keys of the points have different numbers of values")
    return "\n".join([",".join(points), *(",".join(row) for row in zip(*columns))]) + "\n"

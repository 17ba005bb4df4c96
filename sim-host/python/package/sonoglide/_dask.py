"""Sweeps on a Dask cluster: a task runs some points and returns the bytes of their part. Dask schedules, retries, and survives lost workers."""

from __future__ import annotations

import os
import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING

from . import _native

if TYPE_CHECKING:
    from distributed import Client

#: Definition of a sweep: state of the scene, axes, draws, points, metrics.
Plan = tuple[tuple[str, str, str, list[str]], list[str], "int | None", "str | None", list[str]]

#: Target duration of a task, s: long compared with the scheduler's overhead, short compared with the loss if a worker is lost.
TASK_S = 5.0
#: Number of points of the first task, which measures the duration of a point.
FIRST = 16
#: Largest number of points of a task.
MOST = 65_536
#: Number of retries of a task whose worker was lost.
RETRIES = 5


def run_on(client: Client, plan: Plan, sweep: _native.Sweep, folder: str) -> None:
    """Runs the missing points of a sweep's folder on a cluster; each part is written as soon as it arrives."""
    from distributed import as_completed

    missing = sweep.missing(folder)
    if not missing:
        return
    begin, end = missing[0]
    first = min(end, begin + FIRST)
    name, data, seconds = client.submit(_part, plan, begin, first, pure=False, retries=RETRIES).result()
    _write(Path(folder) / name, data)
    workers = max(1, sum(client.nthreads().values()))
    left = sum(end - begin for begin, end in missing) - (first - begin)
    size = max(1, min(MOST, int(TASK_S * (first - begin) / max(seconds, 1e-9)), -(-left // workers) if left else 1))
    futures = [
        client.submit(_part, plan, at, min(end, at + size), pure=False, retries=RETRIES)
        for begin, end in [(first, end), *missing[1:]]
        for at in range(begin, end, size)
    ]
    try:
        for future in as_completed(futures):
            name, data, _ = future.result()
            _write(Path(folder) / name, data)
            future.release()
    except BaseException:
        client.cancel(futures)
        raise


def _part(plan: Plan, begin: int, end: int) -> tuple[str, bytes, float]:
    """Runs some points, on a worker. Returns name and bytes of their part, and the duration, s."""
    began = time.monotonic()
    state, axes, draws, points, metrics = plan
    sweep = _native.Sweep(_native.Scene.from_state(state), axes, draws, points, metrics)
    with tempfile.TemporaryDirectory(prefix="sonoglide-part-") as scratch:
        name, data = sweep.part(begin, end, scratch)
    return name, data, time.monotonic() - began


def _write(path: Path, data: bytes) -> None:
    """Writes a file atomically, also if the power fails."""
    unfinished = path.with_name(f"{path.name}.{os.getpid()}.tmp")
    with unfinished.open("wb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())
    unfinished.replace(path)

"""Comparisons, spectra and suites."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from . import _native

if TYPE_CHECKING:
    from numpy.typing import NDArray


class Compared(NamedTuple):
    """Comparison of two results."""

    holds: bool
    """`True` if every value is within its tolerance."""
    details: dict[str, Any]
    """Values, differences and tolerances, as `sim-host compare --format json` prints them."""


class Spectrogram(NamedTuple):
    """Frequencies of a signal over time."""

    power: NDArray[np.float64]
    """Power density: one row for each time, one column for each frequency."""
    time_s: NDArray[np.float64]
    frequency_hz: NDArray[np.float64]
    details: dict[str, Any]
    """Resolution, window and peak, as `sim-host spectrum --format json` prints them."""


class Suite(NamedTuple):
    """Result of a suite."""

    passed: bool
    missed: list[str]
    """Targets that were missed."""
    details: Any
    """Tables and values, as `sim-host validate --format json` prints them."""


def compare(
    a: str | os.PathLike[str],
    b: str | os.PathLike[str],
    tolerances: Mapping[str, float] | float | None = None,
    *,
    metrics: Sequence[str] = (),
) -> Compared:
    """Compares two folders of results, or a folder with a CSV of measured metrics, as `sim-host compare`.

    `tolerances` is a relative one for all metrics, or absolute ones by metric.
    """
    if tolerances is None:
        texts = []
    elif isinstance(tolerances, Mapping):
        texts = [f"{metric}={float(value)!r}" for metric, value in tolerances.items()]
    else:
        texts = [repr(float(tolerances))]
    details, holds = _native.compare(os.fspath(a), os.fspath(b), texts, list(metrics))
    return Compared(holds, json.loads(details))


def spectrum(
    path: str | os.PathLike[str],
    column: str | None = None,
    *,
    method: str = "stft",
    time: str | None = None,
    sample_hz: float | None = None,
    from_s: float | None = None,
    to_s: float | None = None,
    band_hz: tuple[float, float] | None = None,
    window_s: float | None = None,
    cycles: float | None = None,
    smooth_s: float | None = None,
) -> Spectrogram:
    """Computes the frequencies of a column of a file over time, as `sim-host spectrum`: `stft`, `wavelet` or `wigner-ville`.

    Raises `MeasurementError` for a file that cannot be used.
    """
    text, (power, times, frequencies) = _native.spectrum(
        os.fspath(path), method, (column, time, sample_hz), (from_s, to_s), band_hz, window_s, cycles, smooth_s
    )
    time_s, frequency_hz = np.frombuffer(times), np.frombuffer(frequencies)
    return Spectrogram(np.frombuffer(power).reshape(len(time_s), len(frequency_hz)), time_s, frequency_hz, json.loads(text))


def validate(path: str | os.PathLike[str], *, quick: bool = False) -> Suite:
    """Runs a suite of cases with targets, as `sim-host validate`."""
    details, missed = _native.validate(os.fspath(path), quick)
    return Suite(not missed, missed, json.loads(details))

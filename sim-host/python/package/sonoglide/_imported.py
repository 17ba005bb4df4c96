"""Measured data, as parameters with standard deviations and as scenes."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from . import _native
from ._scene import Scene

if TYPE_CHECKING:
    from numpy.typing import NDArray

#: Connection of a transducer to a network analyser.
Topology = Literal["one-port", "series-through", "shunt-through"]


@dataclass(frozen=True)
class Stated:
    """A number and its standard deviation, both in the unit of its name."""

    value: float
    #: Standard deviation; `None` if the data do not determine the number.
    sd: float | None

    def __float__(self) -> float:
        return self.value


@dataclass(frozen=True)
class Correlation:
    """Correlations of fitted numbers."""

    names: list[str]
    #: A row and a column for each name, from -1 to 1; empty if a model has no correlations.
    matrix: NDArray[np.float64] = field(repr=False)


@dataclass(frozen=True)
class Admittance:
    """A measured admittance and its equivalent circuit."""

    #: `series_resonance_hz`, `parallel_resonance_hz`, `q`, `rm_ohm`, `lm_h`, `cm_f`, `c0_f`, `coupling`, `loss_tangent` of the working mode.
    circuit: dict[str, Stated]
    #: Correlations of the numbers of `circuit`.
    correlation: Correlation
    #: All resonances, by frequency: the same numbers as far as a branch has them, and `working` for the working one.
    modes: list[dict[str, Any]]
    #: Frequencies of the sweep, Hz.
    frequency_hz: NDArray[np.float64] = field(repr=False)
    #: Measured admittance without the fixture, S.
    measured_s: NDArray[np.complex128] = field(repr=False)
    #: Admittance of the circuit, S.
    fitted_s: NDArray[np.complex128] = field(repr=False)
    #: Residuals in the coordinate of the instrument, in standard deviations of the noise; whitened if the noise is correlated.
    residual: NDArray[np.complex128] = field(repr=False)
    #: Remarks on the file, a sentence each.
    remarks: list[str] = field(repr=False)
    #: Warnings, a sentence each.
    warnings: list[str]
    #: The scene of the transducer as TOML.
    scene_toml: str | None = field(repr=False)

    def scene(self) -> Scene:
        """Returns the scene of this transducer. Raises `SceneError` if its values are outside the limits of a scene."""
        return _scene(self.scene_toml)


@dataclass(frozen=True)
class Contact:
    """A contact model fitted to a log."""

    #: `coulomb`, `stribeck`, `dahl`, `lugre` or `maxwell`.
    model: str
    #: Parameters by the names of a scene's keys, with their units.
    parameters: dict[str, Stated]
    #: Correlations of the fitted numbers.
    correlation: Correlation
    #: Root mean square of the residuals, N.
    rms_n: float
    #: Bayesian information criterion; the lowest is the best.
    criterion: float


@dataclass(frozen=True)
class Friction:
    """A friction log and its contact."""

    #: Selected model.
    contact: Contact
    #: All models, the best first.
    models: list[Contact]
    #: One fit of all conditions with and without vibration, as `sim-host import friction --format json` prints it; `None` if the log has no part with
    #: vibration. `on_fit["conditions"]` are the measured and the fitted friction ratios.
    on_fit: dict[str, Any] | None
    #: Mean normal force, N.
    normal_n: float
    #: Time of each sample, s; empty if the log has none.
    time_s: NDArray[np.float64] = field(repr=False)
    #: Slip velocity of each sample, m/s.
    velocity_m_per_s: NDArray[np.float64] = field(repr=False)
    #: Measured friction, N.
    measured_n: NDArray[np.float64] = field(repr=False)
    #: Friction of the selected model, N.
    fitted_n: NDArray[np.float64] = field(repr=False)
    #: True while the vibration is ON; the models are fitted to the other samples.
    on: NDArray[np.bool_] = field(repr=False)
    #: Remarks on the file, a sentence each.
    remarks: list[str] = field(repr=False)
    #: Warnings, a sentence each.
    warnings: list[str]
    #: The contact study as TOML; `None` without a frequency or a tip velocity, or for a model that a scene does not support.
    scene_toml: str | None = field(repr=False)

    @property
    def residual_n(self) -> NDArray[np.float64]:
        """Model minus measurement at every sample, N."""
        return self.fitted_n - self.measured_n

    def scene(self) -> Scene:
        """Returns the contact study of this contact. Raises `ValueError` for a model that a scene does not support."""
        return _scene(self.scene_toml)


@dataclass(frozen=True)
class Conditions:
    """One fit of friction with and without vibration at several conditions."""

    #: Shared parameters of the fit: `value`, and the ends `low` and `high` of its 95 % interval.
    fit: dict[str, dict[str, float]]
    #: Measured and fitted friction ratio of each condition, with its residual, as `sim-host import friction --format json` prints them.
    conditions: list[dict[str, Any]]
    #: Predictions in the order of `predict`, with their 95 % bands.
    predictions: list[dict[str, Any]]
    #: Values that were assumed, a sentence each.
    assumed: list[str]
    #: Warnings, a sentence each.
    warnings: list[str]
    #: The contact study as TOML; `None` if something that it needs is unknown, or if the fit does not describe the measurements.
    scene_toml: str | None = field(repr=False)

    def scene(self) -> Scene:
        """Returns the contact study. Raises `ValueError` if there is none."""
        return _scene(self.scene_toml)


def import_admittance(
    path: str | os.PathLike[str],
    *,
    columns: str | None = None,
    units: Sequence[str] = (),
    z0_ohm: float = 50.0,
    topology: Topology | None = None,
    open: str | os.PathLike[str] | None = None,
    short: str | os.PathLike[str] | None = None,
    series_ohm: float = 0.0,
    modes: int | None = None,
    mode: float | None = None,
    force: bool = False,
) -> Admittance:
    """Fits the equivalent circuit of a measured admittance or impedance, as `sim-host import admittance` does (docs/measured-data.md).

    `columns` names the columns of a table, such as `"f [Hz], |Z| [ohm], theta [deg]"`. `units` are the units of columns without one. `z0_ohm` is the reference
    of scattering parameters in a table, ohm. `open` and `short` are sweeps of the fixture, `series_ohm` is a resistance in series. `modes` is the number of
    resonances to fit, and `mode` the working mode, by its number or by a frequency near it, Hz. `force` gives a scene even if the circuit does not describe the
    data.

    Raises `MeasurementError` with the reason, and the line or the column, if the file cannot be used.
    """
    text, scene, arrays = _native.import_admittance(
        os.fspath(path), columns, list(units), z0_ohm, topology, _optional(open), _optional(short), series_ohm, modes, mode, force
    )
    found, part = json.loads(text), {name: _numbers(values) for name, values in arrays}
    return Admittance(
        circuit={name: Stated(**found["circuit"][name]) for name in found["correlation"]["names"]},
        correlation=_correlation(found["correlation"]),
        modes=[
            {name: Stated(**number) if isinstance(number, dict) else number for name, number in mode.items()} for mode in found["modes"]
        ],
        frequency_hz=part["frequency_hz"],
        measured_s=part["measured_re_s"] + 1j * part["measured_im_s"],
        fitted_s=part["fitted_re_s"] + 1j * part["fitted_im_s"],
        residual=part["residual_re"] + 1j * part["residual_im"],
        remarks=found["remarks"],
        warnings=found["warnings"],
        scene_toml=scene,
    )


def import_friction(
    path: str | os.PathLike[str],
    *,
    columns: str | None = None,
    normal_n: float | None = None,
    on_s: Sequence[tuple[float, float]] = (),
    frequency_hz: float | None = None,
    tip_m_per_s: float | None = None,
) -> Friction:
    """Fits the contact of a friction log, as `sim-host import friction` does (docs/measured-data.md).

    `normal_n` is the normal force, N, if no column contains it. `on_s` are pairs of times, s, between which the vibration is ON, if no column contains it.
    `frequency_hz` is the frequency of the vibration and `tip_m_per_s` its peak velocity, if they were measured; a scene needs both, but a tip velocity is
    fitted to the parts with vibration.

    Raises `MeasurementError` with the reason, and the line or the column, if the file cannot be used.
    """
    text, scene, arrays = _native.import_friction(
        os.fspath(path), columns, normal_n, [(float(a), float(b)) for a, b in on_s], frequency_hz, tip_m_per_s
    )
    found, part = json.loads(text), {name: _numbers(values) for name, values in arrays}
    return Friction(
        contact=_contact(found["contact"]),
        models=[_contact(model) for model in found["models"]],
        on_fit=found.get("on"),
        normal_n=found["normal_n"],
        time_s=part["time_s"],
        velocity_m_per_s=part["velocity_m_per_s"],
        measured_n=part["measured_n"],
        fitted_n=part["fitted_n"],
        on=part["on"] > 0.5,
        remarks=found["remarks"],
        warnings=found["warnings"],
        scene_toml=scene,
    )


def import_conditions(
    paths: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    *,
    columns: str | None = None,
    units: Sequence[str] = (),
    normal_n: float | None = None,
    on_s: Sequence[tuple[float, float]] = (),
    frequency_hz: float | None = None,
    tip_m_per_s: float | None = None,
    predict: Sequence[str] = (),
) -> Conditions:
    """Fits friction with and without vibration at the conditions of one or several files, as `sim-host import friction` does (docs/measured-friction.md).

    Conditions are columns or parts of the file names. `predict` are conditions such as `"speed=0.15,normal=10"`; `units` are those that no heading and no
    file name gives. The other arguments are those of `import_friction()`.

    Raises `MeasurementError` with the reason, and the line or the column, if a file cannot be used.
    """
    files = [paths] if isinstance(paths, (str, os.PathLike)) else list(paths)
    intervals = [(float(a), float(b)) for a, b in on_s]
    text, scene, _ = _native.import_conditions(
        [os.fspath(path) for path in files], columns, list(units), normal_n, intervals, frequency_hz, tip_m_per_s, list(predict)
    )
    found = json.loads(text)
    return Conditions(
        fit=found["fit"],
        conditions=found["conditions"],
        predictions=found["predictions"],
        assumed=found["assumed"],
        warnings=found["warnings"],
        scene_toml=scene,
    )


def _optional(path: str | os.PathLike[str] | None) -> str | None:
    return None if path is None else os.fspath(path)


def _numbers(values: bytes) -> NDArray[np.float64]:
    return np.frombuffer(values, dtype=np.float64)


def _correlation(found: dict[str, Any]) -> Correlation:
    return Correlation(found["names"], np.array(found["matrix"], dtype=np.float64))


def _contact(found: dict[str, Any]) -> Contact:
    numbers = {name: Stated(**number) for name, number in found.items() if isinstance(number, dict) and "value" in number}
    return Contact(found["model"], numbers, _correlation(found["correlation"]), found["rms_n"], found["criterion"])


def _scene(text: str | None) -> Scene:
    if text is None:
        raise ValueError("a scene does not support this friction model")
    return Scene.from_toml(text, name="imported")

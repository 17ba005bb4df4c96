"""Scenes."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from . import _native
from ._changes import Value, changes
from ._progress import Bar, advancing
from ._result import Result
from ._sweep import Sweep, Values, run

if TYPE_CHECKING:
    from distributed import Client


class Metric(NamedTuple):
    """A metric of a run."""

    name: str
    unit: str
    meaning: str


class Law(NamedTuple):
    """A friction law of your own.

    `rates(slip_m_per_s, states, sign, coulomb_n)` returns the rates of the states, per second, and the friction, N. `sign` is that of the slip velocity; it is
    constant between two reversals, which the solver locates: use it in place of a sign computed from the velocity, and `sign * slip_m_per_s` as its absolute
    value. Otherwise the function must be smooth. `start` has the values of the states at the start.
    """

    rates: Callable[[float, Sequence[float], float, float], tuple[Sequence[float], float]]
    start: Sequence[float] = ()


def metrics() -> list[Metric]:
    """Returns all metrics that a run can have: name, unit (`1` for a ratio or a count), meaning."""
    return [Metric(*metric) for metric in _native.metrics()]


class Scene:
    """A scene to run: a drive with its plant, or a contact alone. It is immutable; `with_values` returns another scene.

    Keys end with their unit (`excitation.force_n`, `stack.bvd.series_resonance_hz`); `explain(key)` returns the meaning of one.
    """

    __slots__ = ("_native",)

    def __init__(self, native: _native.Scene) -> None:
        self._native = native

    @classmethod
    def load(cls, source: str | os.PathLike[str], values: Mapping[str, Value] | None = None) -> Scene:
        """Loads a built-in scene by its name, or a TOML file by its path, with some values changed.

        Raises `SceneError` with every error, each with its line and the nearest name.
        """
        return cls(_native.Scene.load(os.fspath(source), changes(values)))

    @classmethod
    def from_toml(cls, text: str, values: Mapping[str, Value] | None = None, *, name: str = "scene") -> Scene:
        """Creates a scene from TOML text. A relative `base` is looked up in the folder of `name`."""
        return cls(_native.Scene.from_toml(text, name, changes(values)))

    @classmethod
    def from_dict(cls, tree: Mapping[str, Any], *, name: str = "scene") -> Scene:
        """Creates a scene from nested dictionaries, as returned by `to_dict`; entries that are `None` are omitted."""
        return cls(_native.Scene.from_json(json.dumps(_without_none(tree)), name, []))

    def with_values(self, values: Mapping[str, Value]) -> Scene:
        """Returns the same scene with some values changed, such as `{"contact.dahl.mu": 0.2}`."""
        return Scene(self._native.changed(changes(values)))

    @property
    def name(self) -> str:
        """Name of the scene."""
        return self._native.name

    @property
    def title(self) -> str:
        """Title of the scene."""
        return self._native.title

    def to_toml(self) -> str:
        """Returns the scene with all its defaults as TOML, every key with its unit and meaning."""
        return self._native.to_toml()

    def to_dict(self) -> dict[str, Any]:
        """Returns the scene with all its defaults as nested dictionaries."""
        tree: dict[str, Any] = json.loads(self._native.to_json())
        return tree

    def run(self, output: str | os.PathLike[str] | None = None, *, law: Law | None = None, progress: Bar | None = None) -> Result:
        """Runs the scene, with its grid and its comparison.

        With `output` it also writes the folder of files that `sim-host run -o` writes: manifest, summary, traces, figures, report. Other Python threads
        continue meanwhile, and Ctrl-C ends the run. Raises `RunError` if there is no result.

        `law` is a friction law of your own in place of that of a contact study; `mu` and normal force remain those of the scene.
        `progress` is a bar, such as `tqdm.tqdm()`: its `total` is the simulated time in seconds, or the number of runs.
        """
        own = None if law is None else (law.rates, [float(value) for value in law.start])
        moves = None
        if progress is not None:
            tree = self.to_dict()
            moves = advancing(progress, tree["runs"] if tree.get("runs", 1) > 1 else tree.get("duration_s", 1))
        result = Result(self._native.run(None if output is None else os.fspath(output), own, moves))
        if moves is not None and progress is not None:
            moves(progress.total)
        return result

    def advise(self, *, volts: float | None = None, noise_lsb: float | None = None, block_samples: int | None = None) -> dict[str, Any]:
        """Recommends settings for the transducer of the scene, as `sim-host advise`: `["settings"]["snippet"]` is TOML for a scene."""
        advice: dict[str, Any] = json.loads(_native.advise(self._native, volts, noise_lsb, block_samples))
        return advice

    def advise_amplifier(
        self, *, volts: float | None = None, tip_m_per_s: float | None = None, tip_m: float | None = None
    ) -> dict[str, Any]:
        """Computes volts, amperes and power for a peak tip velocity, m/s, or displacement, m, as `sim-host advise --amplifier`."""
        if tip_m_per_s is not None and tip_m is not None:
            raise ValueError("give a tip velocity or a tip displacement, not both")
        for tip in (tip_m_per_s, tip_m):
            if tip is not None and not 1e-12 <= tip <= 1e3:
                raise ValueError("a tip velocity or displacement is from 1e-12 to 1e3")
        advice: dict[str, Any] = json.loads(_native.advise_amplifier(self._native, volts, tip_m_per_s, tip_m))
        return advice

    def sweep(
        self,
        over: Mapping[str, Values] | None = None,
        *,
        metrics: Sequence[str] = (),
        draws: int | None = None,
        points: Mapping[str, Sequence[float]] | None = None,
        output: str | os.PathLike[str] | None = None,
        jobs: int | None = None,
        client: Client | None = None,
        progress: Bar | None = None,
    ) -> Sweep:
        """Runs the scene at many points, in parallel.

        `over` has the values of each key: `[0.1, 0.2]`, an array, or the text of the command line's `--over`, `"0.05:0.95:181"` or `"1e4:1e7:61:log"`. Every
        combination is a point. With `draws` the entries are ranges, `"0.1:0.3"` or `"1e4:1e7:log"`, and that many pairs of draws are made for Sobol indices.
        `points` instead has the values of each key at each point. `metrics` are the metrics to read (by default all; fewer are faster).

        `output` is the folder of the sweep, as made by `sim-host sweep -o`: an interrupted sweep continues there. Without it the folder is deleted with the
        result. `jobs` is the number of threads. With a Dask `client` the points run on its cluster, and the result is the same, byte for byte.

        `progress` is a bar, such as `tqdm.tqdm()`, of points; it does not move with a `client`.

        A point without a result has NaN for its metrics, and its reason is in `failures`. Raises `SceneError` for an unknown key or metric.
        """
        return run(self._native, over or {}, metrics, (draws, points), None if output is None else os.fspath(output), jobs, client, progress)

    def solve(self, target: Mapping[str, float], by: Mapping[str, str], *, metrics: Sequence[str] = ()) -> dict[str, Any]:
        """Finds the values of a key at which a metric has a value, as `sim-host solve`.

        `scene.solve({"reduction_percent": 70}, by={"rig.kinematic.vibration_amplitude_m": "1e-8:1e-5:log"})`. The roots are in `["roots"]`, each with its
        `value` and `metrics`. `metrics` are further ones to report.
        """
        (metric, value), (key, ends) = _single("target", target), _single("by", by)
        if not math.isfinite(value):
            raise ValueError("the target is not a finite number")
        _check_range(key, ends)
        found: dict[str, Any] = json.loads(_native.solve(self._native, metric, float(value), f"{key}={ends}", list(metrics)))
        return found

    def optimise(
        self,
        *,
        minimise: str | None = None,
        maximise: str | None = None,
        over: Mapping[str, str],
        subject_to: Sequence[str] = (),
        runs: int | None = None,
        metrics: Sequence[str] = (),
    ) -> dict[str, Any]:
        """Finds the values of several keys at which a metric is best within limits of others, as `sim-host optimise`.

        `scene.optimise(minimise="drive_power_w", over={"design.element.3.length_m": "0.03:0.06"}, subject_to=["series_resonance_hz>=28e3"])`. The best run is
        in `["best"]`, with its `keys` and `metrics`; `["within_limits"]` tells if it meets every limit.
        """
        if (minimise is None) == (maximise is None):
            raise ValueError("give either `minimise` or `maximise`")
        objective = minimise if minimise is not None else maximise
        assert objective is not None
        if not over or isinstance(subject_to, str) or isinstance(metrics, str):
            raise ValueError("`over` has ranges by keys, `subject_to` and `metrics` are lists of texts")
        if runs is not None and not 16 <= runs <= 1_000_000:
            raise ValueError("`runs` is from 16 to 1000000")
        for key, ends in over.items():
            _check_range(key, ends)
        ranges = [f"{key}={ends}" for key, ends in over.items()]
        text = _native.optimise(self._native, objective, minimise is not None, list(subject_to), ranges, runs, list(metrics))
        found: dict[str, Any] = json.loads(text)
        return found

    def __reduce__(self) -> tuple[Any, ...]:
        return _from_state, (self._native.state(),)

    def __repr__(self) -> str:
        return f"<sonoglide.Scene {self.name!r}: {self.title}>"


def _check_range(key: str, ends: str) -> None:
    if not isinstance(ends, str) or ends.removesuffix(":log").count(":") != 1:
        raise ValueError(f'the range of {key} is a text: "least:most" or "least:most:log"')


def _single(name: str, of: Mapping[str, Any]) -> tuple[str, Any]:
    if len(of) != 1:
        raise ValueError(f"`{name}` has {len(of)} entries; give one")
    return next(iter(of.items()))


def _from_state(state: tuple[str, str, str, list[str]]) -> Scene:
    return Scene(_native.Scene.from_state(state))


def _without_none(tree: Any) -> Any:
    if isinstance(tree, Mapping):
        return {key: _without_none(value) for key, value in tree.items() if value is not None}
    if hasattr(tree, "tolist"):
        return tree.tolist()
    if isinstance(tree, (list, tuple)):
        return [_without_none(value) for value in tree]
    return tree

"""Scenes."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from typing import Any, NamedTuple

from . import _native
from ._changes import Value, changes
from ._result import Result


class Metric(NamedTuple):
    """A metric of a run."""

    name: str
    unit: str
    meaning: str


def metrics() -> list[Metric]:
    """All metrics that a run can have: name, unit (`1` of a ratio or a count), meaning."""
    return [Metric(*metric) for metric in _native.metrics()]


class Scene:
    """What is to be run: a drive with its plant, or a contact by itself. It does not change; `with_values` makes another.

    Keys have their unit at their end (`excitation.force_n`, `stack.bvd.series_resonance_hz`); `explain(key)` says what one means.
    """

    __slots__ = ("_native",)

    def __init__(self, native: _native.Scene) -> None:
        self._native = native

    @classmethod
    def load(cls, source: str | os.PathLike[str], values: Mapping[str, Value] | None = None) -> Scene:
        """A built-in scene by its name, or a TOML file by its path, with some values changed.

        Raises `SceneError` with every mistake, each with its line and the nearest name.
        """
        return cls(_native.Scene.load(os.fspath(source), changes(values)))

    @classmethod
    def from_toml(cls, text: str, values: Mapping[str, Value] | None = None, *, name: str = "scene") -> Scene:
        """A scene from its text as TOML. A relative `base` is looked for beside `name`."""
        return cls(_native.Scene.from_toml(text, name, changes(values)))

    @classmethod
    def from_dict(cls, tree: Mapping[str, Any], *, name: str = "scene") -> Scene:
        """A scene from nested dictionaries, as `to_dict` gives them; entries that are `None` are left out."""
        return cls(_native.Scene.from_json(json.dumps(_without_none(tree)), name, []))

    def with_values(self, values: Mapping[str, Value]) -> Scene:
        """The same scene with some values changed, such as `{"contact.dahl.mu": 0.2}`."""
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
        """The scene with all its defaults as TOML, every key with its unit and meaning."""
        return self._native.to_toml()

    def to_dict(self) -> dict[str, Any]:
        """The scene with all its defaults as nested dictionaries."""
        tree: dict[str, Any] = json.loads(self._native.to_json())
        return tree

    def run(self, output: str | os.PathLike[str] | None = None) -> Result:
        """Runs the scene, with its grid and its comparison.

        With `output` it also writes the folder of files that `sim-host run -o` writes: manifest, summary, traces, figures, report. Other Python threads
        go on meanwhile, and Ctrl-C ends the run. Raises `RunError` if there is no result.
        """
        return Result(self._native.run(None if output is None else os.fspath(output)))

    def __repr__(self) -> str:
        return f"<sonoglide.Scene {self.name!r}: {self.title}>"


def _without_none(tree: Any) -> Any:
    if isinstance(tree, Mapping):
        return {key: _without_none(value) for key, value in tree.items() if value is not None}
    if hasattr(tree, "tolist"):
        return tree.tolist()
    if isinstance(tree, (list, tuple)):
        return [_without_none(value) for value in tree]
    return tree

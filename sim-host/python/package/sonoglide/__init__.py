"""Ultrasonic friction control: simulate a drive and its contact, and talk to a driver board.

    >>> import sonoglide
    >>> result = sonoglide.Scene.load("contact", {"excitation.velocity_ratio": 0.3}).run()
    >>> result["friction_ratio"]                                  # doctest: +SKIP

A scene is one TOML file, a dictionary, or one of the built-in ones (`scenes()`). `Scene.run()` is what the command `sim-host run` does, by the
same compiled code, and `Scene.sweep()` what `sim-host sweep` does: the same metrics, signals, figures and files. `explain()` says what a metric, a key or a fault means, with its unit.
"""

from ._link import Answer, Link
from ._native import VERSION as __version__
from ._native import LinkError, RunError, SceneError, explain, scenes
from ._result import Expectation, Figure, Result, Signal, Table
from ._scene import Scene, metrics
from ._sweep import Sweep

__all__ = [
    "Answer",
    "Expectation",
    "Figure",
    "Link",
    "LinkError",
    "Result",
    "RunError",
    "Scene",
    "SceneError",
    "Signal",
    "Sweep",
    "Table",
    "__version__",
    "explain",
    "metrics",
    "scenes",
]

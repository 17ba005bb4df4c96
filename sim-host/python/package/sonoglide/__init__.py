"""Ultrasonic friction control: simulate a drive and its contact, and talk to a driver board.

    >>> import sonoglide
    >>> result = sonoglide.Scene.load("contact", {"excitation.velocity_ratio": 0.3}).run()
    >>> result["friction_ratio"]                                  # doctest: +SKIP

A scene is one TOML file, a dictionary, or one of the built-in ones (`scenes()`). `Scene.run()` is what the command `sim-host run` does, by the
same compiled code, and `Scene.sweep()` what `sim-host sweep` does: the same metrics, signals, figures and files. `import_admittance()` and `import_friction()` make
parameters and scenes of measured data. `explain()` says what a metric, a key or a fault means, with its unit.
"""

from ._imported import Admittance, Contact, Correlation, Friction, Stated, import_admittance, import_friction
from ._link import Answer, Link
from ._native import VERSION as __version__
from ._native import LinkError, MeasurementError, RunError, SceneError, explain, scenes
from ._result import Expectation, Figure, Result, Signal, Table
from ._scene import Scene, metrics
from ._sweep import Sweep

__all__ = [
    "Admittance",
    "Answer",
    "Contact",
    "Correlation",
    "Expectation",
    "Figure",
    "Friction",
    "Link",
    "LinkError",
    "MeasurementError",
    "Result",
    "RunError",
    "Scene",
    "SceneError",
    "Signal",
    "Stated",
    "Sweep",
    "Table",
    "__version__",
    "explain",
    "import_admittance",
    "import_friction",
    "metrics",
    "scenes",
]

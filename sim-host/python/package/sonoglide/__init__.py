"""Ultrasonic friction control: simulate a drive and its contact, and talk to a driver board.

    >>> import sonoglide
    >>> result = sonoglide.Scene.load("contact", {"excitation.velocity_ratio": 0.3}).run()
    >>> result["friction_ratio"]                                  # doctest: +SKIP

A scene is one TOML file, a dictionary, or a built-in scene (`scenes()`). `Scene.run()` corresponds to the command `sim-host run` and `Scene.sweep()` to
`sim-host sweep`, with the same compiled code: the same metrics, signals, figures and files. `import_admittance()` and `import_friction()` convert measured
data to parameters and scenes. `explain()` returns the meaning of a metric, a key or a fault, with its unit.
"""

from ._imported import Admittance, Conditions, Contact, Correlation, Friction, Stated, import_admittance, import_conditions, import_friction
from ._link import Answer, Link
from ._loop import Board, Controller, Plant, Processed, Sensed, Slow
from ._native import VERSION as __version__
from ._native import LinkError, MeasurementError, RunError, SceneError, Telemetry, explain, scenes
from ._result import Expectation, Figure, Result, Signal, Signals, Table
from ._scene import Law, Scene, metrics
from ._sweep import Sweep
from ._tools import Compared, Spectrogram, Suite, compare, spectrum, validate

__all__ = [
    "Admittance",
    "Answer",
    "Board",
    "Compared",
    "Conditions",
    "Contact",
    "Controller",
    "Correlation",
    "Expectation",
    "Figure",
    "Friction",
    "Law",
    "Link",
    "LinkError",
    "MeasurementError",
    "Plant",
    "Processed",
    "Result",
    "RunError",
    "Scene",
    "SceneError",
    "Sensed",
    "Signal",
    "Signals",
    "Slow",
    "Spectrogram",
    "Stated",
    "Suite",
    "Sweep",
    "Table",
    "Telemetry",
    "__version__",
    "compare",
    "explain",
    "import_admittance",
    "import_conditions",
    "import_friction",
    "metrics",
    "scenes",
    "spectrum",
    "validate",
]

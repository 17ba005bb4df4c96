"""Results of a run."""

from __future__ import annotations

import csv
import html
import io
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import matplotlib.axes
    import pandas
    import xarray
    from numpy.typing import NDArray

    from . import _native


@dataclass(frozen=True)
class Expectation:
    """An expectation of the scene, and its result."""

    metric: str
    #: Value of the metric; `None` if the run does not have it.
    value: float | None
    limit: str
    passed: bool
    source: str


class Signal:
    """A signal of a run."""

    def __init__(self, native: _native.Result, place: int, name: str, unit: str, meaning: str) -> None:
        self._native, self._place = native, place
        #: Name of the signal, with its unit.
        self.name = name
        #: Unit of the values; `1` for a ratio or a count, empty for text.
        self.unit = unit
        #: Meaning of the signal.
        self.meaning = meaning

    @cached_property
    def values(self) -> NDArray[Any]:
        """Values of the signal, one per row; arrays of numbers are read-only."""
        values = self._native.signal(self._place)
        return np.frombuffer(values) if isinstance(values, bytes) else np.array(values)

    def __repr__(self) -> str:
        return f"<sonoglide.Signal {self.name!r} [{self.unit}]: {self.meaning}>"


class Signals(dict[str, Signal]):
    """Signals of a run by their names, with conversions to tables."""

    def _axis(self) -> str:
        """Returns the name of the first signal, the time."""
        if not self:
            raise ValueError("this run has no signals: designs and several runs have none")
        return next(iter(self))

    def to_pandas(self) -> pandas.DataFrame:
        """Returns the signals as a data frame; `frame.attrs["units"]` has the unit of each column. Needs pandas."""
        import pandas

        frame = pandas.DataFrame({name: signal.values for name, signal in self.items()})
        frame.attrs["units"] = {name: signal.unit for name, signal in self.items()}
        return frame

    def to_xarray(self) -> xarray.Dataset:
        """Returns the signals as a data set over the first one, the time, with units and meanings as attributes. Needs xarray."""
        import xarray

        axis = self._axis()
        arrays = {
            name: xarray.DataArray(signal.values, dims=axis, attrs={"units": signal.unit, "long_name": signal.meaning})
            for name, signal in self.items()
        }
        return xarray.Dataset(arrays)


@dataclass(frozen=True)
class Table:
    """A table of the report."""

    id: str
    title: str
    caption: str
    header: list[str]
    rows: list[list[str]]

    def _repr_html_(self) -> str:
        def row(tag: str, cells: list[str]) -> str:
            return "<tr>" + "".join(f"<{tag}>{html.escape(cell)}</{tag}>" for cell in cells) + "</tr>"

        body = "".join(row("td", cells) for cells in self.rows)
        return f"<h4>{html.escape(self.title)}</h4><table>{row('th', self.header)}{body}</table><p>{html.escape(self.caption)}</p>"


class Figure:
    """A figure of a run, displayed by a notebook."""

    def __init__(self, native: _native.Result, place: int, id: str, title: str, caption: str) -> None:
        self._native, self._place = native, place
        #: Name of the figure, also that of its files.
        self.id = id
        #: Title of the figure.
        self.title = title
        #: Explanation for the reader.
        self.caption = caption

    @cached_property
    def svg(self) -> str:
        """The figure as an SVG document."""
        return self._native.svg(self._place)

    @property
    def csv(self) -> str:
        """The data of the figure as CSV; `sonoglide.explain(id + ".csv")` explains its columns."""
        return self._native.csv(self._place)

    @cached_property
    def data(self) -> dict[str, NDArray[Any]]:
        """The data of the figure by column: numbers, with NaN for empty cells, or text."""
        rows = list(csv.reader(io.StringIO(self.csv)))
        columns = zip(*rows[1:]) if len(rows) > 1 else ([] for _ in rows[0])
        return {name: _numbers(list(column)) for name, column in zip(rows[0], columns)}

    def _repr_svg_(self) -> str:
        return self.svg

    def __repr__(self) -> str:
        return f"<sonoglide.Figure {self.id!r}: {self.title}>"


class Result(Mapping[str, float]):
    """Result of a run. As a mapping it contains the metrics: `result["friction_ratio"]`."""

    def __init__(self, native: _native.Result) -> None:
        self._native = native

    @cached_property
    def summary(self) -> dict[str, Any]:
        """The summary of the run, as in `summary.json`. It is the same for every run of the same scene."""
        summary: dict[str, Any] = json.loads(self._native.summary)
        return summary

    @cached_property
    def metrics(self) -> dict[str, float]:
        """Metrics by their names, which end with their units. Metrics without a meaning in the scene are absent; an infinite statistic is `inf`."""
        return {name: float("inf") if value is None else value for name, value in self.summary["metrics"].items()}

    def __getitem__(self, metric: str) -> float:
        try:
            return self.metrics[metric]
        except KeyError:
            raise KeyError(f"this run has no metric {metric!r}; it has {', '.join(self.metrics)}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self.metrics)

    def __len__(self) -> int:
        return len(self.metrics)

    @property
    def passed(self) -> bool:
        """True if every expectation of the scene is met."""
        return self._native.passed

    @property
    def expectations(self) -> list[Expectation]:
        """Expectations of the scene, with their results."""
        return [
            Expectation(judged["metric"], judged["value"], judged["limit"], judged["pass"], judged["source"])
            for judged in self.summary["expect"]
        ]

    @property
    def machine(self) -> dict[str, Any]:
        """Figures of the machine, which differ from run to run: wall time, simulated seconds per second, and so on."""
        machine: dict[str, Any] = json.loads(self._native.machine)
        return machine

    @property
    def run_s(self) -> float:
        """Wall time of the run itself, s: without the overhead of Python, and without evaluation of the result."""
        return self._native.run_s

    @property
    def title(self) -> str:
        """Title of the scene."""
        return self._native.title

    @property
    def notes(self) -> list[str]:
        """Remarks on the run, and notes of the scene, a paragraph each."""
        return self._native.notes

    @cached_property
    def signals(self) -> Signals:
        """Signals of the run by their names, with one value per row. The rows of a driven run are those of its `[trace]`, by default one per block; those of a
        contact study are its last periods.

        `result.signals["time_s"].values` is a NumPy array.
        """
        return Signals({name: Signal(self._native, place, name, *texts) for place, (name, *texts) in enumerate(self._native.signals)})

    def plot(self, *names: str, axes: matplotlib.axes.Axes | None = None) -> matplotlib.axes.Axes:
        """Draws signals over the first one, the time, on your axes or on new ones. Needs matplotlib."""
        import matplotlib.pyplot

        first = self.signals._axis()
        time = self.signals[first]
        for name in names:
            if name not in self.signals:
                raise KeyError(f"this run has no signal {name!r}; it has {', '.join(self.signals)}")
        if not names:
            raise ValueError("name at least one signal")
        drawn = axes if axes is not None else matplotlib.pyplot.subplots()[1]
        for name in names:
            drawn.plot(time.values, self.signals[name].values, label=name)
        drawn.set_xlabel(f"{first} [{time.unit}]")
        units = {self.signals[name].unit for name in names}
        drawn.set_ylabel(f"[{units.pop()}]" if len(units) == 1 else "")
        drawn.legend()
        return drawn

    @cached_property
    def figures(self) -> dict[str, Figure]:
        """Figures of the run by their names, the most important first."""
        return {id: Figure(self._native, place, id, *texts) for place, (id, *texts) in enumerate(self._native.figures)}

    @cached_property
    def tables(self) -> dict[str, Table]:
        """Tables of the run by their names."""
        return {table[0]: Table(*table) for table in self._native.tables}

    def __repr__(self) -> str:
        headline = ", ".join(f"{label} {value}" for label, value in self._native.headline)
        return f"<sonoglide.Result of {self.summary['scene']!r}: {headline}>"

    def _repr_html_(self) -> str:
        tiles = "".join(
            f"<td style='text-align:left'>{html.escape(label)}<br><b>{html.escape(value)}</b></td>"
            for label, value in self._native.headline
        )
        tables = "".join(table._repr_html_() for table in self.tables.values())
        first = next(iter(self.figures.values()), None)
        figure = f"<div style='max-width:800px'>{_scaled(first.svg)}</div><p>{html.escape(first.caption)}</p>" if first else ""
        return f"<h3>{html.escape(self.title)}</h3><table><tr>{tiles}</tr></table>{figure}{tables}"


def _scaled(svg: str) -> str:
    """Makes a picture as wide as its container."""
    return svg.replace("<svg ", "<svg style='width:100%;height:auto' ", 1)


def _numbers(texts: list[str]) -> NDArray[Any]:
    try:
        return np.array([float(text) if text else np.nan for text in texts])
    except ValueError:
        return np.array(texts)

"""The link to a driver board."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from types import TracebackType
from typing import Any

from . import _native
from ._changes import Value, changes


class Answer(dict[str, Any]):
    """Answer of a board to a command: fields with their units in their names, and a `text` for a reader."""

    def __init__(self, text: str, fields: Mapping[str, Any]) -> None:
        super().__init__(fields)
        #: The answer as text, as the command line prints it.
        self.text = text

    def __str__(self) -> str:
        return self.text


class Link:
    """A session with a driver board, or with a simulated one. Used as a context manager it ends with its block, and the drive is switched off.

        with sonoglide.Link("sim:lock") as board:
            board.scan()["series_resonance_hz"]
            board.lock()
            board.drive(volts=3)
            board.capture(output="capture")

    While Python does something else, the session tells the board that its host is present.
    """

    def __init__(
        self,
        port: str,
        values: Mapping[str, Value] | None = None,
        *,
        host_timeout_s: float | None = None,
        stay: bool = False,
    ) -> None:
        """Connects to a serial device (`/dev/ttyACM0`, `COM3`), to `tcp:HOST:PORT`, or to `sim:SCENE`, a simulated board.

        `values` change the scene of a simulated board. `host_timeout_s` is the time for which the board drives without a message from its host (by default its
        own setting). With `stay` the drive continues after the session. Raises `LinkError` if no board answers.
        """
        self._native = _native.Link(port, changes(values), host_timeout_s, stay)

    @property
    def port(self) -> str:
        """Port, as given by the caller."""
        return self._native.port

    def run(self, command: str) -> Answer:
        """Runs a command, as `sim-host link PORT COMMAND` or a line of a script does: `scan`, `drive --volts 3`, `wait 0.2`, `settings get`.

        Raises `LinkError` if it fails.
        """
        text, fields = self._native.run(command)
        return Answer(text, json.loads(fields))

    def identify(self) -> Answer:
        """Returns firmware, protocol, and the state of the link."""
        return self.run("identify")

    def status(self) -> Answer:
        """Returns the present state of the board."""
        return self.run("status")

    def scan(self, output: str | os.PathLike[str] | None = None) -> Answer:
        """Finds the resonances; with `output` the admittance loop is written to that folder."""
        return self._ordered("scan", output=output)

    def lock(self) -> Answer:
        """Finds the resonance and locks to it."""
        return self.run("lock")

    def drive(self, *, volts: float | None = None, amperes: float | None = None) -> Answer:
        """Drives at the resonance with a peak voltage, V, or a peak motional current, A (the tip's velocity times the force factor), by default with the
        configured amplitude. The drive continues until `stop`."""
        return self._ordered("drive", volts=volts, current=amperes)

    def capture(self, output: str | os.PathLike[str] | None = None) -> Answer:
        """Records voltage, current and drive sample by sample; with `output` as CSV and figure in that folder."""
        return self._ordered("capture", output=output)

    def wait(self, seconds: float) -> Answer:
        """Waits, s, while the session keeps the link alive; a simulated board plays for that time."""
        return self.run(f"wait {seconds!r}")

    def stop(self) -> Answer:
        """Stops the drive."""
        return self.run("stop")

    def close(self) -> None:
        """Ends the session; the drive stops unless `stay` is set."""
        self._native.close()

    def _ordered(self, command: str, **options: float | str | os.PathLike[str] | None) -> Answer:
        words = [f'--{name} "{value}"' for name, value in options.items() if value is not None]
        return self.run(" ".join([command, *words]))

    def __enter__(self) -> Link:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<sonoglide.Link {self.port!r}>"

"""Controller and plant of a scene, block by block, in your loop."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from . import _native
from ._native import Telemetry
from ._scene import Scene

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Codes = NDArray[np.uint16]


class Slow(NamedTuple):
    """Slow readings of a board; `None` without such a sensor."""

    counts: int | None = None
    force_n: float | None = None
    temperature_c: float | None = None


class Sensed(NamedTuple):
    """Codes of the converters in one block, and slow readings."""

    v: Codes
    i: Codes
    slow: Slow = Slow()


class Processed(NamedTuple):
    """Answer of the controller to one block."""

    codes: Codes
    """Codes to play `latency_blocks` later: one row for each lane."""
    telemetry: Telemetry
    drops_queue: bool
    """`True` if the controller has entered a fault: codes that it returned before must not play."""
    listen: int
    """Lane that the sense channels are connected to while these codes play."""


def _bytes(codes: Any, dimensions: int) -> bytes:
    """Returns codes as bytes of 16-bit numbers."""
    array = np.asarray(codes)
    if array.dtype.kind not in "iu" or array.ndim != dimensions:
        raise ValueError(f"codes are whole numbers in an array of {dimensions} dimensions, not {array.dtype} in {array.ndim}; see `Controller.to_codes`")
    if array.dtype != np.uint16:
        if array.size and not (0 <= array.min() and array.max() <= 0xFFFF):
            raise ValueError("codes are from 0 to 65535")
        array = array.astype(np.uint16)
    return array.tobytes()


class Controller:
    """The firmware's controller with the settings of a scene; the same code, bit for bit, as on a board.

    It begins with the orders of the scene: it locks and runs. `process` takes the codes of the converters; `to_codes` and `to_volts` convert from and to
    physical units. If an answer drops the queue, the playing block must be silent from the sample `dropped_from` on; `Board` does this.
    """

    __slots__ = ("_native", "block_samples", "lanes", "latency_blocks", "sample_hz", "dropped_from", "_scale")

    def __init__(self, scene: Scene) -> None:
        self._native = _native.Controller(scene._native)
        self.lanes, self.block_samples, self.sample_hz, self.latency_blocks, self.dropped_from = self._native.shape
        self._scale = self._native.scale

    def silence(self) -> Codes:
        """Returns a block of silence: one row for each lane. It plays until the first answer does."""
        return self._lanes(self._native.silence())

    def process(self, v: Codes, i: Codes, slow: Slow = Slow()) -> Processed:
        """Processes the codes of voltage and current in one block: `block_samples` whole numbers from 0 to 65535 each."""
        codes, drops_queue, listen, telemetry = self._native.process(_bytes(v, 1), _bytes(i, 1), slow)
        return Processed(self._lanes(codes), telemetry, drops_queue, listen)

    def drive(self, volts: float | None = None, *, motional_a: float | None = None, detune_hz: float | None = None) -> None:
        """Orders a run with the drive always ON, at a voltage or a motional current (peak), or as the scene does. Like every order, it ends the friction steps
        of the scene."""
        self._native.drive(volts, motional_a, detune_hz)

    def pause(self, *, brake: bool = False) -> None:
        """Orders the drive OFF in a run; the frequency is held."""
        self._native.gate("brake" if brake else "off")

    def resume(self) -> None:
        """Orders the drive ON in a run."""
        self._native.gate("on")

    def follow_schedule(self) -> None:
        """Orders the bursts of the scene."""
        self._native.gate("scheduled")

    def set_friction(self, ratio: float | None = None, *, force_n: float | None = None) -> None:
        """Orders a friction ratio, 0 to 1, or a friction force, for scenes with `controller.friction`. It replaces an ordered amplitude."""
        self._native.friction(ratio, force_n)

    def stop(self, *, clear_fault: bool = False) -> None:
        """Orders silence, and clears a fault if wanted; then `drive` begins a new attempt."""
        self._native.stop(clear_fault)

    def to_codes(self, volts: Any, amperes: Any) -> tuple[Codes, Codes]:
        """Converts voltages and currents at the samples of a block to the codes of the converters."""
        return self._codes(volts, self._scale[2]), self._codes(amperes, self._scale[3])

    def to_volts(self, codes: Codes) -> NDArray[np.float64]:
        """Converts drive codes to the voltage that the amplifier is to play."""
        return (codes.astype(np.float64) - self._scale[4]) * self._scale[5]

    def _codes(self, of: Any, unit: float) -> Codes:
        middle, most = self._scale[:2]
        codes: Codes = np.clip(np.rint(np.asarray(of) / unit) + middle, 0, most).astype(np.uint16)
        return codes

    def _lanes(self, codes: bytes) -> Codes:
        return np.frombuffer(codes, np.uint16).reshape(self.lanes, self.block_samples)


class Plant:
    """The simulated amplifier, transducer, contact and converters of a scene."""

    __slots__ = ("_native",)

    def __init__(self, scene: Scene) -> None:
        self._native = _native.Plant(scene._native)

    def step(self, codes: Codes, listen: int = 0) -> Sensed:
        """Plays one block, one row for each lane, and returns the codes sampled meanwhile."""
        v, i, slow = self._native.step(_bytes(codes, 2), listen)
        return Sensed(np.frombuffer(v, np.uint16), np.frombuffer(i, np.uint16), Slow(*slow))

    @property
    def truth(self) -> dict[str, float]:
        """The true state at the end of the last block, which the controller never receives."""
        return dict(self._native.truth)

    @property
    def drive_hash(self) -> str:
        """Hash of all codes that were played, as in the summary of a run."""
        return self._native.drive_hash


class Board:
    """The queue of a board between controller and plant: codes play `latency_blocks` after the block that they answer.

    `plant` is `Plant.step` or any function of codes and lane that returns `Sensed`.
    """

    __slots__ = ("_controller", "_plant", "_queue")

    def __init__(self, controller: Controller, plant: Callable[[Codes, int], Sensed]) -> None:
        self._controller, self._plant = controller, plant
        self._queue = deque((controller.silence(), 0) for _ in range(controller.latency_blocks))

    def tick(self) -> Processed:
        """Plays the next block and processes it."""
        answer = self._controller.process(*self._plant(*self._queue[0]))
        self._queue.popleft()
        if answer.drops_queue and self._queue:
            codes, listen = self._queue.popleft()
            # A board is silent within three quarters of the playing block.
            silent = codes.copy()
            silent[:, self._controller.dropped_from :] = self._controller.silence()[0, 0]
            self._queue.appendleft((silent, listen))
        self._queue.append((answer.codes, answer.listen))
        return answer

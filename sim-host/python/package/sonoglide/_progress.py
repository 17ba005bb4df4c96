"""Progress bars with the protocol of tqdm: `total`, and `update(n)`."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, Protocol

#: Time between two looks at the progress, s.
INTERVAL_S = 0.1


class Bar(Protocol):
    """A progress bar, such as `tqdm.tqdm()`."""

    total: Any

    def update(self, n: float, /) -> Any:
        """Advances the bar by `n`."""


def advancing(bar: Bar, total: float) -> Callable[[float], None]:
    """Sets the end of a bar, and returns a function that advances it to a value."""
    bar.total = total
    reached = 0.0

    def advance(to: float) -> None:
        nonlocal reached
        to = min(to, total)
        if to > reached:
            bar.update(to - reached)
            reached = to

    return advance


@contextmanager
def watched(bar: Bar | None, total: float, done: Callable[[], float]) -> Iterator[None]:
    """Advances a bar while other work is done."""
    if bar is None:
        yield
        return
    advance, over = advancing(bar, total), threading.Event()

    def watch() -> None:
        while not over.wait(INTERVAL_S):
            advance(done())

    watcher = threading.Thread(target=watch, daemon=True)
    watcher.start()
    try:
        yield
    finally:
        over.set()
        watcher.join()
        advance(done())

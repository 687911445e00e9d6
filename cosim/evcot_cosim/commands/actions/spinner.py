# SPDX-License-Identifier: Apache-2.0
"""Progress of work of unknown length, on a terminal: what is done, how far it is, for how long. Nothing is printed in pipes."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

from evcot.events import Events

if TYPE_CHECKING:
    from rich.status import Status

__all__ = ["Counting"]


class Counting:
    """A line on standard error, shown only on a terminal, and gone at the end.

    Args:
        title: what is being done.
        enabled: False shows nothing at all.
    """

    def __init__(self, title: str, *, enabled: bool = True) -> None:
        self._title, self._begin_s = title, time.perf_counter()
        self._line = _line(title) if enabled and sys.stderr.isatty() else None

    def __enter__(self) -> Counting:
        if self._line is not None:
            self._line.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._line is not None:
            self._line.stop()

    def watched(self, blocks: Iterable[Events], t0_us: int) -> Iterator[Events]:
        """The same blocks, counted; `t0_us` is the time of the recording's first event."""
        events = 0
        for block in blocks:
            yield block
            events += len(block)
            self.update(events, int(block.t_us[-1]) - t0_us)

    def update(self, events: int, after_us: int) -> None:
        """So many events are done, up to this time after the recording's first."""
        if self._line is not None:
            taken_s = time.perf_counter() - self._begin_s
            done = f"{events:,} events, {after_us / 1e6:.3f} s of the recording"
            rate = f"{events / max(taken_s, 1e-9) / 1e6:.2f} M events/s"
            self._line.update(f"{self._title}: {done}; {taken_s:.0f} s so far, {rate}")


def _line(title: str) -> Status:
    from rich.console import Console
    from rich.status import Status

    return Status(title, console=Console(stderr=True))

# SPDX-License-Identifier: Apache-2.0
"""What a person sees while a recording of unknown length is read: events so far, and the time they reach; silent in pipes."""

from __future__ import annotations

from rich.console import Console
from rich.status import Status

__all__ = ["Counting"]


class Counting:
    """A line on standard error, shown only on a terminal, and gone at the end.

    Args:
        title: what is being done.
        enabled: False shows nothing at all.
    """

    def __init__(self, title: str, *, enabled: bool = True) -> None:
        console = Console(stderr=True)
        self._title = title
        self._line = Status(title, console=console) if enabled and console.is_terminal else None

    def __enter__(self) -> Counting:
        if self._line is not None:
            self._line.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._line is not None:
            self._line.stop()

    def update(self, events: int, after_us: int) -> None:
        """So many events are done, up to this time after the recording's first."""
        if self._line is not None:
            self._line.update(f"{self._title}: {events:,} events, {after_us / 1e6:.3f} s of the recording")

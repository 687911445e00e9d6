# SPDX-License-Identifier: Apache-2.0
"""Progress of a run, on a terminal: how far it is, time taken and left, rate. Nothing is printed in pipes."""

from __future__ import annotations

from rich.console import Console
from rich.progress import BarColumn, Task, TaskProgressColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.progress import Progress as Bars
from rich.text import Text

__all__ = ["Progress"]


class Progress:
    """A progress bar on standard error, shown only on a terminal.

    Args:
        title: what is being run.
        events: how many there are; None where nobody knows yet: `measured` tells it later.
        enabled: False shows nothing at all.
    """

    def __init__(self, title: str, events: int | None, *, enabled: bool = True) -> None:
        console = Console(stderr=True)
        self._bars = Bars(
            TextColumn("{task.description}"),
            BarColumn(),
            TaskProgressColumn(),
            TimeElapsedColumn(),
            _TimeLeftColumn(),
            TextColumn("{task.fields[state]}"),
            console=console,
            disable=not (enabled and console.is_terminal),
            transient=True,
        )
        self._task = self._bars.add_task(title, total=events, state="")

    def __enter__(self) -> Progress:
        self._bars.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._bars.stop()

    @property
    def shown(self) -> bool:
        """Whether anybody sees it."""
        return not self._bars.disable

    def measured(self, events: int) -> None:
        """There are so many events: from now on, the time left is known."""
        self._bars.update(self._task, total=events)

    def building(self) -> None:
        """A build begins."""
        self.note("compiling the hardware (10 to 60 s, once for each shape; kept in the cache)")

    def update(self, events: int, t_us: int, events_per_s: float) -> None:
        """So many events are done, up to this time of the recording."""
        self.advance(events, f"{t_us / 1e6:.3f} s of the recording, {events_per_s / 1e6:.2f} M events/s")

    def advance(self, done: int, state: str) -> None:
        """So much is done; say what is going on."""
        self._bars.update(self._task, completed=done, state=state)

    def note(self, state: str) -> None:
        """Say what is going on."""
        self._bars.update(self._task, state=state)


class _TimeLeftColumn(TimeRemainingColumn):
    """The time left; nothing where the whole is not known."""

    def render(self, task: Task) -> Text:
        if task.total is None or task.time_remaining is None:
            return Text("")
        return Text("left ", style="progress.remaining") + super().render(task)

# SPDX-License-Identifier: Apache-2.0
"""Progress of a run on a terminal, and the length of a recording, counted in the background. A pipe sees only builds."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext

from rich.console import Console
from rich.progress import BarColumn, Task, TaskProgressColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.progress import Progress as Bars
from rich.text import Text

from evcot.errors import EvcotError
from evcot.recordings.files import RecordingFile

__all__ = ["Length", "Progress", "counted_ahead"]


class Progress:
    """A progress bar on standard error, shown only on a terminal; in a pipe a line where a build begins.

    Args:
        title: what is being run.
        events: how many there are; None where nobody knows yet: `measured` tells it later.
        enabled: False shows nothing at all.
    """

    def __init__(self, title: str, events: int | None, *, enabled: bool = True) -> None:
        console = Console(stderr=True)
        self._piped = enabled and not console.is_terminal
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
        text = "compiling the hardware (10 to 60 s, once for each shape; kept in the cache)"
        self.note(text)
        if self._piped:
            print(f"evcot: {text}", file=sys.stderr, flush=True)

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


class Length:
    """Measures a file in a thread of its own, which rests as long as it works. A context manager.

    Args:
        opened: opens the file once more, to be read apart from whoever works on it.
        window: (from, to) in us after its first event.
        found: told the number of events in the window, and the seconds from its begin to its last event; not called for a
            file that is damaged.
    """

    def __init__(
        self, opened: Callable[[], RecordingFile], window: tuple[int, int | None], found: Callable[[int, float], None]
    ) -> None:
        self._opened, self._window, self._found = opened, window, found
        self._stopped = threading.Event()
        self._thread = threading.Thread(target=self._measure)

    def __enter__(self) -> Length:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stopped.set()
        self._thread.join()

    def _measure(self) -> None:
        events, last_us = 0, None
        try:
            with self._opened() as file:
                began_s = time.perf_counter()
                for block in file.blocks(*self._window):
                    events, last_us = events + len(block), int(block.t_us[-1])
                    if self._stopped.wait(time.perf_counter() - began_s):
                        return
                    began_s = time.perf_counter()
                if last_us is not None:
                    self._found(events, (last_us - file.t0_us - self._window[0]) / 1e6)
        except EvcotError:
            pass  # whoever works on the file says so


def counted_ahead(
    progress: Progress, opened: Callable[[], RecordingFile], window: tuple[int, int | None]
) -> AbstractContextManager[object]:
    """Count the events of a file while it is worked on, for a progress bar that is shown: then it can give the time left."""
    if not progress.shown:
        return nullcontext()
    return Length(opened, window, lambda events, _length_s: progress.measured(events))

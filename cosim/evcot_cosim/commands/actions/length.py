# SPDX-License-Identifier: Apache-2.0
"""The length of a recording, counted in the background while work on it goes on: a pass over the file may take minutes."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext

from evcot.errors import EvcotError
from evcot.recordings.files import RecordingFile

from .progress import Progress

__all__ = ["Length", "counted_ahead"]


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

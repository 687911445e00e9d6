# SPDX-License-Identifier: Apache-2.0
"""Plays one session after another, as pages choose."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from evcot.errors import EvcotError

from .session import Session

__all__ = ["Begin", "Player", "Run", "Wish"]


@dataclass(frozen=True)
class Wish:
    """What to play.

    Attributes:
        engine: a name in `evcot.trackers.engines.ENGINES`.
        preset: one of the engine's; None: its default.
        hardware: whether the hardware runs beside it.
        at_s: where in a file to begin, in seconds after its first event.
    """

    engine: str
    preset: str | None = None
    hardware: bool = False
    at_s: float = 0.0


@dataclass(frozen=True)
class Run:
    """A session, and its description for a page: name, engine, sensor and more."""

    session: Session
    hello: Mapping[str, Any]


Begin = Callable[[], Run]  # a new session, not started: called when the one before has ended
_NAP_S = 0.2
_PATIENCE_S = 2.0  # at the end, with what is being prepared


class Player:
    """Plays what is wished. A wish is prepared while the present session goes on, then takes its place.

    Args:
        prepare: the slow part of a wish, such as compiling; raises EvcotError for one that cannot be fulfilled.
        wish: the first one.
        fixed: why nothing else can be played: ""  if it can.

    Attributes:
        run: the present session.
        note: what is being prepared, or why the last wish cannot be fulfilled.

    Raises:
        EvcotError: the first wish cannot be fulfilled.
    """

    def __init__(self, prepare: Callable[[Wish], Begin], wish: Wish, fixed: str = "") -> None:
        self._prepare = prepare
        self.fixed = fixed
        self.run = prepare(wish)()
        self.note = ""
        self._next: Wish | None = None
        self._changed = threading.Condition()
        self._stopped = False
        self._thread = threading.Thread(target=self._serve, daemon=True)  # a compiler is not waited for

    def start(self) -> None:
        """Start the first session."""
        self.run.session.start()
        self._thread.start()

    def ask(self, wish: Wish) -> None:
        """Play this next; of several wishes that wait, the last. Thread-safe."""
        with self._changed:
            if not self.fixed:
                self._next = wish
                self._changed.notify()

    @property
    def running(self) -> bool:
        """Whether a session runs, or one is being prepared."""
        return self.run.session.running or self._next is not None

    @property
    def failed(self) -> bool:
        """Whether an error has ended the session."""
        return self.run.session.failed

    def end(self) -> None:
        """End the session, and begin no other. Thread-safe."""
        with self._changed:
            self._stopped = True
            self._changed.notify()
        self.run.session.end()

    def stop(self) -> None:
        """As `end`; complete the files of the session and close its source.

        Raises:
            RecordingError, OutputError: as `Session.stop`.
        """
        self.end()
        if self._thread.ident is not None:
            self._thread.join(_PATIENCE_S)
        self.run.session.stop()

    def _serve(self) -> None:
        while True:
            with self._changed:
                while self._next is None and not self._stopped:
                    self._changed.wait(_NAP_S)
                wish = self._next
                if self._stopped or wish is None:
                    return
            self._play(wish)
            with self._changed:
                if self._next is wish:
                    self._next = None

    def _play(self, wish: Wish) -> None:
        self.note = (
            f"preparing {wish.engine}{' and the hardware' if wish.hardware else ''} (compiled the first time, up to a minute)"
        )
        try:
            begin = self._prepare(wish)
            if self._stopped:
                return
            self.run.session.finish()
        except EvcotError as error:
            self.note = str(error)
            return
        run = begin()
        run.session.start()
        self.run, self.note = run, ""
        if self._stopped:
            run.session.end()

# SPDX-License-Identifier: Apache-2.0
"""Events in ticks from plain numbers, encoded as tokens and decoded again; memories of time stamps in simulation."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pyverilator import PyVerilator

from evcot.ticks import TickedEvents
from evcot_cosim.devices.base import reset

from .stream_device import Bundle

__all__ = ["TOKENS_IN", "TOKENS_OUT", "Token", "TokenEvents", "TokenMemory", "decode_tokens", "ticked"]


def ticked(ticks: ArrayLike, x: ArrayLike, y: ArrayLike, p: ArrayLike = 0) -> TickedEvents:
    """Events whose columns are integers of any type; one number stands for all events."""
    return TickedEvents(*np.broadcast_arrays(np.atleast_1d(ticks), x, y, p))


_FIELDS = ("tick", "event", "skip", "x", "y", "p")
TOKENS_IN = Bundle("s_", _FIELDS)
TOKENS_OUT = Bundle("m_", _FIELDS)


class TokenEvents(NamedTuple):
    """A decoded stream of tokens: the time of each event, the events, and the total duration.

    Attributes:
        at: (n,) int64, ticks from the start to each event.
        events: (n, 5) uint64, rows (event, skip, x, y, p).
        ticks: duration of the whole stream.
    """

    at: NDArray[np.int64]
    events: NDArray[np.uint64]
    ticks: int


def decode_tokens(tokens: NDArray[np.uint64]) -> TokenEvents:
    """Decode (n, 6) tokens (tick, event, skip, x, y, p)."""
    now = np.cumsum(tokens[:, 0].astype(np.int64))
    is_event = (tokens[:, 1] | tokens[:, 2]) == 1
    return TokenEvents(now[is_event], tokens[is_event, 1:], int(now[-1]) if len(now) else 0)


Token = tuple[int, bool, int, int, int]  # steps, access, x, y, data
Wanted = TypeVar("Wanted")


class TokenMemory(Generic[Wanted]):
    """The hardware, clock by clock; what comes out is compared with what is awaited, in order.

    Attributes:
        waiting: what belongs to each token inside.
        cleared_after: clocks from the last one of the reset until it was idle.

    Args:
        closed: whether it takes no token until then.
        inputs: that stay as they are.
    """

    def __init__(self, sim: PyVerilator, *, closed: bool, **inputs: int) -> None:
        self.sim = sim
        self.waiting: list[Wanted] = []
        for name, value in (inputs | {"advance": 1}).items():
            sim.io[name] = value
        reset(sim)
        self.cleared_after = 0
        while not sim.io.idle:
            assert not (closed and sim.io.s_ready)
            self.clock()
            self.cleared_after += 1

    def compare(self, wanted: Wanted) -> None:
        """Compare what comes out in this clock."""
        raise NotImplementedError

    def awaited(self, token: Token) -> Wanted:
        """What belongs to a token, which is taken now."""
        raise NotImplementedError

    def clock(self, advance: bool = True) -> None:
        """One clock; what comes out is compared."""
        io: Any = self.sim.io
        io.advance = int(advance)
        if io.m_valid and advance:
            self.compare(self.waiting.pop(0))
        self.sim.clock.tick()

    def offer(self, token: Token) -> bool:
        """Put a token on offer for the coming clock; whether that takes it."""
        io: Any = self.sim.io
        io.s_valid = 1
        io.s_step, io.s_access, io.s_x, io.s_y, io.s_data = map(int, token)
        if not io.s_ready:
            return False
        self.waiting.append(self.awaited(token))
        return True

    def run(
        self, rng: np.random.Generator, clocks: int, busy: float, freely: float, draw: Callable[[np.random.Generator], Token]
    ) -> None:
        """Random tokens and stalls, then clocks until nothing is inside.

        Args:
            busy: how likely a token is on offer where none was.
            freely: how likely the pipeline moves.
        """
        token: Token | None = None
        for _ in range(clocks):
            if token is None and rng.random() < busy:
                token = draw(rng)
            advance = bool(rng.random() < freely)
            self.sim.io.advance = int(advance)
            taken = token is not None and self.offer(token)
            self.sim.io.s_valid = int(token is not None)
            self.clock(advance)
            token = None if taken else token
        self.rest()

    def rest(self, patience: int = 60) -> None:
        """Clocks until nothing is inside."""
        self.sim.io.s_valid = 0
        for _ in range(patience):
            if self.sim.io.idle:
                break
            self.clock()
        assert self.sim.io.idle
        assert self.waiting == []

# SPDX-License-Identifier: Apache-2.0
"""Stimulus for the recording of a diagram: a few words, and stalls at chosen clocks."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence

from pyverilator import PyVerilator

from .trace import Trace

__all__ = ["Offer", "play"]


class Offer:
    """Driver that offers words on `<prefix>valid`, `<prefix>ready`, `<prefix><field>`, each until accepted.

    Args:
        pauses: clocks at which no new word is offered.
    """

    def __init__(
        self,
        sim: PyVerilator,
        prefix: str,
        fields: Sequence[str],
        words: Sequence[tuple[int, ...]],
        pauses: Collection[int] = (),
    ) -> None:
        self._sim, self._prefix, self._fields = sim, prefix, fields
        self._words, self._pauses = list(words), pauses
        self._offering = False

    def drive(self, clock: int) -> None:
        """Set the inputs before an edge."""
        self._offering = self._offering or bool(self._words and clock not in self._pauses)
        self._sim.io[f"{self._prefix}valid"] = int(self._offering)
        word = self._words[0] if self._offering else (0,) * len(self._fields)
        for name, value in zip(self._fields, word, strict=True):
            self._sim.io[self._prefix + name] = value

    def note(self) -> None:
        """Check whether the coming edge accepts the word."""
        if self._offering and int(self._sim.io[f"{self._prefix}ready"]):
            self._offering = False
            self._words.pop(0)


def play(
    trace: Trace,
    clocks: int,
    offers: Sequence[Offer] = (),
    stalls: Mapping[str, Collection[int]] | None = None,
    also: Callable[[int], None] | None = None,
) -> None:
    """Clock the simulation and record each clock.

    Args:
        trace: the trace to record.
        clocks: number of clocks.
        offers: words that go in.
        stalls: ready inputs, each with the clocks at which it is low.
        also: sets further inputs at each clock.

    Raises:
        ValueError: an output is stalled only where it offers nothing: the diagram would not show what a stall does.
    """
    idle_stalls = {port for port, low in (stalls or {}).items() if low}
    for clock in range(clocks):
        for offer in offers:
            offer.drive(clock)
        for port, low in (stalls or {}).items():
            trace.sim.io[port] = int(clock not in low)
        if also is not None:
            also(clock)
        trace.sample()
        idle_stalls -= {port for port in idle_stalls if not trace.sim.io[port] and trace.sim.io[port.replace("ready", "valid")]}
        for offer in offers:
            offer.note()
        trace.sim.clock.tick()
    if idle_stalls:
        raise ValueError(f"{', '.join(sorted(idle_stalls))}: stalled only where nothing is offered")

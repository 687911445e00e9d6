# SPDX-License-Identifier: Apache-2.0
"""What surrounds the parts of motion_work.v that say what is done when, and a list of what they said."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pyverilator import PyVerilator

__all__ = ["Control", "Said", "check_reset_of_job"]

Said = tuple[str, int] | tuple[str, int, int]
READ, WINDOW, SOON = 4, 6, 2  # clocks from `fetch` until the slot is read: motion_work.v; of a window: motion_window.v
LONGEST, MOST = 250, 400  # clocks in which nothing is said; what is said in all


def check_reset_of_job(sim: PyVerilator, commands: Sequence[str], **start: int) -> None:
    """A few clocks after a reset of one clock, at any moment of a job, the module rests and commands nothing.

    Args:
        start: inputs that begin the job.

    Raises:
        AssertionError: it does not rest, or commands something.
    """
    io = sim.io
    names = [*commands, *(name for name in ("fetch", "load", "unite", "say", "done") if name in dir(io))]
    for name in ("read_done", "window_done", "window_soon", "record_free", "pair_done", "meet_done", "lane"):
        if name in dir(io):
            setattr(io, name, 1)
    rested = 0
    for moment in range(60):
        for name, value in start.items():
            setattr(io, name, value)
        for _ in range(moment):
            sim.clock.tick()
        rested += int(io.rests)
        for name in start:
            setattr(io, name, 0)
        io.rst = 1
        sim.clock.tick()
        io.rst = 0
        for _ in range(SOON + 2):  # what was on its way
            sim.clock.tick()
        for _ in range(12):
            assert int(io.rests), moment
            assert [name for name in names if int(io[name])] == [], moment
            sim.clock.tick()
    assert rested < 30, "the job lasts"


class Control:
    """Memory, the axis in front, records and windows around one of them; records and windows as late as they like.

    Attributes:
        said: commands with their slot, in order; ("fetch", slot), ("clear", slot, bin), ("say", slot, kind).
        lane: whether x is behind, in the clock that comes; commands to motion_sides.v are given then.
    """

    def __init__(self, sim: PyVerilator, rng: np.random.Generator, commands: Sequence[str], to_sides: Sequence[str]) -> None:
        self.sim, self.io, self.rng = sim, sim.io, rng
        self.commands, self.to_sides = commands, frozenset(to_sides)
        ports = dir(sim.io)
        self.sees_lane = "lane" in ports
        self.clears, self.fetches, self.sees_soon = "op_clear" in ports, "fetch" in ports, "window_soon" in ports
        self.sees_masks = "mask_busy" in ports
        self.reads = [name for name in ("load", "unite") if name in ports]
        self.stalls = False
        self.said: list[Said] = []
        self.clocks = self.lane = self.quiet = 0
        self.at = [0] * 8  # slots of the clocks before, the last one first: motion_order.v hands them on a clock late
        self.read_at = -1  # clock in which `fetch` is answered
        self.window_at = -1
        self.loads: tuple[str, ...] = ()
        self.was_free = False

    def reset(self) -> None:
        self.io.rst = 1
        self.sim.clock.tick()
        self.io.rst = 0

    def steady(self, clocks: int) -> bool:
        """Whether the slot has been the same for so many clocks, as the memories see it."""
        return len(set(self.at[:clocks])) == 1

    def clock(self) -> None:
        """One clock; inputs beside those of this class have been set."""
        io, slot, first = self.io, self.slot(), len(self.said)
        read_done = self.read_at == self.clocks
        free = not self.stalls or bool(self.rng.random() < 0.5)
        if self.sees_lane:
            io.lane = self.lane
        io.read_done, io.record_free = int(read_done), int(free)
        io.window_done = int(self.window_at == self.clocks)
        if self.sees_soon:
            io.window_soon = int(self.window_at == self.clocks + SOON)
        if self.sees_masks:
            io.mask_busy = int(self.stalls and bool(self.rng.random() < 0.5))
        if self.read_at == self.clocks + READ - 1:  # memory has its address a clock after `fetch`
            self.said.append(("fetch", slot))
            self.fetched(slot)
        loads = self.loads if read_done else ()
        for name in loads:
            assert self.steady(READ)
            self.said.append((name, slot))
        for name in self.commands:
            if int(io[name]):
                if name in self.to_sides:
                    assert self.lane, name
                if name == "c_window":
                    self.window_at = self.clocks + (int(self.rng.integers(WINDOW, 12)) if self.stalls else WINDOW)
                self.said.append(self.command(name, slot))
        if int(io.say):
            assert self.was_free
            self.said.append(("say", slot, self.kind()))
        if self.fetches and int(io.fetch):
            self.read()
        if self.clears and int(io.op_clear):
            self.said.append(("clear", slot, int(io.op_bin)))
        self.loads = tuple(name for name in self.reads if int(io[name]))
        self.at = [self.handed_on(), *self.at[:-1]]
        self.quiet = 0 if len(self.said) > first else self.quiet + 1
        assert self.quiet < LONGEST
        assert len(self.said) < MOST
        self.was_free = free
        self.sim.clock.tick()
        self.clocks += 1
        self.lane = 1 if loads else 1 - self.lane

    def read(self) -> None:
        """In this clock the reading of a slot begins."""
        assert self.clocks > self.read_at
        self.read_at = self.clocks + READ

    def slot(self) -> int:
        """The slot of what is said in this clock."""
        return self.at[0]

    def handed_on(self) -> int:
        """The slot that is named in the next clock."""
        return int(self.io.at)

    def command(self, name: str, slot: int) -> Said:
        return name, slot

    def kind(self) -> int:
        return int(self.io.kind)

    def fetched(self, slot: int) -> None:
        """A slot is being read."""

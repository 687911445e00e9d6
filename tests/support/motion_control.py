# SPDX-License-Identifier: Apache-2.0
"""What surrounds the parts of motion_work.v that say what is done when, and a list of what they said."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pyverilator import PyVerilator

__all__ = ["Control", "Said"]

Said = tuple[str, int] | tuple[str, int, int]
READ, STORED, WINDOW = 7, 6, 6  # clocks from an operation until what it read is there, until it has written; of a window
LONGEST, MOST = 100, 400  # clocks in which nothing is said; what is said in all
STAGES = ("op_read", "op_store", "op_full", "op_put", "op_clear", "op_all")


class Control:
    """Operations, the axis in front, records and windows around one of them, each as late as it likes.

    Attributes:
        said: commands with their slot, in order; ("op_...", slot) of an operation, ("clear", slot, bin), ("say", slot, kind).
        lane: whether x is behind, in the clock that comes; commands to motion_sides.v are given then.
    """

    def __init__(self, sim: PyVerilator, rng: np.random.Generator, commands: Sequence[str], to_sides: Sequence[str]) -> None:
        self.sim, self.io, self.rng = sim, sim.io, rng
        self.commands, self.to_sides = commands, frozenset(to_sides)
        ports = dir(sim.io)
        self.sees_lane = "lane" in ports
        self.stages = [name for name in STAGES if name in ports]
        self.reads = [name for name in ("load", "unite") if name in ports]
        self.stalls = False
        self.said: list[Said] = []
        self.clocks = self.lane = self.quiet = 0
        self.at = [0] * 8  # slots of the clocks before, the last one first: motion_order.v hands them on a clock late
        self.under_way: list[tuple[int, str]] = []  # clock in which an operation is done
        self.window_at = -1
        self.loads: tuple[str, ...] = ()
        self.was_free = self.was_ready = False

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
        done = [name for due, name in self.under_way if due == self.clocks]
        ready = not self.stalls or not self.was_ready or bool(self.rng.random() < 0.6)  # low for a clock at most: motion_turn.v
        free = not self.stalls or bool(self.rng.random() < 0.5)
        if self.sees_lane:
            io.lane = self.lane
        io.op_ready, io.record_free = int(ready), int(free)
        io.read_done, io.store_done = int("read" in done), int("store" in done)
        io.window_done = int(self.window_at == self.clocks)
        loads = self.loads if "read" in done else ()
        for name in loads:
            assert self.steady(3)
            self.said.append((name, slot))
        for name in self.commands:
            if int(io[name]):
                if name in self.to_sides:
                    assert self.lane, name
                    assert not any(what == "store" for due, what in self.under_way if due > self.clocks), name
                if name == "c_window":
                    self.window_at = self.clocks + (int(self.rng.integers(3, 12)) if self.stalls else WINDOW)
                self.said.append(self.command(name, slot))
        if int(io.say):
            assert self.was_free
            self.said.append(("say", slot, self.kind()))
        if int(io.op_valid) and ready:
            self.operation(slot, first)
        self.loads = tuple(name for name in self.reads if int(io[name]))
        self.at = [self.handed_on(), *self.at[:-1]]
        self.quiet = 0 if len(self.said) > first else self.quiet + 1
        assert self.quiet < LONGEST
        assert len(self.said) < MOST
        self.was_free, self.was_ready = free, ready
        self.sim.clock.tick()
        self.clocks += 1
        self.lane = 1 if loads else 1 - self.lane

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

    def operation(self, slot: int, first: int) -> None:
        """One that is taken in this clock; what is said in the same clock need not wait for the last bin to be cleared."""
        flags = [name for name in self.stages if int(self.io[name])]
        if flags == ["op_clear"]:
            self.said.insert(first, ("clear", slot, int(self.io.op_bin)))
        else:
            self.said.append((" ".join(flags), slot))
        if "op_read" in flags:
            self.under_way.append((self.clocks + READ, "read"))
        if "op_store" in flags:
            self.under_way.append((self.clocks + STORED, "store"))

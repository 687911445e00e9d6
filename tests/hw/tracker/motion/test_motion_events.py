# SPDX-License-Identifier: Apache-2.0
"""motion_events.v: whose each event is, what it does to its owner, and operations between events, against the slow model."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from evcot_cosim.rtl.build import PORTS_ONLY_FLAGS, load
from support.motion_word import registers_word
from support.moving import QUICK
from support.slow_motion import PX, Axis, Slot, SlowArray, gap, pixel
from support.testing import lint

N, SLOT_W, X_W, Y_W, SIDE_W, PX_W, RADIX_W, SUP_W, SEQ_W, TIME_W = 4, 2, 6, 5, 25, 13, 5, 5, 8, 20
WIDTHS = {
    "N": N, "SLOT_W": SLOT_W, "X_W": X_W, "Y_W": Y_W, "SIDE_W": SIDE_W, "PX_W": PX_W, "RADIX_W": RADIX_W, "SUP_W": SUP_W,
    "SEQ_W": SEQ_W, "TIME_W": TIME_W,
}  # fmt: skip
MOST, REL = (1 << SUP_W) - 1, 1 << RADIX_W + 2
TOKEN, OPERATION, BINS = 7, 6, 8  # clocks until a token is done, an operation, until an event or a clear is at the bins
OPERATIONS = ("read", "store", "full", "put", "left", "seed", "clear")


def packed(values: list[int], bits: int) -> int:
    word = 0
    for value in values:
        word = word << bits | value % (1 << bits)
    return word


def bits_of(axes: list[Axis], name: str) -> int:
    """Marks, or hidden sides: hi and lo of y, hi and lo of x."""
    flags = [flag for axis in axes for flag in getattr(axis, name)]
    return sum(1 << i for i in range(4) if flags[i])


class Events:
    """The module, and the slow model, which does at once what is done in the pipeline."""

    def __init__(self) -> None:
        self.sim, self.rng = load("motion_events", WIDTHS, extra_flags=PORTS_ONLY_FLAGS), np.random.default_rng(1)
        self.io = self.sim.io
        self.r = replace(QUICK, gap_corrections=1)
        self.slow = SlowArray(self.r, N, MOST, 7)
        self.off = [False] * N
        self.expected: list[tuple[int, str, Any]] = []  # the clock in which it shows, where, what
        self.clocks = self.seq = self.time = 0
        self.left = [0] * N
        self.stored: list[int] = []  # the slot that waits and has been written
        self.has_bins = False
        self.seen: dict[str, int] = {}
        self.io.rst = 1
        self.sim.clock.tick()
        self.io.rst = 0
        self.set_registers()

    def slot(self, number: int) -> Slot:
        slot = self.slow.slots[number]
        assert slot is not None
        return slot

    def set_registers(self) -> None:
        rng = self.rng
        self.r = replace(
            self.r, side_step=int(rng.integers(1, 9_000)), side_share=int(rng.integers(1, 9)), seed_px=int(rng.integers(1, 5)),
            ring_px=int(rng.integers(3)), ring_any=int(rng.integers(5)), ring_max=int(rng.integers(2, 6)),
            gap_corrections=int(rng.integers(2)),
        )  # fmt: skip
        self.slow.r = self.r
        for slot in self.slow.slots:
            if slot is not None:
                slot.r = self.r
        self.io.regs = registers_word(self.r)
        self.clock(6)

    def clock(self, clocks: int = 1) -> None:
        io = self.io
        for _ in range(clocks):
            shown = {where: what for due, where, what in self.expected if due == self.clocks}
            assert int(io.d_valid) == ("token" in shown)
            if "token" in shown:
                found = {name: int(io[f"d_{name}"]) for name in shown["token"]}
                assert found == shown["token"]
            assert int(io.read_done) == ("read" in shown)
            if "read" in shown:
                assert (int(io.r_sides), int(io.r_marks), int(io.r_support)) == shown["read"]
            for name in ("store", "put"):
                assert int(io[f"{name}_done"]) == (name in shown)
            assert (int(io.bin_count), int(io.bin_clear)) == ("bins" in shown, "clear" in shown)
            if "clear" in shown:
                assert (int(io.bin_slot), int(io.bin_cleared)) == shown["clear"]
            if "bins" in shown:
                slot, *bins = shown["bins"]
                assert int(io.bin_slot) == slot
                for axis, number in zip("xy", bins, strict=True):
                    assert int(io[f"in_bin_{axis}"]) == (number is not None)
                    assert number is None or int(io[f"bin_{axis}"]) == number
            if "asked" in shown:
                assert (int(io.in_box), int(io.in_window)) == shown["asked"]
            stages = {"token": TOKEN, "op": OPERATION}
            inside = any(where in stages and due < self.clocks + stages[where] for due, where, _ in self.expected)
            assert int(io.active) == inside
            self.expected = [entry for entry in self.expected if entry[0] > self.clocks]
            begins = int(io.begins_slot) if int(io.begins) else None
            self.sim.clock.tick()
            self.clocks += 1
            if begins is not None:
                io.candidate = int(io.candidate) | 1 << begins
                self.free()
            io.s_valid = io.ask = 0
            for name in OPERATIONS:
                setattr(io, f"op_{name}", 0)

    def free(self) -> None:
        taken = int(self.io.visible) | int(self.io.candidate)
        self.io.fresh = self.io.empty = sum(1 << i for i in range(N) if not self.off[i] and not taken >> i & 1)

    # ---- tokens

    def token(self) -> None:
        """An event, one that a filter took out, or ticks alone."""
        io, rng = self.io, self.rng
        event, skip = rng.random() < 0.85, rng.random() < 0.5
        x, y, p = int(rng.integers(1 << X_W)), int(rng.integers(1 << Y_W)), int(rng.integers(2))
        if rng.random() < 0.8:
            x, y = x // 5 + 10, y // 4 + 10
        self.time += int(rng.integers(4))
        io.s_valid, io.s_event, io.s_skip, io.s_x, io.s_y, io.s_p = 1, int(event), int(skip and not event), x, y, p
        io.s_time = self.time
        done = {
            "event": int(event),
            "owned": 0,
            "corrects": 0,
            "seeds": 0,
            "time": self.time,
            "x": x,
            "y": y,
            "p": p,
            "seq": self.seq,
        }
        if event:
            done |= self.event((x, y))
        self.seq = (self.seq + (event or skip)) % (1 << SEQ_W)
        self.expected.append((self.clocks + TOKEN, "token", done))

    def event(self, place: tuple[int, int]) -> dict[str, int]:
        slow = self.slow
        free = [i for i in range(N) if slow.slots[i] is None and self.off[i]]
        for i in free:
            slow.slots[i] = Slot(i, self.r, -9_000, -9_000, 0)  # in the way of nothing
        slow.seeded, seeded = slow.seeded, slow.seeded
        slot, shared = slow._owner(self.time, place)
        for i in free:
            slow.slots[i] = None
        if slot is None:
            self.count("passed")
            return {}
        done = {"owned": 1, "slot": slot.number}
        if slot is slow.seeded and slot is not seeded:
            slot.due = 0
            self.count("seeds")
            return done | {"seeds": 1, "rel_x": 0, "rel_y": 0}
        waits, axes = slot.due is not None, slot.axes
        starts = [pixel(axis.lo) for axis in axes]
        corrects = slot.take(place, shared, MOST)
        if not shared and not waits and self.r.gap_corrections:
            numbers = [(at - start) // axis.bin_px for axis, at, start in zip(axes, place, starts, strict=True)]
            bins = [number if 0 <= number < 16 else None for number in numbers]
            self.expected.append((self.clocks + BINS, "bins", (slot.number, *bins)))
        if corrects:
            slot.due = 0
        self.count("shared" if shared else "waits" if waits else "corrects" if corrects else "owned")
        rel = {f"rel_{name}": (2 * at - sum(axis.box)) % REL for name, axis, at in zip("xy", axes, place, strict=True)}
        return done | {"corrects": int(corrects), "support": slot.support} | rel

    def count(self, name: str) -> None:
        self.seen[name] = self.seen.get(name, 0) + 1

    # ---- operations

    def operation(self, number: int, *names: str, number_of_bin: int = 0) -> None:
        io = self.io
        io.op_slot, io.op_bin = number, number_of_bin
        for name in names:
            setattr(io, f"op_{name}", 1)
            if name in ("store", "put"):
                self.expected.append((self.clocks + OPERATION, name, None))
            self.count(name)
        self.expected.append((self.clocks + OPERATION, "op", None))

    def read(self, number: int) -> None:
        slot = self.slot(number)
        sides = packed([side for axis in slot.axes for side in (axis.lo, axis.hi)], SIDE_W)
        self.expected.append((self.clocks + OPERATION, "read", (sides, bits_of(slot.axes, "beyond"), slot.support)))
        self.operation(number, "read")

    def write(self, number: int, *names: str) -> None:
        """Writes what the slow model has, with an empty token behind."""
        io, slot = self.io, self.slot(number)
        if "store" in names:
            io.o_sides = packed([side for axis in slot.axes for side in (axis.lo, axis.hi)], SIDE_W)
            io.o_marks, io.o_hidden, io.o_support = bits_of(slot.axes, "beyond"), bits_of(slot.axes, "hidden"), slot.support
        if "put" in names:
            io.o_box = packed([bound for axis in slot.axes for bound in axis.box], PX_W)
            io.o_window = packed([bound for axis in slot.axes for bound in axis.window], PX_W)
            io.o_n_ev = slot.n_ev
        self.operation(number, *names)
        self.clock()

    def writing(self) -> bool:
        return any(where in ("store", "put", "clear") for _, where, _ in self.expected)

    def change(self, slot: Slot) -> None:
        """Other sides, as after a correction or a step."""
        rng = self.rng
        for axis in slot.axes:
            axis.lo += int(rng.normal(0, PX))
            axis.hi = axis.lo + int(rng.integers(-PX, 14 * PX))
            axis.beyond = [bool(rng.integers(2)) for _ in range(2)]

    def work(self) -> None:
        """The next operation for a slot that waits: its bins, its sides, then it is put in force."""
        rng, slow = self.rng, self.slow
        waiting = [slot for slot in slow.slots if slot is not None and slot.due is not None]
        if not waiting or self.writing():
            return
        slot = self.slot(self.stored[0]) if self.stored else waiting[int(rng.integers(len(waiting)))]
        seeds = slot is slow.seeded
        if slot.number not in self.stored:
            if not seeds:
                self.change(slot)
            self.stored.append(slot.number)
            self.write(slot.number, "store", *["full"] * seeds)
            if rng.random() < 0.5:
                self.clock()
                self.read(slot.number)
            self.has_bins = not seeds
        elif not self.has_bins or rng.random() < 0.3:
            self.bins(slot)
            self.has_bins = True
        else:
            self.stored.remove(slot.number)
            slot.n_ev = int(rng.integers(1, 12))
            slot.next_rings = (int(rng.integers(4)), int(rng.integers(4)))
            slot.put_in_force()
            if seeds:
                slow.seeded = None
            self.write(slot.number, "put", "left", *["seed"] * seeds)

    def bins(self, slot: Slot) -> None:
        slot.clear_bins()
        self.io.o_log2 = packed([axis.bin_px.bit_length() - 1 for axis in reversed(slot.axes)], 5)
        number = int(self.rng.integers(16))
        self.expected.append((self.clocks + BINS, "clear", (slot.number, number)))
        self.operation(slot.number, "clear", number_of_bin=number)
        self.clock()

    def step(self) -> None:
        """As in a motion step: nothing is under way or waits, then slots appear, end, and are written."""
        rng, slow, io = self.rng, self.slow, self.io
        while any(slot is not None and slot.due is not None for slot in slow.slots):
            self.work()
            self.clock()
        self.clock(BINS + 1)
        assert not int(io.active)
        for i in range(N):
            slot = slow.slots[i]
            self.off[i] = self.off[i] != (rng.random() < 0.1)
            if slot is not None and rng.random() < 0.3:
                slow.slots[i] = None
            elif slot is not None:
                slot.visible = slot.visible or bool(rng.random() < 0.5)
                self.read(i)
                self.clock()
                self.change(slot)
                slot.support = int(rng.integers(MOST + 1))
                for axis in slot.axes:
                    axis.hidden = [bool(rng.random() < 0.3) for _ in range(2)]
                    axis.set_box(int(rng.integers(4)))
                self.write(i, "store", "full", "put")
                self.clock(OPERATION)
        living = [slot for slot in slow.slots if slot is not None]
        io.visible = sum(1 << slot.number for slot in living if slot.visible)
        io.candidate = sum(1 << slot.number for slot in living if not slot.visible)
        self.free()
        self.ask(living)
        if rng.random() < 0.5:
            self.set_registers()
        self.clock(3)

    def ask(self, living: list[Slot]) -> None:
        """Which boxes and windows share an interval, of those that live."""
        lows = [int(low) for low in self.rng.integers(-5, 40, 2)]
        place = [(low, low + int(self.rng.integers(9))) for low in lows]
        answer = [
            sum(1 << s.number for s in living if all(gap(getattr(a, name), p) <= 0 for a, p in zip(s.axes, place, strict=True)))
            for name in ("box", "window")
        ]
        self.io.ask, self.io.ask_for = 1, packed([bound for pair in place for bound in pair], PX_W)
        self.clock()
        self.clock()
        lives = sum(1 << slot.number for slot in living)
        assert [int(self.io.in_box) & lives, int(self.io.in_window) & lives] == answer
        line = [s.number for s in living if any(gap(a.box, p) <= 0 for a, p in zip(s.axes, place, strict=True))]
        assert int(self.io.in_line) & lives == sum(1 << number for number in line)


def test_random_events_and_operations() -> None:
    events = Events()
    events.free()
    rng = events.rng
    for clock in range(4_000):
        what = rng.random()
        if clock % 200 == 199:
            events.step()
        elif what < 0.75:
            events.token()
        elif what < 0.79:
            living = [s.number for s in events.slow.slots if s is not None and s is not events.slow.seeded]
            if living:
                events.read(int(rng.choice(living)))
        elif what < 0.95:
            events.work()
        events.clock()
    events.clock(BINS + 1)
    assert not events.expected
    assert min(events.seen.values()) > 10


def test_lint() -> None:
    assert lint("motion_events") == (0, "")
    assert lint("motion_events", N=1, SLOT_W=1) == (0, "")

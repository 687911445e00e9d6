# SPDX-License-Identifier: Apache-2.0
"""motion_events.v: whose each event is, what it does to its owner, and operations between events, against the slow model."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from evcot_cosim.rtl.build import PORTS_ONLY_FLAGS, load
from support.moving import QUICK, registers_word
from support.slow_motion import PX, Axis, Seen, Slot, SlowArray, pixel

N, SLOT_W, X_W, Y_W, SIDE_W, PX_W, RADIX_W, SUP_W, SEQ_W, TIME_W = 4, 2, 6, 5, 25, 13, 5, 4, 8, 20
WIDTHS = {
    "N": N, "SLOT_W": SLOT_W, "X_W": X_W, "Y_W": Y_W, "SIDE_W": SIDE_W, "PX_W": PX_W, "RADIX_W": RADIX_W, "SUP_W": SUP_W,
    "SEQ_W": SEQ_W, "TIME_W": TIME_W,
}  # fmt: skip
MOST, REL = (1 << SUP_W) - 1, 1 << RADIX_W + 2
TOKEN, OPERATION, BINS = (
    7,
    6,
    8,
)  # clocks until a token is done, and a job leaves; an operation is; an event is at the bins
STATES = ("free", "candidate", "visible", "left")
CORRECTION, SEED, STEP = range(3)


def packed(values: list[int], bits: int) -> int:
    word = 0
    for value in values:
        word = word << bits | value % (1 << bits)
    return word


def bits_of(axes: list[Axis] | list[Seen], name: str) -> int:
    """Marks, or hidden sides: hi and lo of y, hi and lo of x."""
    flags = [flag for axis in axes for flag in getattr(axis, name)]
    return sum(1 << i for i in range(4) if flags[i])


class Events:
    """The module, and the slow model, which does at once what is done in the pipeline; its jobs compute anything."""

    def __init__(self) -> None:
        self.sim, self.rng = load("motion_events", WIDTHS, extra_flags=PORTS_ONLY_FLAGS), np.random.default_rng(1)
        self.io = self.sim.io
        self.r = replace(QUICK, gap_corrections=1)
        self.slow = SlowArray(self.r, N, MOST, 7)
        self.off = [True] * N
        self.expected: list[tuple[int, str, Any]] = []  # the clock in which it shows, where, what
        self.clocks = self.seq = self.time = 0
        self.rests = self.stays = 0  # clocks until another token may come, another effect
        self.corrects = 0
        self.has_bins = True  # a new candidate has
        self.seen: dict[str, int] = {}
        self.io.rst = 1
        self.sim.clock.tick()
        self.io.rst = 0
        while not int(self.io.ready):
            self.sim.clock.tick()
        self.set_registers()

    @property
    def living(self) -> list[Slot]:
        return [slot for slot in self.slow.slots if slot is not None]

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
            assert (int(io.d_valid), int(io.j_valid)) == ("token" in shown, "job" in shown)
            for name in {"token", "job"} & shown.keys():
                assert {port: int(io[port]) for port in shown[name]} == shown[name]
            assert int(io.effect_done) == ("effect" in shown)
            assert (int(io.bin_count), int(io.bin_clear)) == ("bins" in shown, "clear" in shown)
            if "clear" in shown:
                assert (int(io.bin_slot), int(io.bin_cleared)) == shown["clear"]
            if "bins" in shown:
                slot, *bins = shown["bins"]
                assert int(io.bin_slot) == slot
                for axis, number in zip("xy", bins, strict=True):
                    assert int(io[f"in_bin_{axis}"]) == (number is not None)
                    assert number is None or int(io[f"bin_{axis}"]) == number
            self.corrects = shown.get("corrects", self.corrects)
            assert int(io.corrects) == self.corrects
            stages = {"token": TOKEN, "op": OPERATION}
            self.active = any(where in stages and due < self.clocks + stages[where] for due, where, _ in self.expected)
            assert int(io.active) == self.active
            self.expected = [entry for entry in self.expected if entry[0] > self.clocks]
            self.sim.clock.tick()
            self.clocks += 1
            self.rests, self.stays = max(self.rests - 1, 0), max(self.stays - 1, 0)
            io.s_valid = io.op_step = io.op_effect = io.op_clear = 0

    def expect(self, clocks: int, where: str, what: Any = None) -> None:
        self.expected.append((self.clocks + clocks, where, what))

    def expect_corrects(self) -> None:
        self.expect(TOKEN, "corrects", sum(1 << slot.number for slot in self.living if slot.corrects))

    def count(self, name: str) -> None:
        self.seen[name] = self.seen.get(name, 0) + 1

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
        io.s_burst = in_burst = int(rng.random() < 0.3)
        done = {"event": int(event), "owned": 0, "time": self.time, "x": x, "y": y, "p": p, "seq": self.seq}
        if event:
            done |= self.event((x, y), bool(in_burst))
        self.seq = (self.seq + (event or skip)) % (1 << SEQ_W)
        self.expect(TOKEN, "token", {f"d_{name}": value for name, value in done.items()})

    def event(self, place: tuple[int, int], in_burst: bool) -> dict[str, int]:
        slow = self.slow
        slot, shared = slow._owner(place)
        if slot is None:
            return self.seed(place)
        corrected, starts, box = slot.corrects, [pixel(seen.lo) for seen in slot.seen], [sum(seen.box) for seen in slot.seen]
        corrects = slot.take(place, shared, MOST, in_burst)
        if not shared and not corrected and self.r.gap_corrections:
            numbers = [(at - start) // axis.bin_px for axis, at, start in zip(slot.axes, place, starts, strict=True)]
            self.expect(BINS, "bins", (slot.number, *(number if 0 <= number < 16 else None for number in numbers)))
        if corrects:
            self.job(slot, CORRECTION, j_burst=int(in_burst))
            slot.count, slot.corrects = 0, True
            for seen in slot.seen:
                seen.beyond = [False, False]
            self.expect_corrects()
        self.count("shared" if shared else "waits" if corrected else "corrects" if corrects else "owned")
        rel = {f"rel_{name}": (2 * at - total) % REL for name, total, at in zip("xy", box, place, strict=True)}
        return {"owned": 1, "slot": slot.number} | rel

    def seed(self, place: tuple[int, int]) -> dict[str, int]:
        """A candidate begins, unless another one is not in effect."""
        slots = self.slow.slots
        free = [i for i in range(N) if slots[i] is None]
        left = [slot.number for slot in self.living if slot.left_seen]
        choice = [i for i in free + left if not self.off[i]]
        self.count("passed" if self.slow.seeded or not choice else "seeds" if choice[0] in free else "seeds at a left one")
        if self.slow.seeded or not choice:
            return {}
        slot = slots[choice[0]] = self.slow.seeded = Slot(choice[0], self.r, *place, self.time)
        self.has_bins = False
        for seen in slot.seen:
            seen.lo = seen.hi = 0  # from where it moves
        self.expect(TOKEN, "job", {"j_kind": SEED, "d_slot": slot.number, "j_sides": 0})
        self.expect_corrects()
        return {"owned": 1, "slot": slot.number, "rel_x": 0, "rel_y": 0}

    def job(self, slot: Slot, kind: int, **more: int) -> None:
        sides = packed([side for seen in slot.seen for side in (seen.lo, seen.hi)], SIDE_W)
        job = {"j_sides": sides, "j_marks": bits_of(slot.seen, "beyond"), "j_owned": slot.owned, "d_slot": slot.number}
        self.expect(TOKEN, "job", job | {"j_kind": kind} | more)
        self.count("most" if slot.owned == MOST else "job")
        slot.owned = 0

    # ---- operations

    def step(self) -> None:
        """Of any slot; nothing is under way, and the next token comes some clocks later."""
        self.clock(TOKEN + self.stays)
        number = int(self.rng.integers(N))
        slot = self.slow.slots[number]
        self.io.op_step, self.io.op_slot = 1, number
        self.io.s_time = time = self.time + int(self.rng.integers(9))
        self.expect(OPERATION, "op")
        if slot is not None:
            self.job(slot, STEP)
            self.count("step of a new one" if slot is self.slow.seeded else "step")
        else:
            self.expect(TOKEN, "job", {})
        self.expected[-1][2].update({"j_kind": STEP, "d_time": time, "d_seq": self.seq, "d_slot": number})
        self.clock(4)

    def clear(self) -> None:
        """A bin of a slot whose correction or seed is computed."""
        slots = [slot for slot in self.living if slot.corrects and self.corrects >> slot.number & 1]
        if not slots:
            return
        slot, number = slots[int(self.rng.integers(len(slots)))], int(self.rng.integers(16))
        slot = self.slow.seeded if self.slow.seeded in slots and not self.has_bins else slot
        logs = [int(self.rng.integers(4)) for _ in slot.axes]
        for axis, log in zip(slot.axes, logs, strict=True):
            axis.bin_px = 1 << log
        self.has_bins = self.has_bins or slot is self.slow.seeded
        self.io.bin_log2, self.io.op_clear, self.io.op_bin, self.io.op_slot = packed(logs[::-1], 5), 1, number, slot.number
        self.expect(BINS, "clear", (slot.number, number))
        self.expect(OPERATION, "op")
        self.stays = max(self.stays, BINS)  # the size of bins stays

    def effect(self) -> None:
        """What has been computed of a slot, and the end of others; events may be under way if none causes a job of it."""
        rng, io = self.rng, self.io
        fast = [slot for slot in self.living if slot.corrects and self.corrects >> slot.number & 1]
        among = [slot for slot in (fast if self.active else self.living) if self.has_bins or slot is not self.slow.seeded]
        if not among or self.stays:
            return
        slot = among[int(rng.integers(len(among)))]
        self.write_masks(slot)
        for _ in range(int(rng.integers(5))):
            self.token()
            self.clock()
        if self.active and not (slot.corrects and self.corrects >> slot.number & 1):
            self.clock(TOKEN)
        others = [other for other in self.living if other is not slot and rng.random() < 0.1 and not self.active]
        io.op_effect, io.op_slot, io.e_own = 1, slot.number, int(self.active or not others or rng.random() < 0.8)
        io.e_ended = sum(1 << other.number for other in others)
        self.count("fast" if self.active else "effect")
        if int(io.e_own):
            self.compute(slot)
        for other in others:
            self.end(other)
            self.count("ended")
        self.expect(OPERATION, "op")
        self.expect(OPERATION, "effect")
        self.expect_corrects()
        self.rests, self.stays = 2, OPERATION + 1

    def end(self, slot: Slot) -> None:
        self.slow.slots[slot.number] = None
        if slot is self.slow.seeded:
            self.slow.seeded = None

    def write_masks(self, slot: Slot) -> None:
        """A box and a window are computed, perhaps twice: the last ones count. No event comes meanwhile."""
        io, rng = self.io, self.rng
        for _ in range(int(rng.integers(1, 3))):
            for axis in slot.axes:
                axis.lo = int(rng.integers(5 * PX, 25 * PX))
                axis.hi = axis.lo + int(rng.integers(-PX, 20 * PX))
                axis.set_box(int(rng.integers(4)))
            io.mask_slot = slot.number
            self.clock()
            io.mask, io.mask_box = 1, packed([bound for axis in slot.axes for bound in axis.box], PX_W)
            io.mask_window = packed([bound for axis in slot.axes for bound in axis.window], PX_W)
            self.clock()
            io.mask = 0
            while int(io.mask_busy):
                self.clock()
        self.clock(2)

    def compute(self, slot: Slot) -> None:
        """Something, and it takes effect."""
        rng, io = self.rng, self.io
        state = int(rng.choice(4, p=[0.05, 0.3, 0.5, 0.15]))
        slot.visible, slot.left = STATES[state] == "visible", STATES[state] == "left"
        io.e_n_ev = n_ev = int(rng.integers(1, 12 if rng.random() < 0.8 else 60))
        if slot.corrects:
            slot.n_ev, slot.count = n_ev, 0
        for axis, seen in zip(slot.axes, slot.seen, strict=True):
            axis.moves = [axis.lo - seen.lo, axis.hi - seen.hi]
            axis.hidden = [bool(rng.random() < 0.3) for _ in range(2)]
            axis.beyond = [bool(rng.random() < 0.2) for _ in range(2)]
        io.e_state, io.e_marks, io.e_hidden = state, bits_of(slot.axes, "beyond"), bits_of(slot.axes, "hidden")
        io.e_moves = packed([move for axis in slot.axes for move in axis.moves], SIDE_W)
        io.e_middle = packed([sum(axis.box) for axis in slot.axes[::-1]], RADIX_W + 2)
        slot.take_effect()
        if slot is self.slow.seeded:
            self.slow.seeded = None
            self.count("new one")
        if STATES[state] == "free":
            self.end(slot)

    def pause(self) -> None:
        """Nothing is under way: other registers and modes."""
        self.clock(TOKEN + self.stays + BINS)
        assert not self.active
        assert int(self.io.alive) == sum(1 << slot.number for slot in self.living)
        self.off = [self.rng.random() < 0.1 for _ in range(N)]
        self.io.seeded = sum(1 << i for i in range(N) if not self.off[i])
        if self.rng.random() < 0.5:
            self.set_registers()
        self.clock(3)


def test_random_events_and_operations() -> None:
    events = Events()
    rng = events.rng
    events.pause()
    for clock in range(20_000):
        what = rng.random()
        if clock % 300 == 299:
            events.pause()
        elif what < 0.02:
            events.step()
        elif what < 0.12:
            events.effect()
        elif what < 0.2 and not events.stays:
            events.clear()
        elif what < 0.9 and not events.rests:
            events.token()
        events.clock()
    events.clock(BINS + 1)
    assert not events.expected
    assert min(events.seen.values()) > 3, events.seen
    assert len(events.seen) == 15, events.seen

# SPDX-License-Identifier: Apache-2.0
"""motion_step.v: a motion step of a slot, or the end of its life, in order, whatever is found out about it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest

from evcot.tracks.log import Kind
from evcot_cosim.rtl.build import PORTS_ONLY_FLAGS, load
from support.motion_control import Control, Said
from support.testing import lint

N, SLOT_W = 5, 3
TO_SIDES = ("c_reflect", "c_move", "c_rub", "c_shorten")
COMMANDS = (
    *TO_SIDES, "c_window", "keep_window", "c_compare", "c_pair", "c_part", "merge", "c_ask", "c_meet", "appear", "lapse",
    "keep_now", "keep_until", "keep",
)  # fmt: skip
TAKE = (  # clocks of motion_pair.v, motion_meeting.v and motion_times.v, more or less; motion_merge.v takes longer
    ("c_compare", "pair", 21, 22), ("c_ask", "meet", 11, 12), ("merge", "merge", 2, 20), ("c_divide", "divide", 1, 20),
)  # fmt: skip
Pairs = dict[tuple[int, int], bool]


@dataclass
class Step:
    """What is found out in a step, by slot, or by the slot whose step it is and another one."""

    states: list[str]
    corrections: list[int]
    ended: list[bool]
    meets: list[bool]
    silent: list[bool]
    held: list[bool]
    overdue: list[bool]
    appears: list[bool]
    near: Pairs
    alike: Pairs
    weaker: Pairs
    older: Pairs
    enough: Pairs
    touched: list[list[int]]
    returned: list[list[int]]
    keep_older: bool
    may_return: bool
    said: list[Said] = field(default_factory=list)

    def stays(self, this: int, other: int, *, by_support: bool) -> tuple[int, int]:
        """Which one stays, and which goes."""
        swap = self.weaker[this, other]
        if not by_support and self.states[this] != self.states[other]:
            swap = self.states[other] == "visible"
        elif not by_support and self.keep_older:
            swap = self.older[this, other]
        return (other, this) if swap else (this, other)

    def lapse(self, slot: int, *, alone: bool = False) -> None:
        visible = self.states[slot] == "visible"
        if visible:
            self.said += [("keep_now", slot), ("say", slot, Kind.LOST)]
        leaves = visible and self.may_return and not alone
        if leaves:
            self.said += [("c_window", slot), ("keep_window", slot), ("leave", slot), ("keep_until", slot)]
            self.said += [("keep", slot), ("op_all", slot)]
        else:
            self.said.append(("lapse", slot))
        self.states[slot] = "left" if leaves else "free"

    def end(self, slot: int) -> None:
        """The end of one life."""
        if self.states[slot] != "free":
            self.said += [("op_read", slot), ("load", slot), ("c_reflect", slot)]
            self.lapse(slot, alone=True)

    def go(self, this: int) -> None:
        """docs/motion.md, rules S."""
        if self.states[this] == "free":
            return
        known = self.states[this] == "visible" or self.corrections[this] >= 4
        self.said += [("op_read", this), ("load", this), ("c_reflect", this)]
        if self.ended[this]:
            self.lapse(this)
            return
        if self.states[this] == "left":
            return
        self.said += [("c_move", this)] * known + [("c_rub", this)] * (known and not self.meets[this] and self.silent[this])
        self.said += [("c_shorten", this), ("c_reflect", this), ("c_window", this), ("keep_window", this)]
        self.said.append(("c_ask", this))
        partner = self.partner(this)
        if partner is None:
            self.said.append(("c_part", this))
        else:
            if self.enough[this, partner] and self.merge(this, partner, by_support=False):
                return
            self.said.append(("c_ask", this))
        if self.states[this] == "visible":
            self.said.append(("c_meet", this))
            if self.overdue[this]:
                self.said += [("keep_now", this), ("say", this, Kind.MOVED)]
        elif self.held[this]:
            self.lapse(this)
            return
        else:
            for other in self.touched[this]:
                if self.states[other] == "candidate":
                    self.said.append(("op_read", other))
                    if self.merge(this, other, by_support=True):
                        return
                    self.said.append(("c_ask", this))
            if self.appears[this]:
                gone = [other for other in self.returned[this] if self.states[other] == "left"]
                if gone:
                    self.said.append(("lapse", gone[0]))
                    self.states[gone[0]] = "free"
                self.said += [("resume" if gone else "appear", this), ("keep_now", this)]
                self.said.append(("say", this, Kind.MOVED if gone else Kind.BORN))
                self.states[this] = "visible"
        self.said += [("keep", this), ("op_all", this)]

    def partner(self, this: int) -> int | None:
        """The lowest one that is alike, of those near that have four corrections; it is read first."""
        if self.corrections[this] < 4:
            return None
        for other in range(N):
            if (
                other != this
                and self.near[this, other]
                and self.states[other] in ("visible", "candidate")
                and self.corrections[other] >= 4
            ):
                self.said += [("op_read", other), ("c_compare", other)]
                if self.alike[this, other]:
                    self.said.append(("c_pair", other))
                    return other
        return None

    def merge(self, this: int, other: int, *, by_support: bool) -> bool:
        """Whether this slot is the one that goes."""
        stays, goes = self.stays(this, other, by_support=by_support)
        self.said.append(("merge", stays, goes))
        self.states[goes] = "free"
        return goes == this


def random_step(rng: np.random.Generator) -> Step:
    def flags(share: float) -> list[bool]:
        return [bool(flag) for flag in rng.random(N) < share]

    def pairs(share: float) -> Pairs:
        return {(a, b): bool(rng.random() < share) for a in range(N) for b in range(N)}

    states = [str(state) for state in rng.choice(["visible", "visible", "candidate", "candidate", "free", "left"], N)]
    corrections = [int(rng.integers(0 if state == "candidate" else 4, 12)) for state in states]
    touched, returned = (
        [[other for other in range(N) if other != this and rng.random() < share] for this in range(N)] for share in (0.3, 0.7)
    )
    return Step(
        states, corrections, flags(0.1), flags(0.5), flags(0.5), flags(0.2), flags(0.5), flags(0.5),
        pairs(0.7), pairs(0.4), pairs(0.5), pairs(0.5), pairs(0.5), touched, returned,
        bool(rng.integers(2)), bool(rng.integers(2)),
    )  # fmt: skip


class Around(Control):
    """An operation that reads says which slot is held against the one whose step it is."""

    compared = 0

    def command(self, name: str, slot: int) -> Said:
        if name == "lapse" and int(self.io.leave):
            return "leave", slot
        if name == "appear" and int(self.io.resume):
            return "resume", slot
        if name == "merge":
            return name, int(self.io.stays), int(self.io.goes)
        return name, int(self.io.this_slot) if name == "c_part" else slot

    def operation(self, slot: int, first: int) -> None:
        if int(self.io.op_all):
            self.said.append(("op_all", slot))
            self.under_way.append((self.clocks + 6, "store"))
        else:
            self.said.append(("op_read", slot))
            self.under_way.append((self.clocks + 7, "read"))
            self.compared = slot


def show(io: Any, states: list[str]) -> None:
    for name in ("visible", "candidate", "left"):
        setattr(io, name, sum(1 << i for i in range(N) if states[i] == name))


def run(control: Around, step: Step, rng: np.random.Generator) -> None:
    """Answers what is asked until the step is done."""
    io = control.io
    wait: dict[str, int] = {}
    states, touched = list(step.states), [list(others) for others in step.touched]
    begins = {name: int(io[name]) for name in ("start", "end_life")}
    io.start = io.end_life = 0
    show(io, states)  # a clock before
    control.clock()
    for name, begin in begins.items():
        setattr(io, name, begin)
    while True:
        at, this, other = control.at[0], min(int(io.this_slot), N - 1), control.compared
        noise = [int(bit) for bit in rng.integers(2, size=12)]
        show(io, states)
        io.settled = sum(1 << i for i in range(N) if step.corrections[i] >= 4)
        io.corrections = step.corrections[this]
        io.ended = int(step.ended[at]) if control.steady(3) else noise[0]
        io.meets, io.silent = int(step.meets[this]), int(step.silent[this])
        io.older = int(step.older[this, other]) if at == this and control.steady(4) else noise[1]
        io.weaker = int(step.weaker[this, other])
        io.alike, io.enough = int(step.alike[this, other]), int(step.enough[this, other])
        io.keep_older, io.may_return = int(step.keep_older), int(step.may_return)
        io.overdue, io.appears = int(step.overdue[this]), int(step.appears[this])
        io.held = int(step.held[this]) if int(io.c_touch) else noise[3]
        candidates = [slot for slot in touched[this] if states[slot] == "candidate"]
        io.touches, io.touched = int(bool(candidates)), candidates[0] if candidates else noise[2]
        gone = [slot for slot in step.returned[this] if states[slot] == "left"]
        io.returns, io.returned = int(bool(gone)), gone[0] if gone else noise[4]
        io.nearby = sum(1 << i for i in range(N) if step.near[this, i])
        io.pair_done, io.meet_done = int(wait.get("pair") == 1), int(wait.get("meet") == 1)
        io.merged, io.dividing = int(wait.get("merge") == 1), int(wait.get("divide", 0) > 0)
        if int(io.merged):
            states[int(io.goes)] = "free"
        if int(io.lapse):
            states[at] = "left" if int(io.leave) else "free"
        if int(io.appear):
            states[at] = "visible"
        control.clock()
        io.start = io.end_life = 0
        wait = {name: clocks - 1 for name, clocks in wait.items() if clocks > 1}
        for port, name, least, most in TAKE:
            if int(io[port]):
                wait[name] = int(rng.integers(least, most))
        assert int(io.widest) or not int(io.leave)
        assert not int(io.widest) or not int(io.c_ask)
        if int(io.rests):
            assert not any(due >= control.clocks for due, _ in control.under_way)
            control.clock()  # a life that ends alone ends in the first clock of rest
            return


@pytest.mark.parametrize("stalls", [False, True])
def test_random_steps(stalls: bool) -> None:
    sim = load("motion_step", {"N": N, "SLOT_W": SLOT_W}, extra_flags=PORTS_ONLY_FLAGS)
    io, rng, steps = sim.io, np.random.default_rng(1), np.random.default_rng(2)
    control = Around(sim, rng, COMMANDS, TO_SIDES)
    control.reset()
    control.stalls = stalls
    seen: dict[str, int] = {}
    for _ in range(700):
        step, alone = random_step(steps), steps.random() < 0.2
        expected = Step(**{**vars(step), "states": list(step.states)})
        slot = int(steps.integers(N))
        io.work_slot = slot
        if alone:
            io.end_life = 1
            expected.end(slot)
        else:
            io.start = 1
            expected.go(slot)
        control.said.clear()
        run(control, step, rng)
        assert [(name, *more) for name, *more in control.said] == expected.said
        for name, *_ in expected.said:
            seen[name] = seen.get(name, 0) + 1
    assert min(seen.get(name, 0) for name in (*COMMANDS, "leave", "resume")) > 2, seen


def test_a_slot_whose_track_may_return_takes_the_clocks_of_the_header() -> None:
    sim = load("motion_step", {"N": N, "SLOT_W": SLOT_W}, extra_flags=PORTS_ONLY_FLAGS)
    rng = np.random.default_rng(3)
    control = Around(sim, rng, COMMANDS, TO_SIDES)
    control.reset()
    took = []
    for state in ("free", "left"):
        step = random_step(rng)
        step.states, step.ended = [state] * N, [False] * N
        sim.io.start, sim.io.work_slot, begun = 1, 1, control.clocks
        run(control, step, rng)
        took.append(control.clocks - begun)
    assert took[1] - took[0] == 10


def test_lint() -> None:
    assert lint("motion_step") == (0, "")
    assert lint("motion_step", N=1, SLOT_W=1) == (0, "")

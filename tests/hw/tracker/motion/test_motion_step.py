# SPDX-License-Identifier: Apache-2.0
"""motion_step.v: a motion step of a slot, or the end of its life, in order, whatever is found out about it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest

from evcot.tracks.log import Kind
from evcot_cosim.rtl.build import PORTS_ONLY_FLAGS, load
from support.motion_control import Control, Said, check_reset_of_job

N, SLOT_W = 5, 3
STATES = ("free", "candidate", "visible", "left")
TO_SIDES = ("c_reflect", "c_move", "c_rub", "c_shorten")
COMMANDS = (
    *TO_SIDES, "c_window", "c_follow", "keep_window", "c_compare", "c_pair", "c_part", "merge", "c_ask", "c_meet", "appear",
    "lapse", "keep_now", "keep_until", "keep",
)  # fmt: skip
TAKE = (  # clocks of motion_pair.v, motion_meeting.v and motion_times.v, more or less; motion_merge.v takes longer
    ("c_compare", "pair", 21, 22), ("c_ask", "meet", 10, 10 + N), ("merge", "merge", 2, 20), ("c_divide", "divide", 1, 20),
)  # fmt: skip
MEET_ALL = (
    ("c_compare", "pair", 23, 24),
    ("c_ask", "meet", 10 + N, 11 + N),
    ("merge", "merge", 2, 20),
    ("c_divide", "divide", 1, 2),
)  # as with N slots in use
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

    def stays(self, this: int, other: int, *, by_support: bool) -> bool:
        """Whether the slot whose step it is stays; else it waits for the other one's step."""
        if not by_support and self.states[this] != self.states[other]:
            return self.states[this] == "visible"
        return not (self.older if not by_support and self.keep_older else self.weaker)[this, other]

    def lapse(self, slot: int, *, alone: bool = False) -> None:
        visible = self.states[slot] == "visible"
        if visible:
            self.said += [("keep_now", slot), ("say", slot, Kind.LOST)]
        leaves = visible and self.may_return and not alone
        if leaves:
            self.said += [("c_window", slot), ("keep_window", slot), ("leave", slot), ("keep_until", slot)]
        else:
            self.said.append(("lapse", slot))
        self.said.append(("keep", slot))
        self.states[slot] = "left" if leaves else "free"

    def end(self, slot: int) -> None:
        """The end of one life."""
        self.said += [("fetch", slot), ("load", slot), ("c_reflect", slot)]
        self.lapse(slot, alone=True)

    def go(self, this: int) -> None:
        """docs/motion.md, rules S."""
        known = self.states[this] == "visible" or self.corrections[this] >= 4
        self.said += [("fetch", this), ("load", this), ("c_reflect", this)]
        if self.ended[this]:
            self.lapse(this)
            return
        if self.states[this] == "left":
            self.said += [("c_window", this), ("keep", this)]
            return
        self.said += [("c_move", this)] * known + [("c_rub", this)] * (known and not self.meets[this] and self.silent[this])
        self.said += [("c_shorten", this), ("c_reflect", this), ("c_window", this)]
        self.said += [("c_follow", this)] * known + [("c_ask", this), ("keep_window", this)]
        partner = self.partner(this)
        if partner is None:
            self.said.append(("c_part", this))
        else:
            if self.enough[this, partner] and self.stays(this, partner, by_support=False):
                self.merge(this, partner)
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
                    self.said.append(("fetch", other))
                    if not self.stays(this, other, by_support=True):
                        self.said.append(("keep", this))
                        return
                    self.merge(this, other)
                    self.said.append(("c_ask", this))
            if self.appears[this]:
                gone = [other for other in self.returned[this] if self.states[other] == "left"]
                if gone:
                    self.said.append(("lapse", gone[0]))
                    self.states[gone[0]] = "free"
                self.said += [("resume" if gone else "appear", this), ("keep_now", this)]
                self.said.append(("say", this, Kind.MOVED if gone else Kind.BORN))
                self.states[this] = "visible"
        self.said.append(("keep", this))

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
                self.said += [("fetch", other), ("c_compare", other)]
                if self.alike[this, other]:
                    self.said.append(("c_pair", other))
                    return other
        return None

    def merge(self, this: int, other: int) -> None:
        self.said.append(("merge", this, other))
        self.states[other] = "free"


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
    """The slot that is read last is compared with the one whose step it is."""

    compared = 0

    def command(self, name: str, slot: int) -> Said:
        if name == "lapse" and int(self.io.leave):
            return "leave", slot
        if name == "appear" and int(self.io.resume):
            return "resume", slot
        if name == "merge":
            return name, int(self.io.this_slot), int(self.io.goes)
        return name, int(self.io.this_slot) if name == "c_part" else slot

    def fetched(self, slot: int) -> None:
        self.compared = slot


def show(io: Any, states: list[str]) -> None:
    io.left = sum(1 << i for i in range(N) if states[i] == "left")


def run(control: Around, step: Step, rng: np.random.Generator, takes: tuple[tuple[str, str, int, int], ...] = TAKE) -> None:
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
    control.read()  # motion_order.v does
    while True:
        at, this, other = control.at[0], min(int(io.this_slot), N - 1), control.compared
        noise = [int(bit) for bit in rng.integers(2, size=12)]
        show(io, states)
        io.settled = sum(1 << i for i in range(N) if step.corrections[i] >= 4)
        io.corrections = step.corrections[this]
        io.at_state = STATES.index(states[min(control.at[1], N - 1)])
        io.ended = int(step.ended[at]) if control.steady(3) else noise[0]
        io.too_long = int(bool(rng.random() < 0.2) and control.stalls)
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
        io.nearby = sum(1 << i for i in range(N) if step.near[this, i] and i != this and states[i] != "free")
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
        for port, name, least, most in takes:
            if int(io[port]):
                wait[name] = int(rng.integers(least, most))
        assert int(io.widest) or not int(io.leave)
        assert not int(io.widest) or not int(io.c_ask)
        assert int(io.done) == int(io.rests)
        if int(io.done):
            control.clock()  # in which the slot is written
            return


@pytest.mark.parametrize("end_life", [0, 1])
def test_a_reset_at_any_moment_of_a_step_ends_it(end_life: int) -> None:
    sim = load("motion_step", {"N": N, "SLOT_W": SLOT_W}, extra_flags=PORTS_ONLY_FLAGS)
    check_reset_of_job(sim, COMMANDS, start=1, end_life=end_life)


@pytest.mark.parametrize("stalls", [False, True])
def test_random_steps(stalls: bool) -> None:
    sim = load("motion_step", {"N": N, "SLOT_W": SLOT_W}, extra_flags=PORTS_ONLY_FLAGS)
    io, rng, steps = sim.io, np.random.default_rng(1), np.random.default_rng(2)
    control = Around(sim, rng, COMMANDS, TO_SIDES)
    control.reset()
    control.stalls = stalls
    seen: dict[str, int] = {}
    for _ in range(350):
        step, alone = random_step(steps), steps.random() < 0.2
        expected = Step(**{**vars(step), "states": list(step.states)})
        taken = [i for i in range(N) if step.states[i] != "free"]
        if not taken:
            continue
        io.work_slot = slot = int(steps.choice(taken))
        io.start, io.end_life = 1, int(alone)
        if alone:
            expected.end(slot)
        else:
            expected.go(slot)
        control.said.clear()
        run(control, step, rng)
        assert [(name, *more) for name, *more in control.said] == expected.said
        for name, *_ in expected.said:
            seen[name] = seen.get(name, 0) + 1
    assert min(seen.get(name, 0) for name in (*COMMANDS, "leave", "resume")) > 2, seen


LIVES = 46 + N - 1  # clocks of a step after which a candidate is what it was
CLOCKS = {  # what becomes of a slot -> its state, what is found out, clocks
    "may return": ("left", {}, 20),
    "lives": ("candidate", {}, LIVES),
    "is compared with one": ("candidate", {"near": 1}, LIVES + 30 + 4),
    "is compared with two": ("candidate", {"near": 2}, LIVES + 60 + 4),
    "becomes visible": ("candidate", {"appears": 1}, LIVES + 5),
    "becomes visible as one that had left": ("candidate", {"appears": 1, "returned": 1}, LIVES + 5 + 5),
    "ends": ("candidate", {"ended": 1}, 14),
    "is not held": ("candidate", {"held": 1}, LIVES - 3),
    "visible, lives": ("visible", {}, LIVES - 5),
    "visible, is reported": ("visible", {"overdue": 1}, LIVES - 4),
    "visible, ends": ("visible", {"ended": 1}, 15),
    "visible, leaves": ("visible", {"ended": 1, "may_return": 1}, 25),
}


@pytest.mark.parametrize("name", CLOCKS)
def test_a_step_takes_the_stated_clocks(name: str) -> None:
    state, given, clocks = CLOCKS[name]
    sim = load("motion_step", {"N": N, "SLOT_W": SLOT_W}, extra_flags=PORTS_ONLY_FLAGS)
    rng = np.random.default_rng(3)
    control = Around(sim, rng, COMMANDS, TO_SIDES)
    control.reset()
    step = random_step(rng)
    step.states, step.corrections = [state] * N, [4] * N
    for flag in ("ended", "held", "appears", "overdue"):
        setattr(step, flag, [bool(given.get(flag))] * N)
    step.touched = [[] for _ in range(N)]
    step.returned = [[3] * given.get("returned", 0) for _ in range(N)]
    if step.returned[1]:
        step.states[3] = "left"
    step.near = {(a, b): b > 1 and b < 2 + given.get("near", 0) for a in range(N) for b in range(N)}
    step.alike, step.may_return = dict.fromkeys(step.alike, False), bool(given.get("may_return"))
    sim.io.start, sim.io.work_slot, begun = 1, 1, control.clocks
    run(control, step, rng, MEET_ALL)
    before_and_after = 2  # clocks of run() that are not of the step
    assert control.clocks - begun - before_and_after == clocks

# SPDX-License-Identifier: Apache-2.0
"""motion_axis.v: what events and effects do to both sides of an axis of several slots, one a clock."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from evcot_cosim.rtl.build import load
from support.slow_motion import PX, Seen, pixel

AT_W, SIDE_W, REL_W, SLOTS = 7, 25, 10, 4
SEEN, SHOWN, BINNED = 2, 3, 4  # clocks from the slot's number to rel, to the sides, to the bin
EVENTS = ("event", "shared", "cause")  # moves the sides; does not; and clears marks
EFFECTS = ("effect", "fresh")


@dataclass
class Token:
    """A token, what the slot has behind it, and where its event lies."""

    kind: str = ""
    slot: int = 0
    place: int = 0
    out: int = 0
    back: int = 0
    moves: tuple[int, int] = (0, 0)
    marks: int = 0  # that an effect adds
    hidden: int = 0
    middle: int = 0
    sides: tuple[int, int] = (0, 0)
    shown: int = 0  # marks
    rel: int = 0
    bin: int | None = None

    @property
    def updates(self) -> bool:
        return self.kind not in ("", "shared")


def flags(number: int) -> list[bool]:
    return [bool(number & 1), bool(number >> 1)]


def number_of(marks: list[bool]) -> int:
    return marks[0] + 2 * marks[1]


class Slots:
    """What the slots have, token by token."""

    def __init__(self) -> None:
        self.rng = np.random.default_rng(1)
        self.seen = [Seen(0, 0) for _ in range(SLOTS)]
        self.middles, self.log2s = [0] * SLOTS, [0] * SLOTS

    def effect(self, slot: int, kind: str) -> Token:
        """Computed state of a slot, or a new candidate's: its sides count from 0."""
        seen, rng = self.seen[slot], self.rng
        if kind == "fresh":
            seen.lo, seen.hi, seen.beyond = 0, 0, [False, False]
        lo, hi = (int(side) for side in rng.integers(-40 * PX, 170 * PX, 2))
        marks, hidden = int(rng.integers(4)) if rng.random() < 0.3 else 0, int(rng.integers(4)) if rng.random() < 0.5 else 0
        token = Token(kind, slot, int(rng.integers(128)), moves=(lo - seen.lo, hi - seen.hi), marks=marks, hidden=hidden)
        token.middle = self.middles[slot] = int(rng.integers(1 << REL_W))
        seen.lo, seen.hi, seen.hidden = lo, hi, flags(hidden)
        seen.beyond = [a or b for a, b in zip(seen.beyond, flags(marks), strict=True)]
        token.sides, token.shown = (lo, hi), number_of(seen.beyond)
        return token

    def event(self, slot: int, kind: str) -> Token:
        seen, rng = self.seen[slot], self.rng
        token = Token(kind, slot, int(rng.integers(128)), int(rng.integers(1 << 19)), int(rng.integers(1 << 17)))
        token.rel = (2 * token.place - self.middles[slot]) % (1 << REL_W)
        number = (token.place - pixel(seen.lo)) >> self.log2s[slot]
        token.bin = number if 0 <= number < 16 else None
        if kind in ("event", "cause"):
            seen.measure(token.place * PX, token.out, token.back)
        token.sides, token.shown = (seen.lo, seen.hi), number_of(seen.beyond)
        if kind == "cause":
            seen.beyond = [False, False]
        return token

    def tokens(self) -> list[Token]:
        """Behind an effect comes none; a step reads when nothing is under way."""
        rng, found = self.rng, []
        slots = int(rng.integers(1, SLOTS + 1))
        for _ in range(15):
            kind = str(rng.choice(["", *EVENTS, "effect", "fresh"], p=[0.05, 0.6, 0.1, 0.1, 0.1, 0.05]))
            slot = int(rng.integers(slots))
            if kind == "fresh" and any(token.slot == slot for token in found[-3:]):  # a new candidate holds no event
                kind = "effect"
            if kind in EVENTS:
                found.append(self.event(slot, kind))
            elif kind:
                found += [self.effect(slot, kind), Token()]
            else:
                found.append(Token())
        slot = int(rng.integers(SLOTS))
        return [*found, *[Token()] * 4, self.event(slot, "rest")]


def test_random_events_and_effects() -> None:
    sim, slots = load("motion_axis", {"AT_W": AT_W, "SIDE_W": SIDE_W, "SLOT_W": 2, "REL_W": REL_W}), Slots()
    io, beyond, bins = sim.io, set(), set()
    first = [token for slot in range(SLOTS) for token in (slots.effect(slot, "fresh"), Token())]
    for round_ in range(300):
        tokens = [*[Token()] * 6, *(first if round_ == 0 else slots.tokens()), *[Token()] * 6]
        for t in range(6, len(tokens)):
            one, two, three = tokens[t], tokens[t - 1], tokens[t - 2]
            io.slot = one.slot
            io.hide_now, io.s_hidden = int(one.kind in EFFECTS), one.hidden
            io.slot_2, io.place, io.out, io.back = two.slot, two.place, two.out, two.back
            io.forward = int(three.kind in EVENTS and three.slot == two.slot)
            io.recent = int(tokens[t - 3].updates and tokens[t - 3].slot == two.slot)
            io.moves, io.rests, io.fresh = (
                int(two.kind in ("effect", "fresh")),
                int(two.kind == "rest"),
                int(two.kind == "fresh"),
            )
            io.s_move_lo, io.s_move_hi = (move % (1 << SIDE_W) for move in two.moves)
            io.slot_3, io.update, io.clear = three.slot, int(three.updates), int(three.kind == "cause")
            io.effect = int(three.kind in EFFECTS)
            began, io.begins = int(io.begins), int(not three.updates and bool(t % 2))
            io.s_marks, io.s_middle = three.marks, three.middle
            if tokens[t - SEEN].kind in EVENTS:
                assert int(io.rel) == tokens[t - SEEN].rel
            if tokens[t - SHOWN].updates:
                sides = tuple(side % (1 << SIDE_W) for side in tokens[t - SHOWN].sides)
                assert (int(io.m_lo), int(io.m_hi), int(io.m_marks)) == (*sides, tokens[t - SHOWN].shown)
                beyond.add(int(io.m_marks))
            elif began:
                assert (int(io.m_lo), int(io.m_hi)) == (0, 0)
            if tokens[t - BINNED].kind in EVENTS:
                number = tokens[t - BINNED].bin
                assert int(io.in_bin) == (number is not None)
                assert number is None or int(io.bin) == number
                bins.add(number)
            sim.clock.tick()
        io.update = io.effect = io.clear = 0
        for slot in range(SLOTS) if round_ == 0 else [round_ % SLOTS]:
            slots.log2s[slot] = int(slots.rng.integers(4))
            io.slot_3, io.set_bins, io.s_log2 = slot, 1, slots.log2s[slot]
            sim.clock.tick()
        io.set_bins = 0
    assert beyond == {0, 1, 2, 3}
    assert bins == {None, *range(16)}

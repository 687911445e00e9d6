# SPDX-License-Identifier: Apache-2.0
"""The steps around the array's slots: order, sums, merges, input and output."""

from __future__ import annotations

from collections import deque
from fractions import Fraction
from itertools import accumulate, product
from math import floor
from typing import NamedTuple

import numpy as np
import pytest
from pyverilator import PyVerilator

from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load
from support.testing import PATTERNS, Sink, Source, Word, always, evaluate, run_streams


@pytest.mark.parametrize("n", [1, 2, 3, 8, 64])
def test_random_births_and_questions(n: int) -> None:
    """After thousands of births the answer is still that of a list; slots keep being named that nobody asked for."""
    sim = load("array_order", {"N": n, "SLOT_W": max(1, (n - 1).bit_length())})
    rng, io, row = np.random.default_rng(n), sim.io, list(range(n))
    reset(sim)

    def clock(slot: int, asked: int = 0, born: int = 0) -> None:
        io.slot, io.asked, io.born = slot, asked, born
        sim.clock.tick()

    answers = [0, 0]
    for _ in range(4_000):
        slot, other = (int(number) for number in rng.integers(0, n, 2))
        if rng.random() < 0.5:
            clock(slot, asked=1)
            clock(int(rng.integers(n)), born=1)
            clock(int(rng.integers(n)))
            row.remove(slot)
            row.append(slot)
        elif slot != other:
            clock(slot, asked=1)
            clock(other, asked=1)
            io.asked = 0
            assert io.second_first == (row.index(other) < row.index(slot))
            answers[io.second_first] += 1
        else:
            clock(slot, asked=int(rng.integers(2)))  # named, but not born
    assert n == 1 or min(answers) > 300


def test_reset_begins_with_the_slots_in_order() -> None:
    sim = load("array_order", {"N": 3, "SLOT_W": 2})
    io = sim.io
    reset(sim)
    for asked, born in ((1, 0), (0, 1), (0, 0)):  # slot 0 goes to the end
        io.slot, io.asked, io.born = 0, asked, born
        sim.clock.tick()
    for begins_anew, first in ((False, 1), (True, 0)):
        if begins_anew:
            reset(sim)
        for slot in (1 - first, first):
            io.slot, io.asked = slot, 1
            sim.clock.tick()
        assert io.second_first == 1


@pytest.mark.parametrize("round_up", [0, 1])
def test_every_operand_and_choice(round_up: int) -> None:
    w = 4
    a, one, other, choice = (axis.ravel() for axis in np.meshgrid(range(16), range(32), range(32), range(2)))
    taken = np.where(choice, one, other)
    ports = {"a": a, "one": one, "other": other, "choice": choice}
    result = evaluate("array_sum", {"W": w, "ROUND": round_up}, ports, ["y"])["y"]
    np.testing.assert_array_equal(result, (a + (taken >> 1) + round_up * (taken & 1)) % 16)


SUP_W = 5


class Track(NamedTuple):
    """The context of a slot."""

    slot: int
    id: int
    cm_x: int
    cm_y: int
    g: int
    support: int


@pytest.mark.parametrize("means", [1, 2])
@pytest.mark.parametrize(("pos_x", "pos_y", "rounds"), [(7, 5, 1), (4, 6, 0)])
def test_random_tracks(pos_x: int, pos_y: int, rounds: int, means: int) -> None:
    sim = load("array_merge", {
        "POS_X": pos_x, "POS_Y": pos_y, "ROUND": rounds, "RADIX_W": 4, "SUP_W": SUP_W, "ID_W": 8, "SLOT_W": 3, "MEANS": means,
    })  # fmt: skip
    latency = 2 * max(pos_x, pos_y) + 5 if means == 2 else 4 * max(pos_x, pos_y) + 10
    rng, io, saturated = np.random.default_rng(pos_x), sim.io, 0

    nobody = Track(7, 0, 0, 0, 15, 0)

    def clock(track: Track = nobody, before: Track = nobody, b_first: int | None = None, **takes: int) -> None:
        """One clock with where one track is, and the rest of the context of the one before."""
        io.take_a, io.take_b = takes.get("take_a", 0), takes.get("take_b", 0)
        io.cm_x, io.cm_y, io.g = track.cm_x, track.cm_y, track.g
        io.slot, io.id, io.support = before.slot, before.id, before.support
        io.b_first = rng.integers(2) if b_first is None else b_first
        sim.clock.tick()

    for _ in range(60):
        ids = rng.permutation(256)[:2]
        draws = rng.integers([0, 0, 0, 1], [1 << pos_x, 1 << pos_y, 16, 1 << SUP_W], (2, 4))
        a, b = (Track(i, int(ids[i]), *map(int, draws[i])) for i in range(2))
        clock(a, take_a=1)
        clock(b, a, take_b=1)
        clock(before=b)
        b_first = int(rng.integers(2))  # whatever the ids say
        clock(b_first=b_first)
        for _ in range(2):
            clock()
        older, younger = (b, a) if b_first else (a, b)
        both = a.support + b.support
        saturated += both >= 1 << SUP_W
        assert (io.stays, io.stays_id, io.goes) == (older.slot, older.id, younger.slot)
        assert (io.join_g, io.join_support) == (max(a.g, b.g), min(both, (1 << SUP_W) - 1))
        assert io.done == 0
        clocks = 4
        while not io.done and clocks < 200:
            clock()
            clocks += 1
        assert clocks == latency
        at_best = (Fraction(getattr(a, at) * a.support + getattr(b, at) * b.support, both) for at in ("cm_x", "cm_y"))
        assert (io.join_x, io.join_y) == tuple(floor(mean + Fraction(rounds, 2)) for mean in at_best)
        clock()
        assert io.done == 1
    assert 5 < saturated < 55


@pytest.mark.parametrize("means", [1, 2])
def test_a_merge_that_begins_before_another_one_is_done(means: int) -> None:
    """Only a reset makes room for it: the merge before goes on, and must not end this one, whenever this one begins."""
    sim = load("array_merge", {
        "POS_X": 5, "POS_Y": 4, "ROUND": 0, "RADIX_W": 4, "SUP_W": SUP_W, "ID_W": 8, "SLOT_W": 3, "MEANS": means,
    })  # fmt: skip
    io = sim.io

    def waits(clocks: int) -> None:
        for _ in range(clocks):
            sim.clock.tick()

    def takes(first: int, second: int) -> None:
        """Two slots, at 8 times their number, of which the second is the older one."""
        for take_a, take_b, slot, slot_before in ((1, 0, first, 0), (0, 1, second, first), (0, 0, 0, second)):
            io.take_a, io.take_b, io.cm_x, io.cm_y = take_a, take_b, 8 * slot, 4 * slot
            io.slot, io.support, io.b_first = slot_before, 1, 1
            waits(1)

    for clocks in range(4 * 5 + 10):
        takes(1, 2)
        waits(clocks)
        takes(1, 3)
        waits(3)
        assert (io.stays, io.goes, io.done) == (3, 1, 0)
        waits(4 * 5 + 10)
        assert (io.done, io.join_x, io.join_y) == (1, 16, 8)


FIELDS = ["tick", "event", "skip", "x", "y", "p"]
X_W, Y_W, TICK_W, CLOCK_W = 6, 5, 4, 12
PARAMETERS = {"X_W": X_W, "Y_W": Y_W, "TICK_W": TICK_W, "CLOCK_W": CLOCK_W}
PLACES = 16


@pytest.mark.parametrize("source", PATTERNS)
@pytest.mark.parametrize(("takes", "commits", "rewinds"), [(1.0, 1.0, 0.0), (0.9, 0.8, 0.05), (0.5, 0.2, 0.2), (1.0, 0.5, 0.4)])
def test_tokens_are_issued_in_order_from_the_first_that_is_not_committed(
    source: str, takes: float, commits: float, rewinds: float
) -> None:
    sim = load("array_input", PARAMETERS)
    io = sim.io
    io.s_valid = io.m_take = io.commit = io.rewind = 0
    reset(sim)
    rng = np.random.default_rng([6, int(10 * takes), int(10 * rewinds), list(PATTERNS).index(source)])
    limits = [1 << TICK_W, 2, 2, 1 << X_W, 1 << Y_W, 2]
    words = [tuple(word) for word in rng.integers(0, limits, (300, len(limits))).tolist()]
    times = [time % (1 << CLOCK_W) for time in accumulate(tick for tick, *_ in words)]
    offered = Source(sim, "s", FIELDS, words, PATTERNS[source](rng))
    issued = committed = again = 0
    rewound, waits = -9, False  # the clock of the last rewind; was there a token to come back to?

    def on_clock(clock: int) -> None:
        nonlocal issued, committed, again, rewound, waits
        assert io.empty == (offered.taken == committed)
        assert offered.taken - committed <= PLACES
        rests = clock == rewound + 1  # what stands on m_ was thrown out, and nobody is there to commit
        if clock == rewound + 3 and waits:
            assert io.m_valid == 1
        take = bool(io.m_valid) and not rests and rng.random() < takes
        commit = not rests and issued > committed and rng.random() < commits
        rewind = not rests and rng.random() < rewinds
        io.m_take, io.commit, io.rewind = take, commit, rewind
        committed += commit
        if take:
            _, event, skip, x, y, p = words[issued]
            assert (io.m_time, io.m_counts, io.m_event) == (times[issued], event | skip, event), (clock, issued)
            assert (io.m_x, io.m_y, io.m_p) == (x, y, p), (clock, issued)
            issued += 1
        if rewind:
            again += issued - committed
            issued, rewound, waits = committed, clock, offered.taken > committed

    run_streams(sim, [offered], [], on_clock=on_clock, quiet_clocks=400)
    assert (issued, committed, io.empty) == (len(words), len(words), 1)
    assert (again > 5) == (rewinds > 0)


def test_three_clocks_through_and_a_token_every_clock_until_all_places_are_taken() -> None:
    sim = load("array_input", PARAMETERS)
    io = sim.io
    reset(sim)
    sim.clock.tick()
    io.s_valid, io.s_event, io.m_take = 1, 1, 1
    valid, ready = [], []
    for clock in range(24):
        valid.append(int(io.m_valid))
        ready.append(int(io.s_ready))
        io.s_x = clock
        if valid[-1]:
            assert io.m_x == sum(valid) - 1
        sim.clock.tick()
    assert valid == [0] * 3 + [1] * PLACES + [0] * (21 - PLACES)
    assert ready == [1] * PLACES + [0] * (24 - PLACES)


OWNED, PASSED = ["slot", "x", "y", "p", "seq"], ["x", "y", "p", "seq"]
FLIGHT = 8  # events that may follow where there is no more room


@pytest.fixture(params=[(9, 6), (4, 7)], ids=["addresses wider", "recentred ones wider"])
def sim(request: pytest.FixtureRequest) -> PyVerilator:
    x_w, rel_w = request.param
    sim = load("array_output", {"X_W": x_w, "Y_W": x_w - 1, "REL_W": rel_w, "SEQ_W": 16, "SLOT_W": 3})
    sim.limits = [2, 8, 1 << rel_w, 1 << rel_w, 1 << x_w, 1 << x_w - 1, 2]
    sim.io.s_valid = 0
    reset(sim)
    return sim


def offer(sim: PyVerilator, event: Word, seq: int) -> None:
    io = sim.io
    io.s_valid, io.s_seq = 1, seq
    io.s_owned, io.s_slot, io.s_rel_x, io.s_rel_y, io.s_x, io.s_y, io.s_p = event


@pytest.mark.parametrize(("owned", "passed"), list(product(PATTERNS, repeat=2)))
def test_every_event_comes_in_its_order_at_its_output(sim: PyVerilator, owned: str, passed: str) -> None:
    rng = np.random.default_rng([4, list(PATTERNS).index(owned), list(PATTERNS).index(passed)])
    events = [tuple(event) for event in rng.integers(0, sim.limits, (150, len(sim.limits))).tolist()]
    own = Sink(sim, "m_own", OWNED, PATTERNS[owned](rng))
    passes = Sink(sim, "m_pass", PASSED, PATTERNS[passed](rng))
    flying, sent, full = deque([False] * FLIGHT), 0, 0

    def on_clock(_clock: int) -> None:
        nonlocal sent, full
        flying.append(bool(sim.io.room) and rng.random() < 0.9)
        full += not sim.io.room
        sim.io.s_valid = 0
        if flying.popleft() and sent < len(events):
            offer(sim, events[sent], sent)
            sent += 1

    run_streams(sim, [], [own, passes], on_clock=on_clock, quiet_clocks=40)
    numbered = [(*event, seq) for seq, event in enumerate(events)]
    assert own.words == [(slot, x, y, p, seq) for is_owned, slot, x, y, _, _, p, seq in numbered if is_owned]
    assert passes.words == [(x, y, p, seq) for is_owned, _, _, _, x, y, p, seq in numbered if not is_owned]
    taken = sorted(zip(own.clocks + passes.clocks, (word[-1] for word in own.words + passes.words), strict=True))
    assert [seq for _, seq in taken] == list(range(len(events)))
    assert len({clock for clock, _ in taken}) == len(events), "one after the other"
    assert full > 0 or (owned, passed) == ("always", "always")
    assert (sim.io.empty, sim.io.room) == (1, 1)


def test_an_event_takes_three_clocks_and_one_follows_every_clock(sim: PyVerilator) -> None:
    sinks = [Sink(sim, "m_own", OWNED, always()), Sink(sim, "m_pass", PASSED, always())]

    def on_clock(clock: int) -> None:
        sim.io.s_valid = 0
        if clock < 30:
            offer(sim, (clock % 3 == 0, 0, 1, 2, 3, 4, 1), clock)
        assert sim.io.room == 1

    run_streams(sim, [], sinks, on_clock=on_clock)
    assert sorted(sinks[0].clocks + sinks[1].clocks) == list(range(3, 33))


def test_without_being_asked_eight_more_find_a_place(sim: PyVerilator) -> None:
    io, sent, after = sim.io, 0, 0
    io.m_own_ready = io.m_pass_ready = 0
    while after < FLIGHT:
        after += not io.room
        offer(sim, (1, 0, 0, 0, 0, 0, 0), sent)
        sim.clock.tick()
        sent += 1
    io.s_valid = 0
    sink = Sink(sim, "m_own", OWNED, always())
    run_streams(sim, [], [sink])
    assert [word[-1] for word in sink.words] == list(range(sent))


@pytest.mark.parametrize("owned", [0, 1])
def test_it_is_empty_before_its_first_event_and_after_its_last_was_taken(sim: PyVerilator, owned: int) -> None:
    io = sim.io
    ready = "m_own_ready" if owned else "m_pass_ready"
    io.m_own_ready = io.m_pass_ready = 0
    assert io.empty == 1
    offer(sim, (owned, 0, 1, 2, 3, 4, 1), 0)
    empty = []
    for clock in range(9):
        sim.clock.tick()
        io.s_valid = 0
        io[ready] = int(clock >= 5)
        empty.append(int(io.empty))
    assert empty == [0] * 6 + [1] * 3

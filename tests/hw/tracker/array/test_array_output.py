# SPDX-License-Identifier: Apache-2.0
"""array_output.v: decided events in their order, each to its output, and free space reported in time."""

from __future__ import annotations

from collections import deque
from itertools import product

import numpy as np
import pytest
from pyverilator import PyVerilator

from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load
from support.testing import PATTERNS, Sink, Word, always, lint, run_streams

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


@pytest.mark.parametrize(("x_w", "rel_w", "slot_w"), [(1, 3, 1), (9, 10, 3), (16, 4, 6)])
def test_lints_clean(x_w: int, rel_w: int, slot_w: int) -> None:
    assert lint("array_output", X_W=x_w, Y_W=x_w, REL_W=rel_w, SLOT_W=slot_w) == (0, "")

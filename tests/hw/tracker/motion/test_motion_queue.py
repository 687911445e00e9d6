# SPDX-License-Identifier: Apache-2.0
"""motion_queue.v: tokens come out in order with their time; it is known whether a step or an effect comes before them."""

from __future__ import annotations

import numpy as np
import pytest
from pyverilator import PyVerilator

from evcot_cosim.rtl.build import PORTS_ONLY_FLAGS, load
from support.testing import PATTERNS

X_W, Y_W, TICK_W, TIME_W, DUE_W = 5, 4, 6, 24, 14
FAR = 256
FIELDS = ("event", "skip", "x", "y", "p")
WIDTHS = (1, 1, X_W, Y_W, 1)
LATENCY, HELD = 5, 17


def model() -> PyVerilator:
    widths = {"X_W": X_W, "Y_W": Y_W, "TICK_W": TICK_W, "TIME_W": TIME_W, "DUE_W": DUE_W}
    sim = load("motion_queue", widths, extra_flags=PORTS_ONLY_FLAGS)
    sim.io.rst = sim.io.opens = 1
    sim.clock.tick()
    sim.io.rst = 0
    return sim


@pytest.mark.parametrize("pattern", PATTERNS)
def test_random_tokens_and_steps(pattern: str) -> None:
    """A step, or the end of a life, begins whenever no token is taken; the next step is another one from its first clock on."""
    sim, rng = model(), np.random.default_rng(1)
    io, offers, takes = sim.io, PATTERNS[pattern](rng), PATTERNS["bursts" if pattern == "often" else "often"](rng)
    waiting: list[tuple[int, ...]] = []  # time and fields of tokens inside
    time = taken = steps = full = passed = now = 0  # passed: the time of the last token that was taken
    due, late, far = {True: 0, False: 0}, {True: 0, False: 0}, {True: 0, False: 0}
    due_tick, latest, in_burst = 0, list[int](), {True: 0, False: 0}  # times of the last 16 events
    offered: tuple[int, ...] | None = None
    next_step, hold, write_in = 40, 0, 0  # hold: clocks until it is over; write_in: until another length of a step counts
    for clock in range(5_000):
        together = clock % 500 < 200
        io.s_valid = int(offered is not None or next(offers))
        if io.s_valid and offered is None:
            tick = 0 if together else int(rng.integers(1 << TICK_W))
            offered = (tick, *(int(rng.integers(1 << bits)) for bits in WIDTHS))
            for name, value in zip(("tick", *FIELDS), offered, strict=True):
                setattr(io, f"s_{name}", value)
        if write_in == 1:
            next_step = time + int(rng.integers(200))
        write_in = max(write_in - 1, 0)
        io.next_step, io.holds, io.m_ready = next_step % (1 << TIME_W), int(hold > 0), 0
        assert int(io.empty) == (not waiting)
        accepted = bool(int(io.s_valid)) and bool(int(io.s_ready))
        begins = False
        assert int(io.m_runs) <= int(io.m_valid)
        if int(io.m_valid):
            assert (int(io.m_time), *(int(getattr(io, f"m_{name}")) for name in (*FIELDS, "burst"))) == waiting[0]
            in_burst[bool(waiting[0][-1])] += 1
            is_late, is_far = waiting[0][0] >= due_tick, waiting[0][0] - now >= FAR  # those of the clock before
            assert (int(io.m_late), int(io.m_far)) == (is_late, is_far)
            late[is_late] += 1
            far[is_far] += 1
            if hold == 0:
                is_due = waiting[0][0] >= next_step
                assert (int(io.m_due), int(io.m_runs)) == (is_due, not is_due)
                due[is_due] += 1
                begins = rng.random() < (0.3 if is_due else 0.02)
                io.m_ready = int(not begins and not is_due and next(takes))
        elif hold == 0:
            begins = write_in == 0 and rng.random() < 0.03
            if not waiting and not accepted and rng.random() < 0.1:
                write_in = 4  # the register is written in this clock, and a token may come in the next one: see motion_turn.v
        if int(io.m_ready):
            passed = waiting.pop(0)[0]
            taken += 1
        full += len(waiting) >= 12
        assert len(waiting) <= HELD
        hold = max(hold - 1, 0)
        now, due_tick = max(passed - int(rng.integers(300)), 0), passed + int(rng.integers(-20, 80))
        io.now, io.due_tick = now, due_tick % (1 << DUE_W)
        sim.clock.tick()
        if begins:
            hold, steps = int(rng.integers(3, 9)), steps + 1
            next_step += int(rng.choice([0, 100, 500])) if next_step < time + 2_000 else 0
        if accepted and offered is not None:
            time += offered[0]
            waiting.append((time, *offered[1:], int(latest == [time] * 16)))
            if offered[1]:
                latest = [*latest, time][-16:]
            offered = None
    assert 1 << DUE_W < time < 1 << TIME_W
    assert taken > 500
    assert steps > 50
    assert min(*due.values(), *late.values(), *far.values(), *in_burst.values()) > 50
    assert full > 50 or pattern == "rarely"


def test_a_token_a_clock_and_what_is_held() -> None:
    sim = model()
    io = sim.io
    sim.clock.tick()
    io.next_step, io.s_valid, io.m_ready = 1 << DUE_W - 2, 1, 1
    valid = []
    for x in range(40):
        io.s_x = x % (1 << X_W)
        assert int(io.s_ready)
        sim.clock.tick()
        valid.append(int(io.m_valid))
        if valid[-1]:
            assert int(io.m_x) == (x - LATENCY + 1) % (1 << X_W)
    assert valid == [0] * (LATENCY - 1) + [1] * (40 - LATENCY + 1)
    io.m_ready, held = 0, LATENCY
    while int(io.s_ready):
        sim.clock.tick()
        held += 1
    assert held == HELD
    io.s_valid = 0
    io.m_ready, out = 1, 0
    while int(io.m_valid):
        out += 1
        sim.clock.tick()
    assert (out, int(io.empty)) == (held, 1)
    for opens in (0, 1):
        io.opens = opens
        sim.clock.tick()
        assert int(io.s_ready) == opens


def test_events_are_within_a_burst_from_the_17th_of_a_tick_on() -> None:
    sim = model()
    io = sim.io
    sim.clock.tick()

    def bursts(ticks: list[int], event: int = 1) -> list[int]:
        """Of the tokens that come so many ticks after the one before."""
        io.next_step, io.m_ready, io.s_event, found = 1 << DUE_W - 2, 1, event, []
        for tick in [*ticks, *[0] * LATENCY]:
            io.s_valid, io.s_tick = int(len(found) < len(ticks)), tick
            found.append(0)
            sim.clock.tick()
            if int(io.m_valid):
                found[-1 - LATENCY + 1] = int(io.m_burst)
        io.s_valid = 0
        return found[: len(ticks)]

    assert bursts([0] * 19) == [0] * 16 + [1] * 3
    assert bursts([0], event=0) == [1]
    assert bursts([1, *[0] * 9]) == [0] * 10
    assert bursts([0] * 9, event=0) == [0] * 9
    assert bursts([0] * 7) == [0] * 6 + [1]
    assert bursts([3], event=0) == [0]
    assert bursts([0] * 17) == [0] * 16 + [1]
    io.rst = 1
    sim.clock.tick()
    io.rst = 0
    sim.clock.tick()
    assert bursts([0] * 17) == [0] * 16 + [1]


def test_reset_empties_it_and_time_begins_anew() -> None:
    sim = model()
    io = sim.io
    sim.clock.tick()
    io.s_valid, io.s_tick, io.next_step = 1, 50, 120
    for tokens in range(1, 9):
        for _clock in range(tokens):
            sim.clock.tick()
        io.rst = 1
        sim.clock.tick()
        io.rst, io.s_valid = 0, 0
        assert int(io.empty)
        assert not int(io.s_ready)
        for _clock in range(LATENCY):
            assert not int(io.m_valid)
            sim.clock.tick()
        io.s_valid, io.m_ready = 1, 0
        while not int(io.m_valid):
            sim.clock.tick()
        assert (int(io.m_time), int(io.m_due)) == (50, 0)
        io.m_ready = 1
        sim.clock.tick()
        sim.clock.tick()
        assert (int(io.m_time), int(io.m_due)) == (150, 1)

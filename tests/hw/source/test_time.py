# SPDX-License-Identifier: Apache-2.0
"""The modules of time: microseconds from clocks, time marks, prescaler, splitter of ticks."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from pyverilator import PyVerilator

from evcot.recordings.formats.words import advance
from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load
from support.stream_device import StreamDevice, check_reset, random_stalls
from support.tokens import TOKENS_IN, TOKENS_OUT


def test_microseconds() -> None:
    sim = load("clock_us", {"T_W": 5, "PRESCALE_W": 3})
    for clocks_per_us in (3, 1, 7):
        sim.io.clocks_per_us = clocks_per_us
        reset(sim)
        for clock in range(40 * clocks_per_us):
            assert sim.io.t_us == clock // clocks_per_us % 32
            sim.clock.tick()
    assert sim.io.t_us == 40 % 32
    sim.io.clocks_per_us = 0
    for _ in range(20):
        sim.clock.tick()
        assert sim.io.t_us == 40 % 32


TOP = "time_mark"


@pytest.mark.parametrize("mark_w", [3, 12])
def test_any_mark_after_any_mark(mark_w: int) -> None:
    """8 steps to every side of all steps that matter: none, half a turn and a whole one."""
    sim = load(TOP, {"MARK_W": mark_w, "HIGH_W": 24})
    reset(sim)
    assert (sim.io.known, sim.io.high) == (0, 0)
    rng, size, high = np.random.default_rng(5), 1 << mark_w, -1
    for _ in range(5_000):
        step = int(rng.choice([0, size // 2, rng.integers(size)])) + int(rng.integers(-8, 9))
        mark, is_set = (max(high, 0) + step) % size, int(rng.random() < 0.9)
        sim.io.set, sim.io.mark = is_set, mark
        assert sim.io.differs == (high < 0 or mark != high % size)
        sim.clock.tick()
        high = int(advance(high, mark, size)) if is_set else high
        assert (sim.io.known, sim.io.high) == (high >= 0, max(high, 0) % (1 << 24))
    assert high > 100 * size
    reset(sim)
    assert (sim.io.known, sim.io.high) == (0, 0)


def pulses(sim: PyVerilator, clocks: int) -> list[int]:
    """The clocks, counted from now, at which there is a pulse."""
    seen = []
    for clock in range(clocks):
        if sim.io.pulse:
            seen.append(clock)
        sim.clock.tick()
    return seen


@pytest.mark.parametrize("period", [1, 2, 7, 15])
def test_a_pulse_every_period(period: int) -> None:
    sim = load("prescaler", {"W": 4})
    sim.io.period = period
    reset(sim)
    assert pulses(sim, 100) == list(range(period - 1, 100, period))
    reset(sim)
    assert pulses(sim, 100) == list(range(period - 1, 100, period))


def test_a_new_period_counts_from_the_last_pulse() -> None:
    sim = load("prescaler", {"W": 4})
    sim.io.period = 12
    reset(sim)
    assert pulses(sim, 9) == []
    sim.io.period = 10
    assert pulses(sim, 8) == [1]
    sim.io.period = 3
    assert pulses(sim, 7) == [1, 4]
    sim.io.period = 0
    assert pulses(sim, 40) == [0]
    sim.io.period = 5
    assert pulses(sim, 10) == [4, 9]


TICK_SPLITTER_TOP = "tick_splitter"


def device_of(wide_w: int, tick_w: int) -> StreamDevice:
    parameters = {"WIDE_W": wide_w, "TICK_W": tick_w, "X_W": 8, "Y_W": 7}
    return StreamDevice(TICK_SPLITTER_TOP, parameters, inputs=[TOKENS_IN], outputs=[TOKENS_OUT], has_idle=True)


def split(wide: NDArray[np.uint64], tick_w: int) -> NDArray[np.uint64]:
    """Of ticks that do not fit, halves of the range go ahead, without event."""
    half = 1 << tick_w - 1
    tick = wide[:, 0].astype(np.int64)
    ahead = np.where(tick < 2 * half, 0, tick // half - 1)
    index = np.repeat(np.arange(len(wide)), ahead + 1)
    last = np.cumsum(ahead + 1) - 1
    tokens = wide[index]
    tokens[:, 0] = half
    tokens[last, 0] = tick - half * ahead
    tokens[np.setdiff1d(np.arange(len(tokens)), last), 1:3] = 0
    return tokens


def test_what_does_not_fit_goes_ahead_in_halves() -> None:
    run = device_of(16, 8).run({"s_": [[255, 1, 0, 1, 2, 1], [256, 1, 0, 3, 4, 0], [520, 0, 1, 5, 6, 0]]})
    assert run.words["m_"][:, :3].tolist() == [
        [255, 1, 0], [128, 0, 0], [128, 1, 0], [128, 0, 0], [128, 0, 0], [128, 0, 0], [136, 0, 1],
    ]  # fmt: skip


def test_reset_amid_tokens_leaves_nothing() -> None:
    check_reset(device_of(16, 8), {"s_": [[520, 1, 0, 1, 2, 1], [0, 0, 1, 3, 4, 0]] * 30})


@pytest.mark.parametrize(("wide_w", "tick_w"), [(20, 20), (12, 1), (48, 32)])
def test_random_tokens(wide_w: int, tick_w: int) -> None:
    device = device_of(wide_w, tick_w)
    for run in range(3):
        rng = np.random.default_rng([91, wide_w, run])
        device.stalls = random_stalls(rng, ("s_", "m_"))
        n, longest = 20_000, min(wide_w, tick_w + 6)
        wait = (2 ** rng.uniform(0, longest, n)).astype(np.int64) - 1
        wait[rng.random(n) < 0.3] = 0
        wait[rng.random(n) < 0.1] = (1 << tick_w) - 1
        x, y = rng.integers(0, 256, n).astype(np.uint16), rng.integers(0, 128, n).astype(np.uint16)
        kind, p = rng.integers(0, 3, n), rng.integers(0, 2, n).astype(np.uint8)
        wide = np.stack([wait, kind == 1, kind == 2, x, y, p], axis=1).astype(np.uint64)
        assert np.array_equal(device.run({"s_": wide}).words["m_"], split(wide, tick_w))


def test_clocks() -> None:
    """A token every clock, 2 clocks later."""
    device = device_of(48, 32)
    run = device.run({"s_": [[9, 1, 0, 1, 2, 1]] * 50})
    assert run.accepted["s_"].tolist() == list(range(50))
    assert run.given["m_"].tolist() == list(range(2, 52))

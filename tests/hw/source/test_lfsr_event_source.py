# SPDX-License-Identifier: Apache-2.0
"""lfsr_event_source.v against its twin: the same events under any stalls."""

from __future__ import annotations

import numpy as np
import pytest
from pyverilator import PyVerilator

from evcot.hardware.lfsr_event_source import LfsrEventSource
from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load
from support.testing import PATTERNS, Sink, Word, always, run_streams

FIELDS = ["x", "y", "p"]
TWINS = {
    "whole sensor, every clock": LfsrEventSource(0, 511, 0, 511, seed=0x1234_5678),
    "odd window, fresh bits": LfsrEventSource(100, 200, 37, 4, gap=18, seed=0xCAFE_F00D),
    "one pixel": LfsrEventSource(511, 0, 0, 0, gap=3),
    "narrowest": LfsrEventSource(0, 1, 1, 0, gap=1, seed=5, x_w=1, y_w=1, gap_w=1, lfsr_w=3),
}


def started(twin: LfsrEventSource) -> PyVerilator:
    """The module in the twin's place, seed loaded, not yet enabled."""
    sim = load("lfsr_event_source", {"X_W": twin.x_w, "Y_W": twin.y_w, "GAP_W": twin.gap_w, "LFSR_W": twin.lfsr_w})
    reset(sim)
    for port in ("gap", "x_min", "x_span", "y_min", "y_span"):
        sim.io[port] = getattr(twin, port)
    load_seed(sim, twin.seed)
    return sim


def load_seed(sim: PyVerilator, seed: int) -> None:
    sim.io.load, sim.io.seed = 1, seed
    sim.clock.tick()
    sim.io.load = 0


def expected(twin: LfsrEventSource, count: int) -> list[Word]:
    events = twin.events(count)
    return list(zip(events.x.tolist(), events.y.tolist(), events.p.tolist(), strict=True))


def collect(sim: PyVerilator, sink: Sink, count: int) -> None:
    """Runs until the sink has `count` events or more, then closes the source and empties it."""
    sim.io.enable = 1

    def close(_clock: int) -> None:
        sim.io.enable = int(len(sink.words) < count)

    run_streams(sim, [], [sink], quiet_clocks=200, on_clock=close)


@pytest.mark.parametrize("name", TWINS)
def test_an_event_appears_one_clock_after_its_step(name: str) -> None:
    """Without stalls the LFSR steps once per clock, so the twin's step numbers are clocks."""
    twin = TWINS[name]
    sim = started(twin)
    sink = Sink(sim, "m", FIELDS, always())
    collect(sim, sink, 100)
    assert sink.words[:100] == expected(twin, 100)
    assert sink.clocks[:100] == (twin.events(100).t_us + 1).tolist()


@pytest.mark.parametrize("stall", PATTERNS)
@pytest.mark.parametrize("name", TWINS)
def test_stalls_do_not_change_the_events(name: str, stall: str) -> None:
    sim, twin = started(TWINS[name]), TWINS[name]
    sink = Sink(sim, "m", FIELDS, PATTERNS[stall](np.random.default_rng(6)))
    collect(sim, sink, 200)
    assert len(sink.words) >= 200
    assert sink.words == expected(twin, len(sink.words))


def test_enable_pauses_and_resumes_the_sequence() -> None:
    twin = TWINS["odd window, fresh bits"]
    sim = started(twin)
    sink = Sink(sim, "m", FIELDS, always())
    for count in (7, 20, 60):
        collect(sim, sink, count)
    assert sink.words == expected(twin, len(sink.words))


def test_a_seed_restarts_the_sequence_and_spares_the_event_on_offer() -> None:
    twin = TWINS["odd window, fresh bits"]
    sim = started(twin)
    sim.io.enable = 1
    while not sim.io.m_valid:
        sim.clock.tick()
    load_seed(sim, twin.seed)
    sink = Sink(sim, "m", FIELDS, always())
    collect(sim, sink, 30)
    assert sink.words == expected(twin, 1) + expected(twin, len(sink.words) - 1)


def test_a_seed_restarts_the_gap() -> None:
    twin = TWINS["odd window, fresh bits"]
    sim = started(twin)
    sim.io.enable = 1
    for _ in range(twin.gap // 2):
        sim.clock.tick()
    load_seed(sim, twin.seed)
    sink = Sink(sim, "m", FIELDS, always())
    collect(sim, sink, 30)
    assert sink.words == expected(twin, len(sink.words))


def test_the_lock_up_seed_is_refused_and_costs_clocks_only() -> None:
    twin = TWINS["odd window, fresh bits"]
    sim = started(twin)
    sim.io.enable = 1
    for _ in range(twin.gap // 2):
        sim.clock.tick()
    sim.io.load, sim.io.seed = 1, 0xFFFF_FFFF
    for _ in range(twin.gap):
        assert (sim.io.seed_error, sim.io.m_valid) == (1, 0)
        sim.clock.tick()
    sim.io.load = 0
    assert sim.io.seed_error == 0
    sink = Sink(sim, "m", FIELDS, always())
    collect(sim, sink, 30)
    assert sink.words == expected(twin, len(sink.words))


def test_reset_withdraws_the_event_and_starts_from_zero() -> None:
    twin = TWINS["one pixel"]
    sim = started(twin)
    sim.io.enable = 1
    for _ in range(10):
        sim.clock.tick()
    assert sim.io.m_valid == 1
    reset(sim)
    assert sim.io.m_valid == 0
    sink = Sink(sim, "m", FIELDS, always())
    collect(sim, sink, 30)
    assert sink.words == expected(twin, len(sink.words))

# SPDX-License-Identifier: Apache-2.0
"""stream_arbiter.v with five streams and with one."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from pyverilator import PyVerilator

from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load
from support.testing import PATTERNS, Sink, Source, Word, always, run_streams

W = 12
INDEX_SHIFT = 9


class Lane(Source):
    """Drives one stream of the flattened bundle; its words carry the stream's index and a count."""

    def __init__(self, sim: PyVerilator, index: int, count: int, pattern: Iterator[bool]) -> None:
        words = [(index << INDEX_SHIFT | k,) for k in range(count)]
        super().__init__(sim, "s", ["data"], words, pattern, np.random.default_rng(index))
        self.index = index

    def ready(self) -> bool:
        return bool(self.sim.io.s_ready >> self.index & 1)

    def put(self, valid: bool, word: Word | None) -> None:
        data = self.random_bits("s_data") & ((1 << W) - 1) if word is None else word[0]
        shift = self.index * W
        self.sim.io.s_valid = self.sim.io.s_valid & ~(1 << self.index) | int(valid) << self.index
        self.sim.io.s_data = self.sim.io.s_data & ~(((1 << W) - 1) << shift) | data << shift


def arbiter(n: int) -> PyVerilator:
    sim = load("stream_arbiter", {"N": n, "W": W})
    reset(sim)
    return sim


def indices(sink: Sink) -> list[int]:
    return [word >> INDEX_SHIFT for (word,) in sink.words]


def test_waiting_streams_take_turns_a_word_every_clock() -> None:
    sim = arbiter(5)
    sink = Sink(sim, "m", ["data"], always())
    run_streams(sim, [Lane(sim, i, 4, always()) for i in range(5)], [sink])
    assert indices(sink) == [0, 1, 2, 3, 4] * 4
    assert sink.clocks == list(range(2, 22))


def test_an_idle_stream_costs_no_turn() -> None:
    sim = arbiter(5)
    sink = Sink(sim, "m", ["data"], always())
    run_streams(sim, [Lane(sim, i, 4, always()) for i in (1, 3)], [sink])
    assert indices(sink) == [1, 3] * 4
    assert sink.clocks == list(range(2, 10))


def test_a_single_stream_has_every_second_clock() -> None:
    sim = arbiter(5)
    sink = Sink(sim, "m", ["data"], always())
    run_streams(sim, [Lane(sim, 1, 4, always())], [sink])
    assert sink.clocks == [2, 4, 6, 8]


def test_the_turn_outlives_a_pause() -> None:
    sim = arbiter(5)
    sink = Sink(sim, "m", ["data"], always())
    run_streams(sim, [Lane(sim, 2, 1, always())], [sink])
    run_streams(sim, [Lane(sim, i, 1, always()) for i in range(5)], [sink])
    assert indices(sink) == [2, 3, 4, 0, 1, 2]


def test_reset_empties_it_and_starts_again_with_stream_0() -> None:
    sim = arbiter(3)
    sim.io.s_valid = 0b111
    for _ in range(2):
        sim.clock.tick()
    assert (sim.io.m_valid, sim.io.s_ready) == (1, 0b001)  # the word of stream 0 has moved on, and makes room for another
    sim.io.s_valid = 0
    reset(sim)
    assert (sim.io.m_valid, sim.io.s_ready) == (0, 0b111)
    sink = Sink(sim, "m", ["data"], always())
    run_streams(sim, [Lane(sim, i, 1, always()) for i in range(3)], [sink])
    assert indices(sink) == [0, 1, 2]


@pytest.mark.parametrize("stall", PATTERNS)
@pytest.mark.parametrize("idle", PATTERNS)
@pytest.mark.parametrize("n", [1, 5])
def test_traffic_keeps_its_order_and_nobody_waits_too_long(n: int, idle: str, stall: str) -> None:
    sim = arbiter(n)
    rng = np.random.default_rng(5)
    count = 60
    lanes = [Lane(sim, i, count, PATTERNS[idle](rng)) for i in range(n)]
    sink = Sink(sim, "m", ["data"], PATTERNS[stall](rng))
    left_before: dict[int, int] = {}  # word -> words that had left when it was taken

    def note(_clock: int) -> None:
        for lane in lanes:
            if lane.taken:
                left_before.setdefault(lane.index << INDEX_SHIFT | lane.taken - 1, len(sink.words))

    run_streams(sim, lanes, [sink], on_clock=note)
    # Before a word leaves: one that has had its turn, and one of each other stream.
    assert all(at - left_before[word] <= n for at, (word,) in enumerate(sink.words))
    sent = {i: [i << INDEX_SHIFT | k for k in range(count)] for i in range(n)}
    assert {i: [word for (word,) in sink.words if word >> INDEX_SHIFT == i] for i in range(n)} == sent


@pytest.fixture
def sim() -> PyVerilator:
    sim = load("token_gate", {"SEQ_W": 48})
    reset(sim)
    sim.io.idle = 1
    sim.clock.tick()
    return sim


def clocks_until_open(sim: PyVerilator, most: int = 20) -> int:
    for clock in range(most):
        if sim.io.open:
            return clock
        sim.clock.tick()
    return most


def test_is_closed_after_reset_and_opens_when_enabled(sim: PyVerilator) -> None:
    assert clocks_until_open(sim) == 20
    sim.io.enable = 1
    assert clocks_until_open(sim) == 1
    sim.io.enable = 0
    sim.clock.tick()
    assert sim.io.open == 0


def test_opens_after_reset_only_when_all_behind_it_has_been_idle_once() -> None:
    sim = load("token_gate")
    reset(sim)
    sim.io.enable = 1
    assert (clocks_until_open(sim), sim.io.cleared) == (20, 0)
    sim.io.idle = 1
    assert clocks_until_open(sim) == 2
    sim.io.idle = 0
    sim.clock.tick()
    assert (sim.io.open, sim.io.cleared) == (1, 1)
    reset(sim)
    assert (sim.io.open, sim.io.cleared) == (0, 0)


def test_a_closed_gate_lets_nothing_through_either_way(sim: PyVerilator) -> None:
    sim.io.s_valid = sim.io.m_ready = 1
    assert (sim.io.m_valid, sim.io.s_ready) == (0, 0)
    sim.io.enable = 1
    sim.clock.tick()
    assert (sim.io.m_valid, sim.io.s_ready) == (1, 1)


def test_a_token_on_offer_is_not_taken_back(sim: PyVerilator) -> None:
    sim.io.enable = sim.io.s_valid = 1
    sim.clock.tick()
    sim.io.busy = 1
    for _ in range(5):
        sim.clock.tick()
        assert (sim.io.m_valid, sim.io.apply) == (1, 0)
    sim.io.m_ready = 1
    sim.clock.tick()
    assert (sim.io.m_valid, sim.io.open, sim.io.apply) == (0, 0, 1)


def test_registers_may_be_written_when_closed_and_idle(sim: PyVerilator) -> None:
    sim.io.enable = sim.io.busy = 1
    sim.io.idle = 0
    for _ in range(3):
        sim.clock.tick()
        assert sim.io.apply == 0
    sim.io.idle = 1
    assert sim.io.apply == 1


def test_opens_when_the_consequences_of_a_write_are_over(sim: PyVerilator) -> None:
    sim.io.enable = sim.io.busy = 1
    sim.clock.tick()
    sim.io.busy = 0
    assert clocks_until_open(sim) == 4
    sim.io.busy = 1
    sim.clock.tick()
    sim.io.busy = sim.io.idle = 0  # a life ends, say
    assert clocks_until_open(sim) == 20
    sim.io.idle = 1
    assert clocks_until_open(sim) == 2


def test_numbers_the_events_that_went_through(sim: PyVerilator) -> None:
    rng = np.random.default_rng(2)
    sim.io.enable = 1
    through = 0
    for _ in range(400):
        sim.io.s_valid, sim.io.s_counts, sim.io.m_ready = (int(bit) for bit in rng.integers(0, 2, 3))
        sim.io.busy = int(rng.random() < 0.1)
        assert sim.io.seq == through
        through += int(sim.io.m_valid and sim.io.m_ready and sim.io.s_counts)
        sim.clock.tick()
    assert through > 20


def test_a_word_that_comes_while_the_output_waits_follows_at_once() -> None:
    sim, given = arbiter(3), []
    sim.io.m_ready = 0
    for stream in (0, 2):
        sim.io.s_valid, sim.io.s_data = 1 << stream, (stream + 1) << stream * W
        sim.clock.tick()
        sim.io.s_valid = 0
        for _ in range(4):
            sim.clock.tick()
    sim.io.m_ready = 1
    for _ in range(3):
        given.append((int(sim.io.m_valid), int(sim.io.m_data)))
        sim.clock.tick()
    assert [valid for valid, _ in given] == [1, 1, 0]
    assert [data for _, data in given[:2]] == [1, 3]

# SPDX-License-Identifier: Apache-2.0
"""published_line.v: two clocks to a word, four to its acknowledge, and a waiting word gives way to one of higher rank."""

from __future__ import annotations

import numpy as np
import pytest
from pyverilator import PyVerilator

from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load
from support.published_text import library_line
from support.testing import lint

TOP = "published_line"
N, W = 3, 8


@pytest.mark.parametrize("n", [1, 2, 8, 64])
def test_lints_clean(n: int) -> None:
    assert lint(TOP, N=n) == (0, "")


@pytest.mark.parametrize(
    ("parameters", "rule"),
    [
        ({"N": 0}, "N_must_be_1_to_64"),
        ({"N": 65}, "N_must_be_1_to_64"),
        ({"W": 0}, "W_must_be_at_least_1"),
        ({"INDEX_W": 4}, "INDEX_W_must_be_left_at_its_default"),
    ],
)
def test_refuses_parameters(parameters: dict[str, int], rule: str) -> None:
    code, log = lint(TOP, **parameters)
    assert code != 0
    assert rule in log


@pytest.fixture
def sim() -> PyVerilator:
    """Nobody requests; each sender's word is its number, twice."""
    line = load(TOP, {"N": N, "W": W})
    line.io.s_req_n = 0b111
    line.io.m_ack_n = 1
    line.io.s_word = 0x221100
    reset(line)
    return line


def clocks(sim: PyVerilator, requests: list[int], acks: list[int]) -> list[tuple[int | None, int]]:
    """(word or None, acknowledges) in each clock, for the senders' requests and the receiver's acknowledges."""
    told = []
    for request, ack in zip(requests, acks, strict=True):
        sim.io.s_req_n, sim.io.m_ack_n = request, ack
        told.append((None if sim.io.m_req_n else int(sim.io.m_word), int(sim.io.s_ack_n)))
        sim.clock.tick()
    return told


class TestStories:
    def test_a_word_appears_after_2_clocks_its_acknowledge_after_4_and_the_next_word_after_6(self, sim: PyVerilator) -> None:
        told = clocks(sim, [0b101] * 5 + [0b111] + [0b110] * 6, [1, 1, 0, 0, 1, 1, 1, 1, 0, 0, 1, 1])
        words = [word for word, _ in told]
        assert words == [None, None, 0x11, 0x11, None, None, None, None, 0x00, 0x00, None, None]
        assert [ack for _, ack in told] == [0b111] * 4 + [0b101] * 3 + [0b111] * 3 + [0b110] * 2

    def test_its_request_lasts_one_clock_beyond_that_of_the_acknowledge(self, sim: PyVerilator) -> None:
        for wait in (0, 1, 7):
            told = clocks(sim, [0b101] * (5 + wait) + [0b111] * 3, [1] * (2 + wait) + [0] * 2 + [1] * 4)
            assert [word for word, _ in told] == [None] * 2 + [0x11] * (wait + 2) + [None] * 4

    def test_the_word_is_all_ones_while_it_is_idle(self, sim: PyVerilator) -> None:
        words = []
        for request, ack in zip([0b111] * 2 + [0b101] * 5 + [0b111] * 4, [1] * 4 + [0] * 2 + [1] * 5, strict=True):
            sim.io.s_req_n, sim.io.m_ack_n = request, ack
            words.append(int(sim.io.m_word))
            sim.clock.tick()
        # Requested in clock 2, sent in 4, acknowledged in 4; idle from clock 8 on, which is seen in the one after.
        assert words == [0xFF] * 4 + [0x11] * 5 + [0xFF] * 2

    def test_a_word_that_waits_gives_way_to_a_higher_rank_and_comes_later(self, sim: PyVerilator) -> None:
        told = clocks(sim, [0b011] * 4 + [0b010] * 5 + [0b011] * 6, [1] * 6 + [0, 0] + [1] * 5 + [0, 0])
        words = [word for word, _ in told]
        assert words[2:8] == [0x22, 0x22, 0x22, 0x00, 0x00, 0x00]
        assert [ack for _, ack in told][8] == 0b110
        assert words[8:] == [None] * 4 + [0x22] * 3

    def test_a_word_is_replaced_in_the_clock_of_its_acknowledge_and_comes_again_later(self, sim: PyVerilator) -> None:
        # The acknowledge of 0x22 in clock 2 goes to sender 0, which asks from that clock on.
        told = clocks(sim, [0b011] * 2 + [0b010] * 3 + [0b011] * 6, [1, 1, 0, 0, 1, 1, 1, 1, 0, 0, 1])
        assert [word for word, _ in told] == [None, None, 0x22, 0x00, None, None, None, None, 0x22, 0x22, None]
        assert [ack for _, ack in told] == [0b111] * 4 + [0b110] * 3 + [0b111] * 3 + [0b011]

    def test_an_acknowledge_from_before_the_word_counts(self, sim: PyVerilator) -> None:
        told = clocks(sim, [0b101] * 4 + [0b111] * 3, [0, 0, 0, 1, 1, 1, 1])
        assert [word for word, _ in told] == [None, None, 0x11, None, None, None, None]
        assert [ack for _, ack in told] == [0b111] * 3 + [0b101] * 3 + [0b111]

    def test_the_next_word_waits_for_the_receiver_to_release(self, sim: PyVerilator) -> None:
        told = clocks(sim, [0b101] * 5 + [0b110] * 8, [1, 1, *[0] * 8, 1, 1, 1])
        assert [word for word, _ in told][4:] == [None] * 9
        assert [ack for _, ack in told][4:12] == [0b101] * 8

    def test_a_request_that_is_withdrawn_is_forgotten_and_the_line_stays_connected(self, sim: PyVerilator) -> None:
        told = clocks(sim, [0b011] * 2 + [0b111] * 3 + [0b101] * 2, [1] * 7)
        assert [word for word, _ in told] == [None, None, 0x22, None, None, None, 0x11]


@pytest.mark.parametrize("seed", range(6))
def test_it_is_the_line_of_the_text_under_lines_that_keep_no_protocol(sim: PyVerilator, seed: int) -> None:
    rng = np.random.default_rng([81, seed])
    text = library_line(idle=2**W - 1)
    expected = next(text)
    toggles = rng.random((2_000, 4)) < rng.choice([0.05, 0.3, 0.6], 4)
    levels = np.cumsum(toggles, axis=0) & 1
    sent = 0
    for *asks, acks in levels.tolist():
        requests = {i: int(rng.integers(256)) for i, ask in enumerate(asks) if ask}
        sim.io.s_req_n = sum((not ask) << i for i, ask in enumerate(asks))
        sim.io.s_word = sum(word << W * i for i, word in requests.items())
        sim.io.m_ack_n = int(not acks)
        requested, word, acked = expected
        assert (not sim.io.m_req_n, int(sim.io.m_word)) == (requested, word)
        assert ~int(sim.io.s_ack_n) & 0b111 == (0 if acked is None else 1 << acked)
        sent += acked is not None
        expected = text.send((requests, bool(acks)))
        sim.clock.tick()
    assert sent > 20

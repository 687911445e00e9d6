# SPDX-License-Identifier: Apache-2.0
"""The ports of the published tracker: merging of address events, and its line."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from pyverilator import PyVerilator

from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load
from support.published_text import library_line

TOP = "aer_merge"
N, W = 3, 8


@pytest.fixture
def sim() -> PyVerilator:
    """Nobody requests; each sender's word is its number, and its number again."""
    merge = load(TOP, {"N": N, "W": W})
    merge.io.s_req_n = 0b111
    merge.io.m_ack_n = 1
    merge.io.s_word = 0x221100
    reset(merge)
    return merge


class TestStories:
    def test_a_word_passes_without_delay_and_its_acknowledge_too(self, sim: PyVerilator) -> None:
        assert sim.io.m_req_n == 1
        sim.io.s_req_n = 0b101
        assert (sim.io.m_req_n, sim.io.m_word, sim.io.s_ack_n) == (0, 0x11, 0b111)
        sim.io.m_ack_n = 0
        assert sim.io.s_ack_n == 0b101

    def test_a_word_under_way_is_not_taken_back_for_a_lower_one(self, sim: PyVerilator) -> None:
        sim.io.s_req_n = 0b001
        sim.clock.tick()
        sim.io.s_req_n = 0b000
        assert (sim.io.m_req_n, sim.io.m_word) == (0, 0x11)

    def test_the_next_word_waits_until_the_acknowledge_was_seen_released(self, sim: PyVerilator) -> None:
        sim.io.s_req_n, sim.io.m_ack_n = 0b100, 0
        sim.clock.tick()
        sim.io.s_req_n = 0b101
        for _ in range(5):  # of the first, released; the receiver is not
            assert sim.io.m_req_n == 1
            sim.clock.tick()
        sim.io.m_ack_n = 1
        assert sim.io.m_req_n == 1
        sim.clock.tick()
        assert (sim.io.m_req_n, sim.io.m_word) == (0, 0x11)


@pytest.mark.parametrize("seed", range(4))
def test_random_partners_of_any_speed(sim: PyVerilator, seed: int) -> None:
    rng = np.random.default_rng([80, seed])
    eager, slow = rng.uniform(0.02, 0.9, N), rng.uniform(0.1, 1, 2)
    sent: list[list[int]] = [[] for _ in range(N)]
    words, requests, acknowledge = [0] * N, [False] * N, False
    result: list[int] = []  # on the line, a word for each request
    on_line: int | None = None
    for _ in range(1_500):
        acks = ~int(sim.io.s_ack_n) & 0b111
        for i in range(N):
            if requests[i] and acks >> i & 1:
                requests[i] = bool(rng.random() > slow[0])  # holds request and word for a while
            elif not requests[i] and not acks >> i & 1 and rng.random() < eager[i]:
                requests[i], words[i] = True, i << 6 | len(sent[i]) & 63
                sent[i].append(words[i])
        if rng.random() < slow[1]:
            acknowledge = not sim.io.m_req_n
        sim.io.s_req_n = sum((not requests[i]) << i for i in range(N))
        sim.io.s_word = sum(words[i] << W * i for i in range(N))
        sim.io.m_ack_n = int(not acknowledge)
        word = None if sim.io.m_req_n else int(sim.io.m_word)
        if word is not None and on_line is None:
            result.append(word)
            assert word >> 6 == min(i for i in range(N) if requests[i])
        assert None in (word, on_line) or word == on_line  # released between two
        assert [bool(~int(sim.io.s_ack_n) >> i & 1) for i in range(N)] == [
            acknowledge and word is not None and word >> 6 == i for i in range(N)
        ]
        on_line = word
        sim.clock.tick()
    for i in range(N):
        heard = [word for word in result if word >> 6 == i]
        assert heard in (sent[i], sent[i][:-1])  # in order, none twice
    assert len(result) > 60
    assert any(a >> 6 != b >> 6 for a, b in pairwise(result))


PUBLISHED_LINE_TOP = "published_line"


@pytest.fixture
def published_line_sim() -> PyVerilator:
    """Nobody requests; each sender's word is its number, twice."""
    line = load(PUBLISHED_LINE_TOP, {"N": N, "W": W})
    line.io.s_req_n = 0b111
    line.io.m_ack_n = 1
    line.io.s_word = 0x221100
    reset(line)
    return line


def clocks(published_line_sim: PyVerilator, requests: list[int], acks: list[int]) -> list[tuple[int | None, int]]:
    """(word or None, acknowledges) in each clock, for the senders' requests and the receiver's acknowledges."""
    told = []
    for request, ack in zip(requests, acks, strict=True):
        published_line_sim.io.s_req_n, published_line_sim.io.m_ack_n = request, ack
        told.append(
            (None if published_line_sim.io.m_req_n else int(published_line_sim.io.m_word), int(published_line_sim.io.s_ack_n))
        )
        published_line_sim.clock.tick()
    return told


class TestPublishedLineStories:
    def test_a_word_appears_after_2_clocks_its_acknowledge_after_4_and_the_next_word_after_6(
        self, published_line_sim: PyVerilator
    ) -> None:
        told = clocks(published_line_sim, [0b101] * 5 + [0b111] + [0b110] * 6, [1, 1, 0, 0, 1, 1, 1, 1, 0, 0, 1, 1])
        words = [word for word, _ in told]
        assert words == [None, None, 0x11, 0x11, None, None, None, None, 0x00, 0x00, None, None]
        assert [ack for _, ack in told] == [0b111] * 4 + [0b101] * 3 + [0b111] * 3 + [0b110] * 2

    def test_its_request_lasts_one_clock_beyond_that_of_the_acknowledge(self, published_line_sim: PyVerilator) -> None:
        for wait in (0, 1, 7):
            told = clocks(published_line_sim, [0b101] * (5 + wait) + [0b111] * 3, [1] * (2 + wait) + [0] * 2 + [1] * 4)
            assert [word for word, _ in told] == [None] * 2 + [0x11] * (wait + 2) + [None] * 4

    def test_the_word_is_all_ones_while_it_is_idle(self, published_line_sim: PyVerilator) -> None:
        words = []
        for request, ack in zip([0b111] * 2 + [0b101] * 5 + [0b111] * 4, [1] * 4 + [0] * 2 + [1] * 5, strict=True):
            published_line_sim.io.s_req_n, published_line_sim.io.m_ack_n = request, ack
            words.append(int(published_line_sim.io.m_word))
            published_line_sim.clock.tick()
        # Requested in clock 2, sent in 4, acknowledged in 4; idle from clock 8 on, which is seen in the one after.
        assert words == [0xFF] * 4 + [0x11] * 5 + [0xFF] * 2

    def test_a_word_that_waits_gives_way_to_a_higher_rank_and_comes_later(self, published_line_sim: PyVerilator) -> None:
        told = clocks(published_line_sim, [0b011] * 4 + [0b010] * 5 + [0b011] * 6, [1] * 6 + [0, 0] + [1] * 5 + [0, 0])
        words = [word for word, _ in told]
        assert words[2:8] == [0x22, 0x22, 0x22, 0x00, 0x00, 0x00]
        assert [ack for _, ack in told][8] == 0b110
        assert words[8:] == [None] * 4 + [0x22] * 3

    def test_a_word_is_replaced_in_the_clock_of_its_acknowledge_and_comes_again_later(
        self, published_line_sim: PyVerilator
    ) -> None:
        # The acknowledge of 0x22 in clock 2 goes to sender 0, which asks from that clock on.
        told = clocks(published_line_sim, [0b011] * 2 + [0b010] * 3 + [0b011] * 6, [1, 1, 0, 0, 1, 1, 1, 1, 0, 0, 1])
        assert [word for word, _ in told] == [None, None, 0x22, 0x00, None, None, None, None, 0x22, 0x22, None]
        assert [ack for _, ack in told] == [0b111] * 4 + [0b110] * 3 + [0b111] * 3 + [0b011]

    def test_an_acknowledge_from_before_the_word_counts(self, published_line_sim: PyVerilator) -> None:
        told = clocks(published_line_sim, [0b101] * 4 + [0b111] * 3, [0, 0, 0, 1, 1, 1, 1])
        assert [word for word, _ in told] == [None, None, 0x11, None, None, None, None]
        assert [ack for _, ack in told] == [0b111] * 3 + [0b101] * 3 + [0b111]

    def test_the_next_word_waits_for_the_receiver_to_release(self, published_line_sim: PyVerilator) -> None:
        told = clocks(published_line_sim, [0b101] * 5 + [0b110] * 8, [1, 1, *[0] * 8, 1, 1, 1])
        assert [word for word, _ in told][4:] == [None] * 9
        assert [ack for _, ack in told][4:12] == [0b101] * 8

    def test_a_request_that_is_withdrawn_is_forgotten_and_the_line_stays_connected(
        self, published_line_sim: PyVerilator
    ) -> None:
        told = clocks(published_line_sim, [0b011] * 2 + [0b111] * 3 + [0b101] * 2, [1] * 7)
        assert [word for word, _ in told] == [None, None, 0x22, None, None, None, 0x11]


@pytest.mark.parametrize("seed", range(6))
def test_it_is_the_line_of_the_text_under_lines_that_keep_no_protocol(published_line_sim: PyVerilator, seed: int) -> None:
    rng = np.random.default_rng([81, seed])
    text = library_line(idle=2**W - 1)
    expected = next(text)
    toggles = rng.random((2_000, 4)) < rng.choice([0.05, 0.3, 0.6], 4)
    levels = np.cumsum(toggles, axis=0) & 1
    sent = 0
    for *asks, acks in levels.tolist():
        requests = {i: int(rng.integers(256)) for i, ask in enumerate(asks) if ask}
        published_line_sim.io.s_req_n = sum((not ask) << i for i, ask in enumerate(asks))
        published_line_sim.io.s_word = sum(word << W * i for i, word in requests.items())
        published_line_sim.io.m_ack_n = int(not acks)
        requested, word, acked = expected
        assert (not published_line_sim.io.m_req_n, int(published_line_sim.io.m_word)) == (requested, word)
        assert ~int(published_line_sim.io.s_ack_n) & 0b111 == (0 if acked is None else 1 << acked)
        sent += acked is not None
        expected = text.send((requests, bool(acks)))
        published_line_sim.clock.tick()
    assert sent > 20

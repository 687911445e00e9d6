# SPDX-License-Identifier: Apache-2.0
"""aer_merge.v: senders and a receiver of any speed; every word whole, one at a time, the lowest sender first."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from pyverilator import PyVerilator

from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load
from support.testing import lint

TOP = "aer_merge"
N, W = 3, 8


@pytest.mark.parametrize("n", [1, 2, 3, 64])
def test_lints_clean(n: int) -> None:
    assert lint(TOP, N=n) == (0, "")


@pytest.mark.parametrize(
    ("parameters", "rule"),
    [
        ({"N": 0}, "N_must_be_1_to_64"),
        ({"N": 65}, "N_must_be_1_to_64"),
        ({"W": 0}, "W_must_be_at_least_1"),
        ({"INDEX_W": 3}, "INDEX_W_must_be_left_at_its_default"),
    ],
)
def test_refuses_parameters(parameters: dict[str, int], rule: str) -> None:
    code, log = lint(TOP, **parameters)
    assert code != 0
    assert rule in log


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

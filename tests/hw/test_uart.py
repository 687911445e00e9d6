# SPDX-License-Identifier: Apache-2.0
"""uart_rx.v and uart_tx.v against a line made bit by bit here, at every divisor's corner, with rates that are off a little."""

from __future__ import annotations

import numpy as np
import pytest

from evcot_cosim.build import load
from evcot_cosim.testing import reset

SEED = 77


def line_of(data: bytes, clocks_per_bit: float, idle: int = 0) -> list[int]:
    """The line at every clock: start bit, 8 data bits, lowest first, stop bit; then `idle` clocks between bytes."""
    line: list[int] = []
    for value in data:
        end = 0.0
        begin = len(line)
        for bit in (0, *((value >> i) & 1 for i in range(8)), 1):
            end += clocks_per_bit
            line += [bit] * (round(begin + end) - len(line))
        line += [1] * idle
    return line


@pytest.mark.parametrize("divisor", [4, 5, 12, 25, 104])
@pytest.mark.parametrize("off", [-0.02, 0.0, 0.02])
def test_rx_takes_every_byte_at_rates_that_are_off_by_two_percent(divisor: int, off: float) -> None:
    random = np.random.default_rng(SEED)
    data = bytes(random.integers(0, 256, 40, np.uint8))
    sim = load("uart_rx", {"DIVISOR": divisor})
    sim.io.rx = 1
    reset(sim)
    heard = bytearray()
    for level in [1] * 20 + line_of(data, divisor * (1 + off), idle=2) + [1] * 12 * divisor:
        sim.io.rx = level
        sim.clock.tick()
        if int(sim.io.m_valid):
            heard.append(int(sim.io.m_data))
    assert bytes(heard) == data


def test_rx_takes_no_glitch_for_a_start_bit_and_no_break_for_a_byte() -> None:
    sim = load("uart_rx", {"DIVISOR": 12})
    sim.io.rx = 1
    reset(sim)
    heard = bytearray()
    line = [1] * 20 + [0] * 4 + [1] * 200 + [0] * 12 * 30 + [1] * 40 + line_of(b"\x5a", 12) + [1] * 40
    for level in line:
        sim.io.rx = level
        sim.clock.tick()
        if int(sim.io.m_valid):
            heard.append(int(sim.io.m_data))
    assert bytes(heard) == b"\x5a"


@pytest.mark.parametrize("divisor", [2, 3, 12, 25])
def test_tx_sends_bytes_back_to_back_and_the_line_rests_high(divisor: int) -> None:
    random = np.random.default_rng(SEED)
    data = bytes(random.integers(0, 256, 20, np.uint8))
    sim = load("uart_tx", {"DIVISOR": divisor})
    reset(sim)
    assert int(sim.io.tx) == 1
    line, sent = [], 0
    while sent < len(data) or not int(sim.io.s_ready):
        sim.io.s_valid = int(sent < len(data))
        sim.io.s_data = data[min(sent, len(data) - 1)]
        sent += int(sim.io.s_ready) and sent < len(data)
        sim.clock.tick()
        line.append(int(sim.io.tx))
    # A byte takes its ten bits and the clock in which the next one is taken.
    assert line[: len(line) - 1] == line_of(data, divisor, idle=1)[: len(line) - 1]
    for _ in range(3 * divisor):
        sim.clock.tick()
        assert int(sim.io.tx) == 1

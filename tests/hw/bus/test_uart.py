# SPDX-License-Identifier: Apache-2.0
"""The serial line, both ways."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest

from evcot_cosim.devices.base import reset
from evcot_cosim.fpga.serial_host import Receiver, levels
from evcot_cosim.rtl.build import load
from support.testing import Source, always, run_streams, sometimes

TOP = "uart_tx"
DATA = np.random.default_rng(77).bytes(20)
WORDS = [(value,) for value in DATA]


@pytest.mark.parametrize("divisor", [2, 5, 12])
def test_bytes_follow_each_other_and_then_the_line_rests(divisor: int) -> None:
    """A byte takes its ten bits and the clock in which the next one is taken."""
    sim = load(TOP, {"DIVISOR": divisor})
    reset(sim)
    line: list[int] = []
    source = Source(sim, "s", ["data"], WORDS, always())
    run_streams(sim, [source], [], quiet_clocks=13 * divisor, on_clock=lambda _: line.append(int(sim.io.tx)))
    wanted = levels(DATA, divisor, idle=1)
    assert line == [1, *wanted] + [1] * (len(line) - 1 - len(wanted))


def test_bytes_come_whole_whenever_they_come() -> None:
    sim = load(TOP, {"DIVISOR": 5})
    reset(sim)
    receiver = Receiver(5)
    source = Source(sim, "s", ["data"], WORDS, sometimes(np.random.default_rng(78), 0.05))
    run_streams(sim, [source], [], quiet_clocks=60, on_clock=lambda _: receiver.sample(int(sim.io.tx)))
    assert bytes(receiver.received) == DATA


def test_reset_lets_the_line_rest_in_the_middle_of_a_byte() -> None:
    sim = load(TOP, {"DIVISOR": 5})
    reset(sim)
    sim.io.s_valid, sim.io.s_data = 1, 0
    for _ in range(12):
        sim.clock.tick()
    assert (sim.io.tx, sim.io.s_ready) == (0, 0)
    sim.io.s_valid = 0
    reset(sim)
    assert (sim.io.tx, sim.io.s_ready) == (1, 1)


UART_RX_TOP = "uart_rx"


def received(divisor: int, line: Iterable[int]) -> bytes:
    """What comes out, from reset; the line rests before and after."""
    sim = load(UART_RX_TOP, {"DIVISOR": divisor})
    sim.io.rx = 1
    reset(sim)
    result = bytearray()
    for level in [1] * 20 + list(line) + [1] * 12 * divisor:
        sim.io.rx = level
        sim.clock.tick()
        if sim.io.m_valid:
            result.append(int(sim.io.m_data))
    return bytes(result)


@pytest.mark.parametrize("off", [-0.02, 0.0, 0.02])
@pytest.mark.parametrize("divisor", [4, 25])
def test_takes_every_byte_at_rates_that_are_off_by_two_percent(divisor: int, off: float) -> None:
    data = np.random.default_rng(77).bytes(40)
    assert received(divisor, levels(data, divisor * (1 + off), idle=2)) == data


def test_bytes_may_follow_each_other_without_a_pause() -> None:
    data = bytes([0, 255, 0x55, 0xAA, 1, 128])
    assert received(25, levels(data, 25)) == data


def test_a_glitch_is_no_start_bit() -> None:
    assert received(25, [0] * 11 + [1] * 500 + levels(b"\x5a", 25)) == b"\x5a"


def test_a_break_is_no_byte_and_the_next_one_begins_when_it_is_over() -> None:
    assert received(25, [0] * 25 * 30 + [1] * 25 + levels(b"\x5a", 25)) == b"\x5a"

# SPDX-License-Identifier: Apache-2.0
"""uart_rx.v hears a line made bit by bit, at rates that are off a little; glitches and breaks are no bytes."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest

from evcot_cosim.devices.base import reset
from evcot_cosim.fpga.uart_line import levels
from evcot_cosim.rtl.build import load
from support.testing import lint

TOP = "uart_rx"


def received(divisor: int, line: Iterable[int]) -> bytes:
    """What comes out, from reset; the line rests before and after."""
    sim = load(TOP, {"DIVISOR": divisor})
    sim.io.rx = 1
    reset(sim)
    result = bytearray()
    for level in [1] * 20 + list(line) + [1] * 12 * divisor:
        sim.io.rx = level
        sim.clock.tick()
        if sim.io.m_valid:
            result.append(int(sim.io.m_data))
    return bytes(result)


@pytest.mark.parametrize("divisor", [4, 65535])
def test_lints_clean(divisor: int) -> None:
    assert lint(TOP, DIVISOR=divisor) == (0, "")


@pytest.mark.parametrize("divisor", [3, 65536])
def test_refuses_other_divisors(divisor: int) -> None:
    code, log = lint(TOP, DIVISOR=divisor)
    assert code != 0
    assert "DIVISOR_must_be_4_to_65535" in log


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

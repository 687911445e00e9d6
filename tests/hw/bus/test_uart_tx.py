# SPDX-License-Identifier: Apache-2.0
"""uart_tx.v puts bytes on a line bit by bit, one after another, and lets it rest high."""

from __future__ import annotations

import numpy as np
import pytest

from evcot_cosim.devices.base import reset
from evcot_cosim.fpga.uart_line import Receiver, levels
from evcot_cosim.rtl.build import load
from support.testing import Source, always, lint, run_streams, sometimes

TOP = "uart_tx"
DATA = np.random.default_rng(77).bytes(20)
WORDS = [(value,) for value in DATA]


@pytest.mark.parametrize("divisor", [2, 65535])
def test_lints_clean(divisor: int) -> None:
    assert lint(TOP, DIVISOR=divisor) == (0, "")


@pytest.mark.parametrize("divisor", [1, 65536])
def test_refuses_other_divisors(divisor: int) -> None:
    code, log = lint(TOP, DIVISOR=divisor)
    assert code != 0
    assert "DIVISOR_must_be_2_to_65535" in log


@pytest.mark.parametrize("divisor", [2, 5])
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

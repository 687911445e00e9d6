# SPDX-License-Identifier: Apache-2.0
"""filter_regs.v: every register of a filter chain, written over one port and shown all at once."""

from __future__ import annotations

import numpy as np
import pytest
from pyverilator import PyVerilator

from evcot.filters.contract import FILTER_REGISTERS, FilterShape
from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load

SHAPE = FilterShape(stamp_w=9)
VALUES = {name: register for name, register in FILTER_REGISTERS.items() if name != "mask"}


@pytest.fixture
def sim() -> PyVerilator:
    sim = load("filter_regs", {"STAMP_W": SHAPE.stamp_w})
    reset(sim)
    return sim


def write(sim: PyVerilator, name: str, value: int) -> None:
    sim.io.cfg_valid, sim.io.cfg_addr, sim.io.cfg_data = 1, FILTER_REGISTERS[name].address, value
    sim.clock.tick()
    sim.io.cfg_valid = 0


def shown(sim: PyVerilator) -> dict[str, int]:
    return {name: value_of(sim, name) for name in VALUES}


def value_of(sim: PyVerilator, name: str) -> int:
    """A register's output; the thresholds of the noise share one, which shows that which is asked for."""
    if name.startswith("noise_") and name != "noise_log2":
        sim.io.noise_asked = VALUES[name].address & 7
        sim.eval()
        return int(sim.io.noise_least)
    return int(sim.io[name])


def test_every_register_keeps_what_was_last_written(sim: PyVerilator) -> None:
    rng = np.random.default_rng(31)
    kept: dict[str, int] = {}
    for name in [*VALUES, *rng.choice(list(VALUES), 300)]:
        value = int(rng.integers(1 << 32))
        write(sim, name, value)
        kept[name] = value & ((1 << VALUES[name].limits(SHAPE)[1].bit_length()) - 1)  # bits above the width are ignored
    assert shown(sim) == kept


@pytest.mark.parametrize("name", VALUES)
def test_every_register_holds_its_limits(sim: PyVerilator, name: str) -> None:
    for value in VALUES[name].limits(SHAPE):
        write(sim, name, value)
        assert value_of(sim, name) == value


def test_a_write_shows_on_the_next_clock_and_only_when_valid(sim: PyVerilator) -> None:
    write(sim, "recent_support", 5)
    sim.io.cfg_addr, sim.io.cfg_data = VALUES["recent_support"].address, 9
    sim.clock.tick()
    assert sim.io.recent_support == 5
    sim.io.cfg_valid = 1
    assert sim.io.recent_support == 5
    sim.clock.tick()
    assert sim.io.recent_support == 9


def test_a_mark_shows_for_one_clock(sim: PyVerilator) -> None:
    for name in VALUES:
        write(sim, name, 1)
    assert sim.io.mask_valid == 0
    write(sim, "mask", 1 << 31 | 259 << 16 | 345)
    assert (sim.io.mask_valid, sim.io.mask_x, sim.io.mask_y, sim.io.mask_hot) == (1, 345, 259, 1)
    write(sim, "mask", 32767 << 16 | 65535)
    assert (sim.io.mask_valid, sim.io.mask_x, sim.io.mask_y, sim.io.mask_hot) == (1, 65535, 32767, 0)
    sim.clock.tick()
    assert sim.io.mask_valid == 0
    assert shown(sim) == dict.fromkeys(VALUES, 1)


def test_reset_disables_all_filters_stops_the_clock_of_the_decay_and_keeps_the_rest(sim: PyVerilator) -> None:
    for name in VALUES:
        write(sim, name, 1)
    sim.io.cfg_valid, sim.io.cfg_addr = 1, FILTER_REGISTERS["mask"].address
    reset(sim, clocks=1)
    assert sim.io.mask_valid == 0
    assert shown(sim) == dict.fromkeys(VALUES, 1) | {"enable": 0, "decay_rate": 0, "stamp_shift": 0}

# SPDX-License-Identifier: Apache-2.0
"""cot_regs.v: every register of every slot, written over one port; some shown of one slot, the others of another."""

from __future__ import annotations

import numpy as np
import pytest
from pyverilator import PyVerilator

from evcot.hardware.contract import REGISTERS, Mode, Shape
from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load

SHAPE = Shape(n_slots=3, x_w=7, y_w=6, radix_w=5, nev_w=4, tc_w=12)
EARLY = ("init_cm_x", "init_cm_y", "radix_th", "radix_step", "radix_min", "radix_max", "hist_avg", "nev_th")


@pytest.fixture
def sim() -> PyVerilator:
    widths = {"X_W": SHAPE.x_w, "Y_W": SHAPE.y_w, "RADIX_W": SHAPE.radix_w, "NEV_W": SHAPE.nev_w, "TC_W": SHAPE.tc_w}
    sim = load("cot_regs", {"N": SHAPE.n_slots, "SLOT_W": SHAPE.slot_w, **widths})
    reset(sim)
    return sim


def write(sim: PyVerilator, slot: int, address: int, value: int) -> None:
    sim.io.cfg_valid, sim.io.cfg_slot, sim.io.cfg_addr, sim.io.cfg_data = 1, slot, address, value
    sim.clock.tick()
    sim.io.cfg_valid = 0


def shown(sim: PyVerilator, slot: int, late_slot: int) -> dict[str, int]:
    sim.io.slot, sim.io.late_slot = slot, late_slot
    return {name: int(sim.io[name]) for name in REGISTERS}


def test_each_of_two_slots_shows_what_was_last_written_of_its_own(sim: PyVerilator) -> None:
    rng = np.random.default_rng(4)
    kept: list[dict[str, int]] = [{} for _ in range(SHAPE.n_slots)]
    for name in [*REGISTERS, *rng.choice(list(REGISTERS), 300)]:
        for slot in range(SHAPE.n_slots):
            value = int(rng.integers(1 << 32))
            write(sim, slot, REGISTERS[name].address, value)
            kept[slot][name] = value & ((1 << REGISTERS[name].bits(SHAPE)) - 1)
    sim.clock.tick()  # for a mode
    for slot in range(SHAPE.n_slots):
        for late_slot in range(SHAPE.n_slots):
            expected = {name: kept[slot if name in EARLY else late_slot][name] for name in REGISTERS}
            assert shown(sim, slot, late_slot) == expected


def test_a_write_shows_on_the_next_clock_and_only_when_valid(sim: PyVerilator) -> None:
    address = REGISTERS["nev_th"].address
    write(sim, 1, address, 5)
    sim.io.slot, sim.io.cfg_slot, sim.io.cfg_addr, sim.io.cfg_data = 1, 1, address, 9
    sim.clock.tick()
    assert sim.io.nev_th == 5
    sim.io.cfg_valid = 1
    assert sim.io.nev_th == 5
    sim.clock.tick()
    assert sim.io.nev_th == 9


def test_an_address_without_register_changes_nothing(sim: PyVerilator) -> None:
    for register in REGISTERS.values():
        write(sim, 0, register.address, 1)
    sim.clock.tick()
    before = shown(sim, 0, 0)
    unused = set(range(16)) - {register.address for register in REGISTERS.values()}
    assert unused
    for address in unused:
        write(sim, 0, address, 0)
    sim.clock.tick()
    assert shown(sim, 0, 0) == before


def test_a_mode_takes_a_clock_more_than_the_rest(sim: PyVerilator) -> None:
    for name, expected in {"mode": [1, 2], "nev_th": [2, 2]}.items():
        write(sim, 2, REGISTERS[name].address, 1)
        sim.clock.tick()
        write(sim, 2, REGISTERS[name].address, 2)
        seen = [shown(sim, 2, 2)[name]]
        sim.clock.tick()
        assert [*seen, shown(sim, 2, 2)[name]] == expected


def test_reset_turns_every_slot_off_and_keeps_the_rest(sim: PyVerilator) -> None:
    for slot in range(SHAPE.n_slots):
        for register in REGISTERS.values():
            write(sim, slot, register.address, 2)
    sim.io.cfg_valid, sim.io.cfg_addr = 1, REGISTERS["mode"].address
    reset(sim, clocks=1)
    sim.io.cfg_valid = 0
    sim.clock.tick()
    for slot in range(SHAPE.n_slots):
        assert shown(sim, slot, slot) == dict.fromkeys(REGISTERS, 2) | {"mode": Mode.OFF}

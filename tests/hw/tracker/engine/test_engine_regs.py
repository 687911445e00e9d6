# SPDX-License-Identifier: Apache-2.0
"""engine_regs.v: every register of every slot, some shown of one slot, the others of another."""

from __future__ import annotations

import numpy as np
import pytest
from pyverilator import PyVerilator

from evcot.hardware.contract import REGISTERS, Mode, Shape
from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load
from support.testing import lint

SHAPE = Shape(n_slots=3, x_w=7, y_w=6, radix_w=5, nev_w=4, tc_w=12)
OF_C = ("init_cm_x", "init_cm_y", "radix_th", "radix_step", "radix_min", "radix_max", "hist_avg", "nev_th")


@pytest.fixture
def sim() -> PyVerilator:
    widths = {"X_W": SHAPE.x_w, "Y_W": SHAPE.y_w, "RADIX_W": SHAPE.radix_w, "NEV_W": SHAPE.nev_w, "TC_W": SHAPE.tc_w}
    sim = load("engine_regs", {"N": SHAPE.n_slots, "SLOT_W": SHAPE.slot_w, **widths})
    reset(sim)
    return sim


def write(sim: PyVerilator, slot: int, address: int, value: int) -> None:
    sim.io.cfg_valid, sim.io.cfg_slot, sim.io.cfg_addr, sim.io.cfg_data = 1, slot, address, value
    sim.clock.tick()
    sim.io.cfg_valid = 0


def shown(sim: PyVerilator, c_slot: int, u_slot: int) -> dict[str, int]:
    sim.io.c_slot, sim.io.u_slot = c_slot, u_slot
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
    for c_slot in range(SHAPE.n_slots):
        for u_slot in range(SHAPE.n_slots):
            expected = {name: kept[c_slot if name in OF_C else u_slot][name] for name in REGISTERS}
            assert shown(sim, c_slot, u_slot) == expected


def test_nothing_is_written_unless_valid(sim: PyVerilator) -> None:
    address = REGISTERS["nev_th"].address
    write(sim, 1, address, 5)
    sim.io.c_slot, sim.io.cfg_slot, sim.io.cfg_addr, sim.io.cfg_data = 1, 1, address, 9
    sim.clock.tick()
    assert sim.io.nev_th == 5


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


@pytest.mark.parametrize(("n", "slot_w"), [(1, 1), (2, 1), (3, 2), (64, 6)])
def test_lints_clean(n: int, slot_w: int) -> None:
    assert lint("engine_regs", N=n, SLOT_W=slot_w) == (0, "")

# SPDX-License-Identifier: Apache-2.0
"""cot_regs.v: every register of every slot, written over one port and shown slot by slot."""

from __future__ import annotations

import numpy as np
import pytest
from pyverilator import PyVerilator

from evcot.hardware.contract import REGISTERS, Mode, Shape
from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load
from support.testing import lint

SHAPE = Shape(n_slots=3, x_w=7, y_w=6, radix_w=5, nev_w=4, tc_w=12)


def bank(shape: Shape = SHAPE) -> PyVerilator:
    widths = {"X_W": shape.x_w, "Y_W": shape.y_w, "RADIX_W": shape.radix_w, "NEV_W": shape.nev_w, "TC_W": shape.tc_w}
    sim = load("cot_regs", {"N": shape.n_slots, "SLOT_W": shape.slot_w, **widths})
    reset(sim)
    return sim


def write(sim: PyVerilator, slot: int, address: int, value: int) -> None:
    sim.io.cfg_valid, sim.io.cfg_slot, sim.io.cfg_addr, sim.io.cfg_data = 1, slot, address, value
    sim.clock.tick()
    sim.io.cfg_valid = 0


def shown(sim: PyVerilator, slot: int) -> dict[str, int]:
    sim.io.slot = slot
    return {name: int(sim.io[name]) for name in REGISTERS}


def test_every_register_of_every_slot_keeps_what_was_last_written() -> None:
    sim = bank()
    rng = np.random.default_rng(1)
    kept: list[dict[str, int]] = [{} for _ in range(SHAPE.n_slots)]
    for name in [*REGISTERS, *rng.choice(list(REGISTERS), 300)]:
        for slot in range(SHAPE.n_slots):
            value = int(rng.integers(1 << 32))
            write(sim, slot, REGISTERS[name].address, value)
            kept[slot][name] = value & ((1 << REGISTERS[name].bits(SHAPE)) - 1)  # bits above the width are ignored
    assert [shown(sim, slot) for slot in range(SHAPE.n_slots)] == kept


def test_a_write_shows_on_the_next_clock_and_only_when_valid() -> None:
    sim = bank()
    address = REGISTERS["nev_th"].address
    write(sim, 1, address, 5)
    sim.io.slot, sim.io.cfg_slot, sim.io.cfg_addr, sim.io.cfg_data = 1, 1, address, 9
    sim.clock.tick()
    assert sim.io.nev_th == 5
    sim.io.cfg_valid = 1
    assert sim.io.nev_th == 5
    sim.clock.tick()
    assert sim.io.nev_th == 9


def test_an_address_without_register_changes_nothing() -> None:
    sim = bank()
    for register in REGISTERS.values():
        write(sim, 0, register.address, 1)
    before = shown(sim, 0)
    unused = set(range(16)) - {register.address for register in REGISTERS.values()}
    assert unused
    for address in unused:
        write(sim, 0, address, 0)
    assert shown(sim, 0) == before


def test_reset_turns_every_slot_off_and_keeps_the_rest() -> None:
    sim = bank()
    for slot in range(SHAPE.n_slots):
        for register in REGISTERS.values():
            write(sim, slot, register.address, 2)
    reset(sim, clocks=1)
    for slot in range(SHAPE.n_slots):
        assert shown(sim, slot) == dict.fromkeys(REGISTERS, 2) | {"mode": Mode.OFF}


@pytest.mark.parametrize(("n", "slot_w"), [(1, 1), (2, 1), (3, 2), (64, 6)])
def test_lints_clean(n: int, slot_w: int) -> None:
    assert lint("cot_regs", N=n, SLOT_W=slot_w) == (0, "")


@pytest.mark.parametrize(
    ("parameters", "rule"),
    [
        ({"N": 0}, "N_must_be_1_to_64"),
        ({"N": 65, "SLOT_W": 7}, "N_must_be_1_to_64"),
        ({"N": 3, "SLOT_W": 1}, "SLOT_W_must_hold_N_slots"),
    ],
)
def test_refuses_parameters_out_of_range(parameters: dict[str, int], rule: str) -> None:
    code, log = lint("cot_regs", **parameters)
    assert code != 0
    assert rule in log

# SPDX-License-Identifier: Apache-2.0
"""motion_regs.v: each register has its address, its width and its default, and a write changes no other."""

from __future__ import annotations

from evcot.hardware.motion.contract import MOTION_RANGES, MotionRegisters
from evcot.hardware.registers import motion_addresses
from evcot_cosim.rtl.build import load


def test_every_register() -> None:
    sim = load("motion_regs", {})
    io = sim.io
    io.rst = 1
    sim.clock.tick()
    io.rst = 0
    sim.clock.tick()
    names = [name for name in motion_addresses() if name != "mode"]
    expected = {name: int(getattr(MotionRegisters(), name)) for name in names}

    bits = {name: int(MOTION_RANGES[name][1]).bit_length() for name in names}

    def found() -> dict[str, int]:
        """The registers lie one behind the other in the order of their addresses, the first in the lowest bits."""
        left, values = int(io.regs), {}
        for name in names:
            values[name] = left % (1 << bits[name])
            left >>= bits[name]
        assert left == 0
        return values

    assert found() == expected
    for name in ["mode", *names]:
        io.cfg_valid, io.cfg_addr, io.cfg_data = 1, motion_addresses()[name], 0xFFFFFFFF
        sim.clock.tick()
        io.cfg_valid = 0
        sim.clock.tick()
        if name != "mode":
            expected[name] = (1 << bits[name]) - 1
        assert found() == expected
    io.cfg_addr, io.cfg_data = motion_addresses()["nev_low"], 0
    sim.clock.tick()
    assert found() == expected  # without cfg_valid

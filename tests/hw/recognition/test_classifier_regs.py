# SPDX-License-Identifier: Apache-2.0
"""classifier_regs.v: each register keeps what was written last, from its default on."""

from __future__ import annotations

from evcot.hardware.classifier import CLASSIFIER_REGISTERS
from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load


def test_each_register_keeps_what_was_written_until_a_reset() -> None:
    sim, defaults = load("classifier_regs"), {name: register.start for name, register in CLASSIFIER_REGISTERS.items()}
    first = CLASSIFIER_REGISTERS["enable"].address

    def shown() -> dict[str, int]:
        return {name: int(sim.io[name]) for name in defaults}

    reset(sim)
    assert shown() == defaults
    for _ in range(2):
        kept = dict(defaults)
        for name, register in CLASSIFIER_REGISTERS.items():
            for value in (register.low, register.high):
                sim.io.write, sim.io.address, sim.io.data = 1, register.address - first, value
                sim.clock.tick()
                kept[name] = value
                assert shown() == kept
        sim.io.write, sim.io.data = 0, 0
        sim.clock.tick()
        assert shown() == kept
        reset(sim)
        assert shown() == defaults

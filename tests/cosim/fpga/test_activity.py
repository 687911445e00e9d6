# SPDX-License-Identifier: Apache-2.0
"""Toggles by module: what the RTL says of every net, and a total that is worked out by hand."""

from __future__ import annotations

from pathlib import Path

import pytest

from evcot.errors import ConfigError
from evcot_cosim.fpga.activity import ModuleToggles, by_module, design_of
from evcot_cosim.rtl.build import load
from evcot_cosim.waves.toggles import Activity, count_toggles


def waves(path: Path, top: str, words: int) -> Activity:
    """A skid buffer of eight bits that is offered `words` words, 0 and 255 in turn, and always read."""
    sim = load(top, {})
    sim.io.rst = 1
    sim.clock.tick()
    sim.io.rst = 0
    sim.io.s_valid, sim.io.m_ready = 0, 1
    sim.clock.tick()
    sim.start_vcd_trace(str(path))
    sim.io.s_valid = 1
    for i in range(words):
        sim.io.s_data = 255 * (i % 2)
        sim.clock.tick()
    sim.stop_vcd_trace()
    return count_toggles(path)


def test_registers_and_wires_of_a_skid_buffer(tmp_path: Path) -> None:
    found = by_module(design_of("skid_buffer", {}), waves(tmp_path / "waves.vcd", "skid_buffer", 10))
    assert list(found) == ["skid_buffer", "parameter_check"]
    one = found["skid_buffer"]
    # Three flags and twice eight bits. The output's data toggle nine times, the second register's too: it takes what is offered
    # until it is needed. m_valid rises once.
    assert (one.instances, one.registers, one.register_toggles) == (1, 3 + 8 + 8, 9 * 8 + 9 * 8 + 1)
    # accept, output_free, skid_valid_next; s_ready, m_valid and m_data are other names of registers.
    assert one.wires == 3
    assert found["parameter_check"] == ModuleToggles(instances=1)


def test_every_register_of_the_array_belongs_to_its_module() -> None:
    design = design_of("cot_array", {"N": 3})
    assert design.modules["cot_array.u_update.u_average_x.u_shift.g_k[4].u_products"] == "array_products"
    assert {"cot_array.u_input.now", "cot_array.u_update.av_x", "cot_array.g_three.slot"} <= design.registers
    assert not any(".g_far" in path or "g_copies" in path for path in design.nets)  # N is not above 16
    assert "cot_array.u_match.not_left" in design.wires  # not clocked
    assert "cot_array.d_slot" not in design.wires  # u_match drives it
    assert "cot_array.u_match.d_slot" in design.wires
    assert "cot_array.u_match.clk" not in design.wires  # an input
    assert any(".g_far" in path for path in design_of("cot_array", {"N": 17, "SLOT_W": 5}).registers)


def test_a_waveform_of_another_module_is_refused(tmp_path: Path) -> None:
    found = waves(tmp_path / "waves.vcd", "skid_buffer", 2)
    with pytest.raises(
        ConfigError, match=r"^cot_array\.\S+: not in the waveform: must be of cot_array with all that lies below"
    ):
        by_module(design_of("cot_array", {}), found)

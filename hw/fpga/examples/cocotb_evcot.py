# SPDX-License-Identifier: Apache-2.0
"""evcot_top in a cocotb test: events of a simulated scene in, every beat that leaves compared with the golden model.

    pip install evcot cocotb
    python cocotb_evcot.py hw/verilog  # the folder of the RTL: builds evcot_top in Icarus, and runs the test below

Copy `Bus`, `send` and `receive` into a bench of your own. `evcot_cosim.Vectors` says what must come out: docs/vectors.md.
"""

from __future__ import annotations

import os
import random
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge
from cocotb_tools.check_results import get_results
from cocotb_tools.runner import get_runner

import evcot
import evcot_cosim


def vectors() -> evcot_cosim.Vectors:
    """25 ms of crossing discs on a small sensor, and what the default hardware makes of them."""
    recording = evcot.simulate("discs", seed=3, duration_us=25_000, width=128, height=128).recording
    return evcot_cosim.Vectors.of(recording, evcot.run_config(recording.width, recording.height))


class Bus:
    """The registers of evcot_top over AXI4-Lite, an access at a time."""

    def __init__(self, dut: Any) -> None:
        self.dut = dut
        for name in ("awvalid", "wvalid", "arvalid", "awprot", "arprot"):
            getattr(dut, f"s_axil_{name}").value = 0
        dut.s_axil_wstrb.value = 0xF
        dut.s_axil_bready.value = dut.s_axil_rready.value = 1

    async def write(self, address: int, data: int) -> None:
        """Write a word; the response must be OKAY."""
        dut = self.dut
        dut.s_axil_awaddr.value, dut.s_axil_wdata.value = address, data
        waiting = {"aw", "w"}
        while waiting:
            for name in ("aw", "w"):
                getattr(dut, f"s_axil_{name}valid").value = name in waiting
            await RisingEdge(dut.clk)
            waiting -= {name for name in waiting if transferred(dut, f"s_axil_{name}")}
        dut.s_axil_awvalid.value = dut.s_axil_wvalid.value = 0
        while not transferred(dut, "s_axil_b"):
            await RisingEdge(dut.clk)
        assert dut.s_axil_bresp.value == 0, f"write of {data:#x} at {address:#06x} is refused"

    async def read(self, address: int) -> int:
        """Read a word."""
        dut = self.dut
        dut.s_axil_araddr.value, dut.s_axil_arvalid.value = address, 1
        await RisingEdge(dut.clk)
        while not transferred(dut, "s_axil_ar"):
            await RisingEdge(dut.clk)
        dut.s_axil_arvalid.value = 0
        while not transferred(dut, "s_axil_r"):
            await RisingEdge(dut.clk)
        return int(dut.s_axil_rdata.value)


def transferred(dut: Any, stream: str) -> bool:
    """Whether valid and ready of a stream are both high at the clock edge that was just awaited."""
    return bool(getattr(dut, f"{stream}valid").value) and bool(getattr(dut, f"{stream}ready").value)


async def send(dut: Any, words: Iterable[int], pause: random.Random) -> None:
    """Send beats of events, with pauses."""
    for word in words:
        while pause.random() < 0.25:
            await RisingEdge(dut.clk)
        dut.s_axis_tdata.value, dut.s_axis_tvalid.value = word, 1
        await RisingEdge(dut.clk)
        while not transferred(dut, "s_axis_t"):
            await RisingEdge(dut.clk)
        dut.s_axis_tvalid.value = 0


async def receive(dut: Any, stream: str, wanted: list[int], pause: random.Random) -> None:
    """Take the beats of an output for ever, with pauses; each must be the next one of `wanted`, from which it is removed."""
    data, ready = getattr(dut, f"{stream}_tdata"), getattr(dut, f"{stream}_tready")
    wanted.reverse()
    index = 0
    while True:
        ready.value = pause.random() < 0.75
        await RisingEdge(dut.clk)
        if transferred(dut, f"{stream}_t"):
            found = int(data.value)
            assert wanted, f"{stream}: beat {index}, {found:#018x}, is one too many"
            expected = wanted.pop()
            assert found == expected, f"{stream}: beat {index} is {found:#018x}: must be {expected:#018x}"
            index += 1


@cocotb.test()
async def evcot_top_is_exact(dut: Any) -> None:
    """Records, owned and passed events are those of the golden model, bit for bit, whatever the stalls."""
    expected, pause = vectors(), random.Random(1)
    Clock(dut.clk, 10, "ns").start()
    dut.rst.value = dut.aer_req.value = 1
    dut.aer_row.value = dut.aer_data.value = dut.s_axis_tvalid.value = dut.s_axis_tlast.value = 0
    dut.s_axis_tkeep.value = 0xFF
    bus = Bus(dut)
    outputs = {
        "m_axis_records": expected.records.ravel().tolist(),
        "m_axis_owned": expected.owned.tolist(),
        "m_axis_passed": expected.passed.tolist(),
    }
    for _ in range(4):
        await RisingEdge(dut.clk)
    dut.rst.value = 0
    for stream, wanted in outputs.items():
        cocotb.start_soon(receive(dut, stream, wanted, pause))

    sent, words = 0, expected.events.tolist()
    for access in expected.accesses:  # registers, `enable`, and after the last event: wait until all is done
        await send(dut, words[sent : access.after], pause)
        sent = max(sent, access.after)
        if not access.poll:
            await bus.write(access.address, access.data)
        while access.poll and await bus.read(access.address) & access.mask != access.data:
            pass
    assert {stream: len(wanted) for stream, wanted in outputs.items()} == dict.fromkeys(outputs, 0)
    dut._log.info("%d events, %d records: as the golden model has them", len(words), len(expected.records))


def run(rtl: Path, folder: Path) -> int:
    """Build evcot_top of a folder of RTL in Icarus, run the test in `folder`; returns the number of failed tests."""
    runner = get_runner("icarus")
    search = [flag for each in sorted({path.parent for path in rtl.rglob("*.v*")}) for flag in ("-y", str(each), f"-I{each}")]
    (top,) = rtl.rglob("evcot_top.v")
    runner.build(
        sources=[top], hdl_toplevel="evcot_top", parameters=vectors().parameters, build_args=search, build_dir=folder,
        timescale=("1ns", "1ns"),
    )  # fmt: skip
    os.environ["PYTHONPATH"] = os.pathsep.join([str(Path(__file__).parent), *sys.path])  # of the Python in the simulator
    results = runner.test(hdl_toplevel="evcot_top", test_module=Path(__file__).stem, build_dir=folder, test_dir=folder)
    return get_results(results)[1]


if __name__ == "__main__":
    sys.exit(run(Path(sys.argv[1]), Path("build/cocotb").absolute()))

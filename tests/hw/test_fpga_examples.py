# SPDX-License-Identifier: Apache-2.0
"""The examples of hw/fpga/examples, whole: set up by configure.py over AXI4-Lite, fed as by their cameras; records come out.

cocotb_evcot.py has evcot_top in a cocotb test in Icarus, with the golden model as its reference.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from pyverilator import PyVerilator

from evcot.errors import ToolchainError
from evcot.hardware.contract import RECORD
from evcot.hardware.register_access import Registers
from evcot.tracks.log import Kind
from evcot_cosim.fpga.catalogue import MODULES
from evcot_cosim.rtl.build import load
from evcot_cosim.rtl.files import copy_rtl, verilog_dir
from support.four_state import needs_icarus
from support.testing import broken_copy, module_at

EXAMPLES = Path(__file__).parents[2] / "hw" / "fpga" / "examples"
PIXELS = [(100 + int(dx), 60 + int(dy)) for dx, dy in np.random.default_rng(1).integers(-5, 6, (400, 2))]


@pytest.fixture(scope="module")
def example() -> ModuleType:
    return module_at(EXAMPLES / "configure.py")


@pytest.mark.parametrize("name", ["kv260", "davis"])
def test_each_is_placed_and_routed_with_its_own_parameters(name: str) -> None:
    module = MODULES[f"evcot_top_{name}"]
    text = (EXAMPLES / f"{name}_evcot.v").read_text()
    (settings,) = re.findall(r"evcot_top #\((.*?)\) u_evcot", text, re.DOTALL)
    given = {key: int(value) for key, value in re.findall(r"\.(\w+)\s*\((\d+)\)", settings)}
    assert module.at(module.usual[0]) == given


def test_the_clock_that_the_davis_example_asks_for_is_the_one_it_is_measured_against() -> None:
    (period_ns,) = re.findall(r"create_clock -name clk -period ([\d.]+)", (EXAMPLES / "davis_evcot.xdc").read_text())
    assert MODULES["evcot_top_davis"].asks_mhz == 1e3 / float(period_ns)


@pytest.mark.parametrize(
    ("top", "parameter", "value", "rule"),
    [
        ("davis_evcot", "N", 65, "N must be 1 to 64"),
        ("davis_evcot", "WIDTH", 257, "WIDTH must be 1 to 2 to the X W"),
        ("davis_evcot", "SOURCE", 4, "SOURCE must be one of SOURCES"),
        ("kv260_evcot", "HEIGHT", 0, "HEIGHT must be 1 to 2 to the Y W"),
        ("kv260_evcot", "SOURCES", 64, "must be"),
        ("kv260_evcot", "DATA_W", 48, "DATA W must be 32 64 128 or 256"),
        ("kv260_evcot", "X_W", 17, "W must be 1 to 16"),  # of the window, which Verilator comes to first
    ],
)
def test_a_parameter_out_of_range_stops_elaboration_by_name(
    top: str, parameter: str, value: int, rule: str, tmp_path: Path
) -> None:
    text = (EXAMPLES / f"{top}.v").read_text()
    broken, count = re.subn(rf"(\.{parameter}\s*)\(\d+\)", rf"\1({value})", text)
    assert count == 1
    (copy_rtl(tmp_path) / f"{top}.v").write_text(broken)
    with pytest.raises(ToolchainError, match=rf"cannot build {top}: .*{rule}"):
        load(top, verilog=tmp_path)


class Board:
    """An example under a host: a transport for `Registers`; each clock a step of its camera, and what records come."""

    def __init__(self, top: str, folder: Path) -> None:
        shutil.copy(EXAMPLES / f"{top}.v", copy_rtl(folder))
        self.sim: PyVerilator = load(top, verilog=folder)
        self.camera: Iterator[None] = iter(())
        self.received = bytearray()
        self.width = self.sim.io.m_axis_tdata.signal.width // 8

    def clock(self, count: int = 1) -> None:
        io = self.sim.io
        for _ in range(count):
            next(self.camera, None)
            if int(io.m_axis_tvalid) and int(io.m_axis_tready):
                self.received += int(io.m_axis_tdata).to_bytes(self.width, "little")
            self.sim.clock.tick()

    def write(self, address: int, value: int) -> None:
        io = self.sim.io
        io.s_axi_awaddr, io.s_axi_wdata, io.s_axi_wstrb, io.s_axi_bready = address, value, 15, 1
        self._shake("aw", "w")
        while not int(io.s_axi_bvalid):
            self.clock()
        assert int(io.s_axi_bresp) == 0, hex(address)
        self.clock()

    def read(self, address: int) -> int:
        io = self.sim.io
        io.s_axi_araddr, io.s_axi_rready = address, 1
        self._shake("ar")
        while not int(io.s_axi_rvalid):
            self.clock()
        value = int(io.s_axi_rdata)
        self.clock()
        return value

    def _shake(self, *channels: str) -> None:
        for channel in channels:
            self.sim.io[f"s_axi_{channel}valid"] = 1
            while not int(self.sim.io[f"s_axi_{channel}ready"]):
                self.clock()
            self.clock()
            self.sim.io[f"s_axi_{channel}valid"] = 0

    def check(self, registers: Registers) -> None:
        """One track at the middle of the pixels, and nothing lost."""
        assert len(self.received) % RECORD.itemsize == 0
        records = np.frombuffer(bytes(self.received), RECORD)
        assert records["kind"].tolist() == [Kind.BORN] + [Kind.MOVED] * (len(records) - 1)
        assert len(records) == len(PIXELS) // 32
        assert np.abs(records["cm_x"] / 16 - 100).max() < 1
        assert np.abs(records["cm_y"] / 16 - 60).max() < 1
        registers.control.latch = 1
        assert (registers.events_in, registers.owned, registers.malformed) == (len(PIXELS), len(PIXELS), 0)


def davis(sim: PyVerilator) -> Iterator[None]:
    """A row and a column for each pixel, 4-phase, active low."""
    for word in (word for x, y in PIXELS for word in (y, 1 << 9 | x << 1 | 1)):
        sim.io.davis_data, sim.io.davis_req_n = word, 0
        while int(sim.io.davis_ack_n):
            yield
        sim.io.davis_req_n = 1
        while not int(sim.io.davis_ack_n):
            yield


def prophesee(sim: PyVerilator) -> Iterator[None]:
    """EVT 2.1: a vector of one pixel every 7 us, and the time marks between them."""
    words, mark = [], -1
    for t, (x, y) in enumerate(PIXELS):
        t = 1000 + 7 * t
        if t >> 6 != mark:
            mark = t >> 6
            words.append(8 << 60 | mark << 32)
        words.append(1 << 60 | (t & 63) << 54 | x << 43 | y << 32 | 1)
    sim.io.s_axis_tkeep = 255
    for word in words:
        sim.io.s_axis_tdata, sim.io.s_axis_tvalid = word, 1
        while not int(sim.io.s_axis_tready):
            yield
        yield
    sim.io.s_axis_tvalid = 0


def test_a_davis_is_tracked(example: ModuleType, tmp_path: Path) -> None:
    board = Board("davis_evcot", tmp_path)
    io = board.sim.io
    io.davis_req_n = io.m_axis_tready = io.rst = 1
    board.clock(4)
    io.rst = 0
    registers = Registers(board)
    registers.source.word_serial = 1
    registers.control.soft_reset = 1
    registers = example.configure(board)
    board.camera = davis(board.sim)
    board.clock(len(PIXELS) * 2 * 9)
    board.check(registers)


def test_prophesees_pipeline_is_tracked(example: ModuleType, tmp_path: Path) -> None:
    board = Board("kv260_evcot", tmp_path)
    board.sim.io.m_axis_tready = 1
    board.clock(4)
    board.sim.io.aresetn = 1
    registers = example.configure(board)
    board.camera = prophesee(board.sim)
    board.clock(len(PIXELS) * 8)
    board.check(registers)


needs_cocotb = pytest.mark.skipif(find_spec("cocotb") is None, reason="cocotb is not installed: pip install 'evcot[test]'")


def run_cocotb(folder: Path, verilog: Path) -> tuple[int, str]:
    """Exit code of cocotb_evcot.py, and what it prints."""
    command = [sys.executable, str(EXAMPLES / "cocotb_evcot.py"), str(verilog)]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout + done.stderr


@needs_icarus
@needs_cocotb
def test_the_rtl_passes_in_cocotb(tmp_path: Path) -> None:
    code, printed = run_cocotb(tmp_path, verilog_dir())
    assert code == 0, printed
    assert "as the golden model has them" in printed
    assert "TESTS=1 PASS=1 FAIL=0" in printed


@needs_icarus
@needs_cocotb
def test_a_fault_in_the_rtl_fails_in_cocotb(tmp_path: Path) -> None:
    right = "assign m_axis_tdata = word;"
    code, printed = run_cocotb(tmp_path, broken_copy(tmp_path / "rtl", "axis_passed_out.v", right, right.replace(";", " ^ 1;")))
    assert code == 1, printed
    assert "m_axis_passed: beat 0 is 0x" in printed

# SPDX-License-Identifier: Apache-2.0
"""docs/hardware.md and the page of modules: made from the RTL as it is now, and examples that the tools take."""

from __future__ import annotations

import ctypes
import importlib.util
import re
import shutil
import subprocess
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from evcot.hardware.contract import Mode
from evcot.hardware.registers import register_map
from evcot_cosim.devices.base import reset
from evcot_cosim.pages.interfaces import DIAGRAMS
from evcot_cosim.pages.modules import page
from evcot_cosim.pages.stimulus import play
from evcot_cosim.pages.trace import Trace, wave
from evcot_cosim.rtl.build import load
from evcot_cosim.rtl.files import rtl_files, search_flags
from evcot_cosim.rtl.toolchain import find_toolchain

ROOT = Path(__file__).parents[2]
DOCS, EXAMPLES = ROOT / "docs", ROOT / "hw" / "fpga" / "examples"
WORDS = 1 << register_map().address_w - 2
COST = re.compile(r"^\| (?:on \||(?:N = 8, |\w+, )?(?:ECP5|iCE40|Xilinx|Gowin)).*\n", re.MULTILINE)


def test_a_diagram_of_a_stall_that_holds_nothing_up_is_refused() -> None:
    sim = load("skid_buffer")
    reset(sim)
    with pytest.raises(ValueError, match=r"^m_ready: stalled only where nothing is offered$"):
        play(Trace(sim, ()), 5, (), {"m_ready": (2, 3)})


@pytest.fixture(scope="module")
def modules() -> str:
    """The text of the page of modules."""
    return page()


def test_what_a_parameter_means_is_said_of_no_port(modules: str) -> None:
    """clk and rst stand right behind the parameters, without a word of their own."""
    assert "| `clk`" not in modules


def test_the_recorded_costs_stand_in_it(modules: str) -> None:
    assert len(COST.findall(modules)) > 20


def test_wave_says_a_value_once_and_repeats_it_with_dots() -> None:
    assert wave(["0", "1", "1", "=a", "=a", "=b", "x"]) == {"wave": "01.=.=x", "data": ["a", "b"]}


def test_the_page_shows_every_picture_and_its_links_lead_somewhere() -> None:
    text = (DOCS / "hardware.md").read_text()
    for name in DIAGRAMS:
        assert f"images/timing_{name}.svg" in text
    links = re.findall(r"\]\(([^)#]+)", text)
    assert len(links) > len(DIAGRAMS)
    for link in links:
        assert link.startswith("https://") or (DOCS / link).exists(), link


def test_the_block_diagram_names_modules_that_are_there() -> None:
    drawing = ElementTree.parse(DOCS / "images" / "evcot_top.svg")
    boxes = [node.text or "" for node in drawing.iter("{http://www.w3.org/2000/svg}text")]
    modules = [text for text in boxes if f"{text}.v" in rtl_files()]
    assert len(modules) == len(set(modules)) == 14
    text = "".join(rtl_files()[f"{top}.v"].read_text() for top in ("evcot_top", "event_sources", "cot_filtered"))
    for module in modules:
        assert re.search(rf"^\s*(?:module )?{module} #\(", text, re.MULTILINE), module


@pytest.mark.parametrize(
    ("top", "parameters"), [("kv260_evcot", {}), ("kv260_evcot", {"TRACKER": 2}), ("davis_evcot", {})], ids=str
)
def test_the_examples_are_clean(top: str, parameters: dict[str, int]) -> None:
    source = EXAMPLES / f"{top}.v"
    tools = find_toolchain()
    command = [str(tools.executable), "--lint-only", "-Wall", "--quiet", "--default-language", "1364-2005"]
    command += [*search_flags(), "--top-module", top, *(f"-G{name}={value}" for name, value in parameters.items()), str(source)]
    done = subprocess.run(command, env=tools.environment, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    if icarus := shutil.which("iverilog"):
        warnings = ["-Wall", "-Wno-sensitivity-entire-array"]  # see hw/lint.py
        settings = [f"-P{top}.{name}={value}" for name, value in parameters.items()]
        command = [icarus, "-g2005", *warnings, *search_flags(), *settings, "-o", "/dev/null", "-s", top, str(source)]
        assert subprocess.run(command, capture_output=True, text=True).stderr == ""


class Memory:
    """All addresses, which answer as an evcot_top of two slots which is never busy."""

    def __init__(self) -> None:
        self.words = np.zeros(WORDS, np.uint32)
        words = {word.name: word for word in register_map().words}
        self.words[words["id"].address // 4] = int.from_bytes(b"EVCT", "big")
        self.words[words["version"].address // 4] = register_map().version[0] << 16
        shape = {"n_slots": 2, "frac": 4, "x_w": 11, "y_w": 10, "tick_w": 20, "radix_w": 8, "nev_w": 10, "tc_w": 24,
                 "sup_w": 16, "id_w": 32, "seq_w": 48, "time_w": 48, "last_x": 1279, "last_y": 719, "stamp_w": 20}  # fmt: skip
        for word in words.values():
            for field in word.fields:
                if field.name in shape and word.address < 0x20:
                    self.words[word.address // 4] |= shape[field.name] << field.lsb

    def read(self, address: int) -> int:
        return int(self.words[address // 4])

    def write(self, address: int, value: int) -> None:
        self.words[address // 4] = value


def test_c_and_python_write_the_same_registers(tmp_path: Path) -> None:
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        pytest.skip("no C compiler")
    library = tmp_path / "configure.so"
    flags = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-shared", "-fPIC", f"-I{ROOT / 'hw' / 'include'}"]
    subprocess.run([compiler, *flags, "-o", library, EXAMPLES / "configure.c"], check=True)
    function = ctypes.CDLL(str(library)).evcot_configure
    function.restype = ctypes.c_uint32
    c, python = Memory(), Memory()
    assert function(ctypes.c_void_p(c.words.ctypes.data), 2) == 0
    assert function(ctypes.c_void_p(np.zeros(WORDS, np.uint32).ctypes.data), 2) == 0xFFFFFFFF  # nobody there

    spec = importlib.util.spec_from_file_location("configure_example", EXAMPLES / "configure.py")
    assert spec is not None
    assert spec.loader is not None
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    example.configure(python)

    bank = register_map().banks["slot"]
    commit = bank.base // 4 + bank.commit
    assert c.words[bank.base // 4] == Mode.SEEDED
    assert c.words[commit] == 1
    assert np.array_equal(c.words, python.words), np.flatnonzero(c.words != python.words) * 4


def test_python_reaches_mapped_memory(tmp_path: Path) -> None:
    spec = importlib.util.spec_from_file_location("configure_example", EXAMPLES / "configure.py")
    assert spec is not None
    assert spec.loader is not None
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    device = tmp_path / "uio0"
    device.write_bytes(bytes(1 << register_map().address_w))
    registers = example.Uio(device)
    registers.write(0x1040, 0x01020304)
    assert registers.read(0x1040) == 0x01020304
    assert device.read_bytes()[0x1040:0x1044] == bytes([4, 3, 2, 1])

# SPDX-License-Identifier: Apache-2.0
"""docs/hardware.md and the page of modules: made from the RTL as it is now, and examples that the tools take."""

from __future__ import annotations

import ctypes
import re
import shutil
import subprocess
from collections.abc import Callable
from dataclasses import astuple
from pathlib import Path
from types import ModuleType
from xml.etree import ElementTree

import numpy as np
import pytest

from evcot.hardware.classifier import RecognitionRegisters
from evcot.hardware.contract import Mode
from evcot.hardware.register_access import Registers
from evcot.hardware.registers import Transport, register_map
from evcot.hardware.streams import pack_events
from evcot.recognition.loading import load as load_weights
from evcot.recognition.weight_memory import memory_words
from evcot.recognition.weights import Weights
from evcot_cosim.devices.base import reset
from evcot_cosim.devices.top_device import address_of, slot_address
from evcot_cosim.pages.interfaces import DIAGRAMS
from evcot_cosim.pages.modules import page
from evcot_cosim.pages.trace import Trace, play, wave
from evcot_cosim.rtl.build import load
from evcot_cosim.rtl.files import rtl_files, search_flags
from evcot_cosim.rtl.toolchain import find_toolchain
from support.classifier_trials import random_network
from support.testing import module_at
from support.top import device_of

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
    assert "\n| `clk`" not in modules


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
    assert len(modules) == len(set(modules)) == 15
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


@pytest.fixture(scope="module")
def example_in_c(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., int]:
    """The functions of configure.c by name, with their accesses passed to a transport."""
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        pytest.skip("no C compiler")
    library = tmp_path_factory.mktemp("c") / "configure.so"
    access = ["-DEVCOT_READ(regs,address)=bus_read(address)", "-DEVCOT_WRITE(regs,address,value)=bus_write(address,value)"]
    bus = library.with_name("bus.h")
    bus.write_text("#include <stdint.h>\nuint32_t (*bus_read)(uint32_t);\nvoid (*bus_write)(uint32_t, uint32_t);\n")
    flags = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-Wno-unused-parameter", "-pedantic", "-shared", "-fPIC"]
    headers = [f"-I{ROOT / 'hw' / 'include'}", "-include", str(bus)]
    subprocess.run([compiler, *flags, *headers, *access, "-o", library, EXAMPLES / "configure.c"], check=True)
    loaded = ctypes.CDLL(str(library))
    readers, writers = (
        ctypes.CFUNCTYPE(ctypes.c_uint32, ctypes.c_uint32),
        ctypes.CFUNCTYPE(None, ctypes.c_uint32, ctypes.c_uint32),
    )

    def call(transport: Transport, function: str, *arguments: object) -> int:
        callbacks = readers(transport.read), writers(transport.write)
        for name, callback in zip(("bus_read", "bus_write"), callbacks, strict=True):
            ctypes.c_void_p.in_dll(loaded, name).value = ctypes.cast(callback, ctypes.c_void_p).value
        called = getattr(loaded, function)
        called.restype = ctypes.c_uint32
        return int(called(None, *arguments))

    return call


@pytest.fixture
def configure_in_c(example_in_c: Callable[..., int]) -> Callable[[Transport], int]:
    return lambda transport: example_in_c(transport, "evcot_configure")


def example_in_python() -> ModuleType:
    return module_at(EXAMPLES / "configure.py")


class Nobody:
    """All addresses read 0."""

    def read(self, address: int) -> int:
        return 0 * address

    def write(self, address: int, value: int) -> None:
        pass


def test_configure_in_c_is_strict_c99_without_an_access_of_its_own(tmp_path: Path) -> None:
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        pytest.skip("no C compiler")
    library = tmp_path / "configure.so"
    flags = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-shared", "-fPIC", f"-I{ROOT / 'hw' / 'include'}"]
    subprocess.run([compiler, *flags, "-o", library, EXAMPLES / "configure.c"], check=True)
    nobody = np.zeros(WORDS, np.uint32)
    function = ctypes.CDLL(str(library)).evcot_configure
    function.restype = ctypes.c_uint32
    assert function(ctypes.c_void_p(nobody.ctypes.data)) == 0xFFFF_FFFF


def test_c_and_python_load_weights_alike(example_in_c: Callable[..., int]) -> None:
    network = random_network(np.random.default_rng(60))
    recognition = RecognitionRegisters(window_log2=9, scale_start=77, shift_1=3, shift_2=5, margin_min=6)
    c, python = device_of("classifier"), device_of("classifier")
    words = memory_words(network)
    values = np.array(astuple(recognition), np.uint32)

    def load_in_c(device: Transport, count: int = len(words)) -> int:
        pointers = (ctypes.c_void_p(words.ctypes.data), ctypes.c_size_t(count), ctypes.c_void_p(values.ctypes.data))
        return example_in_c(device, "evcot_load_weights", *pointers)

    assert load_in_c(Nobody()) == load_in_c(c, len(words) - 1) == 0xFFFF_FFFF
    assert load_in_c(c) == 0
    load_weights(Registers(python), Weights(network, recognition, tuple(range(10))))
    bank = register_map().banks["classifier"]
    for place in (*(bank.base + 4 * register.address for register in bank.registers.values()), 0x06C):
        assert c.read(place) == python.read(place)
    assert Registers(c).classifier.enable == 1


@pytest.mark.parametrize("build", ["array", "motion"])
def test_c_and_python_set_up_the_simulated_hardware_alike(build: str, configure_in_c: Callable[[Transport], int]) -> None:
    c, python = device_of(build), device_of(build)
    assert configure_in_c(Nobody()) == 0xFFFF_FFFF
    assert configure_in_c(c) == 0
    registers = example_in_python().configure(python)
    bank = register_map().banks["slot"]
    places = [0x20, 0x44, *(bank.base + 4 * bank.words * i + 4 * k for i in range(registers.shape.n_slots) for k in range(16))]
    assert [c.read(place) for place in places] == [python.read(place) for place in places]
    assert registers.control.enable == registers.status.open == 1
    assert all(slot.mode == Mode.SEEDED for slot in registers.slot)
    for device in (c, python):  # three events of one pixel within a refractory time: that filter is built with motion
        device.run(pack_events(np.array([0, 5, 9]), *np.full((2, 3), 7, np.uint16), np.zeros(3, np.uint8)))
        Registers(device).control.latch = 1
        assert device.read(address_of("filtered")) == (2 if build == "motion" else 0)


def test_configure_in_c_reports_a_value_that_does_not_fit(configure_in_c: Callable[[Transport], int]) -> None:
    device = device_of("array behind filters")  # of 12 bits for 5,000 ticks
    assert configure_in_c(device) == slot_address(3, "detect_ticks") << 16 | 1
    assert device.read(0x20) == 0


def test_python_reaches_mapped_memory(tmp_path: Path) -> None:
    example = example_in_python()
    device = tmp_path / "uio0"
    device.write_bytes(bytes(1 << register_map().address_w))
    registers = example.Uio(device)
    registers.write(0x1040, 0x01020304)
    assert registers.read(0x1040) == 0x01020304
    assert device.read_bytes()[0x1040:0x1044] == bytes([4, 3, 2, 1])

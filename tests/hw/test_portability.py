# SPDX-License-Identifier: Apache-2.0
"""Benches, wrappers and scripts for other tools."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from evcot_cosim.fpga.interface import ports
from evcot_cosim.fpga.release import write_release
from evcot_cosim.rtl.files import search_flags, verilog_dir
from evcot_cosim.rtl.toolchain import find_toolchain
from support.four_state import needs_icarus
from support.testing import broken_copy, module_at, needs_yosys

BENCH = verilog_dir().parent / "fpga" / "examples" / "integrator_tb.v"


def icarus(folder: Path, verilog: Path) -> str:
    """What the bench prints in Icarus."""
    warnings = ["-Wall", "-Wno-sensitivity-entire-array", "-Wno-timescale"]
    command = ["iverilog", "-g2005", *warnings, *search_flags(verilog), "-s", "integrator_tb", "-o", "tb", str(BENCH)]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True)
    assert done.stderr == ""
    return subprocess.run(["vvp", "tb"], cwd=folder, capture_output=True, text=True, check=True, timeout=120).stdout


@needs_icarus
def test_it_passes_in_icarus(tmp_path: Path) -> None:
    assert icarus(tmp_path, verilog_dir()).splitlines()[0] == "PASS"


@needs_icarus
@pytest.mark.parametrize(
    ("file", "right", "wrong", "says"),
    [
        ("axis_records_out.v", "bytes[`EVCOT_RECORD_SUPPORT_LSB +: SUP_W] = s_cm_support;", "", "FAIL support"),
        ("axis_passed_out.v", "assign m_axis_tdata = word;", "assign m_axis_tdata = word << 1;", "FAIL passed.x"),
        ("axi_lite_words.v", "table_reg[31:0] <= id;", "table_reg[31:0] <= ~id;", "FAIL id"),
    ],
)  # fmt: skip
def test_it_notices_what_is_broken(tmp_path: Path, file: str, right: str, wrong: str, says: str) -> None:
    assert says in icarus(tmp_path, broken_copy(tmp_path / "rtl", file, right, wrong))


def test_verilator_elaborates_it(tmp_path: Path) -> None:
    tools = find_toolchain()
    command = [str(tools.executable), "--lint-only", "--timing", "-Wno-fatal", "--quiet", *search_flags(verilog_dir())]
    command += ["--top-module", "integrator_tb", str(BENCH)]
    done = subprocess.run(command, cwd=tmp_path, env=dict(tools.environment), capture_output=True, text=True, check=False)
    assert (done.returncode, "%Error" in done.stderr) == (0, False), done.stderr


EXAMPLES = verilog_dir().parent / "fpga" / "examples"
PARAMETERS = {"N": 3, "X_W": 8, "Y_W": 7, "WIDTH": 240, "HEIGHT": 100, "DATA_W": 64}


def example(name: str) -> ModuleType:
    return module_at(EXAMPLES / f"{name}.py")


def elaborated(folder: Path, text: str) -> str:
    """Complaints of Verilator about pins where this text, a module `wrapper`, instantiates evcot_top."""
    (folder / "wrapper.v").write_text(text)
    tools = find_toolchain()
    command = [str(tools.executable), "--lint-only", "-Wno-lint", "-Wno-style", "-Wno-TIMESCALEMOD", "-Wwarn-PINNOTFOUND"]
    command += [*search_flags(verilog_dir()), "--quiet-exit", "--top-module", "wrapper", "wrapper.v"]
    done = subprocess.run(command, cwd=folder, env=dict(tools.environment), capture_output=True, text=True, check=False)
    return done.stderr


@pytest.fixture(scope="module")
def amaranth_component() -> tuple[Any, str]:
    """The component, and the RTLIL of a design that consists of it: Amaranth complains of one that is in no design."""
    pytest.importorskip("amaranth", reason="amaranth is not installed (the `wrappers` extra)")
    from amaranth.back import rtlil

    component = example("evcot_amaranth").Evcot(**PARAMETERS)
    return component, rtlil.convert(component, name="wrapper")


def test_the_amaranth_component_is_elaborated(amaranth_component: tuple[Any, str]) -> None:
    component, text = amaranth_component
    assert "\\evcot_top" in text
    assert all(f"connect \\{name} " in text for name in (*component.signature.members, "clk", "rst"))
    assert all(f"parameter \\{name} " in text for name in PARAMETERS)


@needs_yosys
def test_the_amaranth_component_has_the_ports_of_the_module(amaranth_component: tuple[Any, str]) -> None:
    from amaranth.lib.wiring import In

    component, _ = amaranth_component
    has = {
        name: ("input" if member.flow is In else "output", member.shape) for name, member in component.signature.members.items()
    }
    wanted = {
        port.name: (port.direction, port.width) for port in ports("evcot_top", PARAMETERS) if port.name not in ("clk", "rst")
    }
    assert has == wanted


def test_the_litex_module_is_elaborated_with_the_rtl(tmp_path: Path) -> None:
    pytest.importorskip("litex", reason="litex is not installed (the `wrappers` extra)")
    from litex.gen.fhdl import verilog
    from migen import ClockDomain

    class Platform:
        sources: list[str] = []  # noqa: RUF012

        def add_source(self, path: str) -> None:
            self.sources.append(path)

    platform = Platform()
    module = example("evcot_litex").Evcot(platform, "evcot.v", **PARAMETERS)
    assert platform.sources == ["evcot.v"]
    module.cd_sys = ClockDomain("sys")
    ends = (module.events, module.records, *(getattr(module.bus, channel) for channel in ("aw", "w", "b", "ar", "r")))
    outside = {module.irq, *(signal for end in ends for signal in end.flatten())}
    text = str(verilog.convert(module, ios=outside, name="wrapper"))
    assert elaborated(tmp_path, text) == ""
    assert "PINNOTFOUND" in elaborated(tmp_path, text.replace(".irq", ".irqq"))


SCRIPTS = sorted((verilog_dir().parent / "fpga" / "scripts").glob("*.tcl"))
VERSIONS = {"vivado": "Vivado 2023.2", "quartus": "Quartus Prime Standard 22.1", "radiant": "Radiant 2023.2"}

# Prints every command that Tcl does not have, with its arguments, one to a line.
STUBS = """
proc unknown {args} { puts [join $args \\t] }
rename package tcl_package
proc package {args} {}
source [lindex $argv 0]
"""


@pytest.fixture(scope="module")
def release(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("release")
    write_release(folder)
    return folder


def commands(folder: Path, script: str) -> list[list[str]]:
    """What a script of a release calls."""
    if shutil.which("tclsh") is None:
        pytest.skip("tclsh is not installed")
    (folder / "stubs.tcl").write_text(STUBS)
    run = ["tclsh", "stubs.tcl", f"scripts/{script}"]
    done = subprocess.run(run, cwd=folder, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    return [line.split("\t") for line in done.stdout.splitlines()]


@pytest.mark.parametrize("script", [path.name for path in SCRIPTS])
def test_a_script_names_the_top_and_files_that_are_in_the_release(release: Path, script: str) -> None:
    words = [word for command in commands(release, script) for argument in command for word in argument.split()]
    files = {Path(word).relative_to(release).as_posix() for word in words if Path(word).suffix in (".v", ".sdc")}
    assert files == {"evcot.v", "examples/kv260_evcot.v", "scripts/kv260.sdc"}
    assert all((release / file).is_file() for file in files)
    assert (release / "examples" / "evcot_regs.vh").is_file()
    assert "kv260_evcot" in words
    assert str(release / "examples") in words


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.name)
def test_a_script_names_its_version_and_that_it_is_untested(path: Path) -> None:
    (version,) = (named for vendor, named in VERSIONS.items() if path.name.startswith(vendor))
    head = " ".join(line for line in path.read_text().splitlines() if line.startswith("#"))
    assert f"Written for {version}. Untested" in head
    assert re.search(r"[0-9]", version)


def test_there_is_one_for_each_vendor() -> None:
    assert [path.name.partition("_")[0] for path in SCRIPTS] == sorted(VERSIONS)


def test_a_file_that_is_missing_is_noticed(release: Path) -> None:
    text = (release / "scripts" / "vivado_kv260.tcl").read_text()
    (release / "scripts" / "broken.tcl").write_text(text.replace("/evcot.v", "/evcott.v"))
    words = [word for command in commands(release, "broken.tcl") for argument in command for word in argument.split()]
    assert str(release / "evcott.v") in words

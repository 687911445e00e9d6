# SPDX-License-Identifier: Apache-2.0
"""hw/fpga/examples: evcot_top in Amaranth and in LiteX; what they make is elaborated with the RTL by Verilator."""

from __future__ import annotations

import importlib.util
import subprocess
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from evcot_cosim.fpga.interface import ports
from evcot_cosim.rtl.files import search_flags, verilog_dir
from evcot_cosim.rtl.toolchain import find_toolchain
from support.testing import needs_yosys

EXAMPLES = verilog_dir().parent / "fpga" / "examples"
PARAMETERS = {"N": 3, "X_W": 8, "Y_W": 7, "WIDTH": 240, "HEIGHT": 100, "DATA_W": 64}


def example(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


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

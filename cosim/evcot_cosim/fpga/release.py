# SPDX-License-Identifier: Apache-2.0
"""Generator of the release: the whole RTL as one file, IP-XACT for each top, timing constraints, device-specific modules."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import evcot
from evcot.filters.contract import FILTER_SHAPE_RANGES, Filter
from evcot.hardware.contract import SHAPE_RANGES
from evcot.hardware.registers import register_map
from evcot.outputs import written_aside
from evcot.templating import templates

from ..devices.driver import PARAMETERS
from ..rtl.files import modules, rtl_files, verilog_dir
from .header import DeclaredPort, Header, evaluate, read
from .sources import flat

__all__ = ["CHOICES", "LIMITS", "TOPS", "Bus", "buses", "component", "dialogue", "release_text", "write_release"]


# IP-XACT 1685-2009 description of a module for Vivado's IP catalogue, with Xilinx bus types, for the single-file release.
#
# Its folder holds component.xml, and the parameter dialogue, which Vivado requires.

_SIGNALS = {
    "axis": ("tvalid", "tready", "tdata", "tkeep", "tuser", "tlast", "tid", "tdest", "tstrb"),
    "aximm": (
        *("awvalid", "awready", "awaddr", "awprot", "wvalid", "wready", "wdata", "wstrb", "bvalid", "bready", "bresp"),
        *("arvalid", "arready", "araddr", "arprot", "rvalid", "rready", "rdata", "rresp"),
    ),
}
_MARK = {"axis": "tvalid", "aximm": "awvalid"}
_ALWAYS = ("clk", "rst")  # inputs that are always connected

LIMITS: Mapping[str, tuple[int, int]] = {
    **{PARAMETERS[name]: (low, high) for name, (low, high, _) in SHAPE_RANGES.items()},
    **{name.upper(): (low, high) for name, (low, high, _) in FILTER_SHAPE_RANGES.items()},
    "HAS": (0, (1 << len(Filter)) - 1),
    "TICKS": (0, 3),
    "SOURCES": (1, (1 << len(register_map().sources)) - 1),
    "FIFO_DEPTH": (1, 16_384),
    "RECORD_DEPTH": (1, 16_384),
    "CLASSIFY": (0, 1),
}
"""Smallest and largest value of a parameter, by name."""

CHOICES: Mapping[str, Mapping[int, str]] = {
    "TRACKER": {i: f"cot_{name}" for i, name in enumerate(register_map().trackers)},
    "SOURCE": dict(enumerate(register_map().sources)),
    "DATA_W": {bits: f"{bits} bits" for bits in (32, 64, 128, 256)},
    "CELL_PX": {0: "a time stamp per pixel and filter", **{side: f"cells of {side} x {side} pixels" for side in (1, 2, 4)}},
}
"""The legal values of an enumerated parameter, and their labels."""


@dataclass(frozen=True)
class Bus:
    """One bus: signal -> port."""

    name: str
    kind: Literal["axis", "aximm"]
    mode: Literal["master", "slave"]
    ports: Mapping[str, str]


def buses(header: Header) -> list[Bus]:
    """The AXI4-Stream and AXI4-Lite buses among a module's ports, recognised by the suffixes of their names."""
    directions = {port.name: port.direction for port in header.ports}
    found = []
    kinds: tuple[Literal["axis", "aximm"], ...] = ("axis", "aximm")
    for kind in kinds:
        for name, direction in directions.items():
            prefix, _, signal = name.rpartition("_")
            if signal == _MARK[kind]:
                signals = {signal: f"{prefix}_{signal}" for signal in _SIGNALS[kind] if f"{prefix}_{signal}" in directions}
                found.append(Bus(prefix, kind, "slave" if direction == "in" else "master", signals))
    return found


def component(top: str, file: str, verilog: Path | None = None) -> str:
    """The text of component.xml for a module in `file`, a path relative to it.

    Raises:
        ConfigError: there is no such module.
    """
    header = read(top, verilog)
    values = header.values({})
    lefts = {port.name: evaluate(port.left, values) for port in header.ports if port.left is not None}
    return _rendered(
        "component.xml.j2",
        header=header,
        values=values,
        lefts=lefts,
        buses=buses(header),
        version=_version(),
        file=file,
        dialogue=dialogue_file(top),
        constraints=constraints_file(top, verilog),
        limits=LIMITS,
        choices={name: choice for name, choice in CHOICES.items() if name in values},
        tied={port.name: _tied(port, lefts) for port in header.ports if port.direction == "in" and port.name not in _ALWAYS},
        map_bytes={port.name: 2 << lefts[port.name] for port in header.ports if port.name.endswith("_awaddr")},
        dependency=_dependency,
    )


def constraints_file(top: str, verilog: Path | None = None) -> str:
    """Name of the constraints in the folder of an IP, relative to component.xml; empty if it has no asynchronous input.

    Raises:
        ConfigError: there is no such module.
    """
    return "evcot_ip.xdc" if any(port.name == "aer_req" for port in read(top, verilog).ports) else ""


def dialogue_file(top: str) -> str:
    """Path of the dialogue, relative to component.xml."""
    return f"xgui/{top}_v{_version().replace('.', '_')}.tcl"


def dialogue(top: str, verilog: Path | None = None) -> str:
    """The Tcl of the dialogue, which passes every user parameter to the module.

    Raises:
        ConfigError: there is no such module.
    """
    return _rendered("xgui.tcl.j2", header=read(top, verilog))


def _version() -> str:
    return evcot.__version__.rpartition(".")[0]


def _rendered(template: str, **values: Any) -> str:
    environment = templates("evcot_cosim.fpga", autoescape=template.endswith(".xml.j2"))
    return environment.get_template(template).render(**values)


def _tied(port: DeclaredPort, lefts: Mapping[str, int]) -> int:
    """Default of an input left open in a block design: outputs are accepted, beats are full, no chip requests."""
    if port.name.endswith("_tkeep"):
        return (2 << lefts[port.name]) - 1
    return int(port.name.endswith("ready") or port.name == "aer_req")


def _dependency(expression: str, kind: Literal["MODELPARAM_VALUE", "PARAM_VALUE"]) -> str:
    """Translate a Verilog expression to the XPath that Vivado evaluates; of functions, only a slot number's width is known."""
    steps = " + ".join(rf"(\1 > {1 << bit})" for bit in range(1, (LIMITS["N"][1] - 1).bit_length()))
    text = re.sub(r"\(?(\w+) > 1\)? \? \$clog2\(\1\) : 1", f"1 + {steps}", expression).replace("/", " div ")
    return re.sub(r"\b[A-Z]\w*\b", lambda found: f"spirit:decode(id('{kind}.{found[0]}'))", text)


TOPS = ("evcot_top", "cot_array")
"""Modules that are described for Vivado."""

_HEADER = """\
// SPDX-License-Identifier: Apache-2.0
// evcot {version}: all RTL modules in one file, plain Verilog-2005, no includes and no vendor primitives.
//
// {count} modules, each after those that it instantiates. Pick a top: evcot_top (standard buses), cot_array (tokens in),
// or a single filter or decoder; the header of each says its latency, throughput, stalls and reset.
// Generated from hw/verilog by `python -m evcot_cosim.fpga --release`: edit there.
/* verilator lint_off DECLFILENAME */

"""


def release_text(verilog: Path | None = None) -> str:
    """The release as text."""
    names = modules(verilog)
    return _HEADER.format(version=evcot.__version__, count=len(names)) + flat(names, verilog, comments=True)


_PAGES = ("hardware.md", "registers.md", "motion.md")
_LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^)#]+)(#[^)]*)?\)")


def _papers(root: Path) -> dict[str, bytes]:
    """Files for users of the hardware, besides the RTL. Links of a page to what is not in the release become text."""
    files = {path.name: path.read_bytes() for path in (root / "LICENSE", root / "hw" / "include" / "evcot_regs.h")}

    def link(found: re.Match[str]) -> str:
        image, text, target, _ = found.groups()
        if image:
            files[target] = (root / "docs" / target).read_bytes()
        return found[0] if image or target in _PAGES or "://" in target else text

    pages = {name: _LINK.sub(link, (root / "docs" / name).read_text(encoding="utf-8")).encode() for name in _PAGES}
    return files | pages


def write_release(folder: Path, verilog: Path | None = None) -> list[Path]:
    """Write the release to a new folder: evcot.v, constraints, ecp5/, examples/, scripts/, ip/TOP/ with a copy of evcot.v.

    Raises:
        OutputError: a file cannot be written.
    """
    text = release_text(verilog).encode()
    files = {"evcot.v": text}
    boards = (verilog or verilog_dir()).parent / "fpga"
    files |= {path.name: path.read_bytes() for path in sorted((boards / "constraints").iterdir())}
    files |= _papers(boards.parents[1])
    for path in sorted((boards / "ecp5").iterdir()):
        files[f"ecp5/{path.name}"] = path.read_bytes()
    for folder_name in ("examples", "scripts"):
        for path in sorted(path for path in (boards / folder_name).iterdir() if path.is_file()):
            files[f"{folder_name}/{path.name}"] = path.read_bytes()
    files["examples/evcot_regs.vh"] = rtl_files(verilog)["evcot_regs.vh"].read_bytes()
    for top in TOPS:
        files[f"ip/{top}/evcot.v"] = text
        files[f"ip/{top}/component.xml"] = component(top, "evcot.v", verilog).encode()
        files[f"ip/{top}/{dialogue_file(top)}"] = dialogue(top, verilog).encode()
        if name := constraints_file(top, verilog):
            files[f"ip/{top}/{name}"] = files[name]
    for name, content in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        with written_aside(path, force=True) as file:
            file.write(content)
    return [folder / name for name in files]

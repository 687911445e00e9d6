# SPDX-License-Identifier: Apache-2.0
"""A module described for Vivado's IP catalogue: IP-XACT 1685-2009 with Xilinx' bus types, beside the single-file release."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from jinja2 import Environment, PackageLoader, StrictUndefined

import evcot

from .header import Header, evaluate, read

__all__ = ["Bus", "buses", "component"]

_SIGNALS = {
    "axis": ("tvalid", "tready", "tdata", "tkeep", "tuser", "tlast", "tid", "tdest", "tstrb"),
    "aximm": (
        *("awvalid", "awready", "awaddr", "awprot", "wvalid", "wready", "wdata", "wstrb", "bvalid", "bready", "bresp"),
        *("arvalid", "arready", "araddr", "arprot", "rvalid", "rready", "rdata", "rresp"),
    ),
}
_MARK = {"axis": "tvalid", "aximm": "awvalid"}


@dataclass(frozen=True)
class Bus:
    """Ports that are one bus: signal to port."""

    name: str
    kind: Literal["axis", "aximm"]
    mode: Literal["master", "slave"]
    ports: Mapping[str, str]


def buses(header: Header) -> list[Bus]:
    """The AXI4-Stream and AXI4-Lite buses among a module's ports, told by the ends of their names."""
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
    """The text of component.xml for a module that stands in `file`, a path relative to it.

    Raises:
        ConfigError: there is no such module.
    """
    header = read(top, verilog)
    values = header.values({})
    lefts = {port.name: evaluate(port.left, values) for port in header.ports if port.left is not None}
    environment = Environment(
        loader=PackageLoader("evcot_cosim"), undefined=StrictUndefined, keep_trailing_newline=True, autoescape=True
    )
    return environment.get_template("component.xml.j2").render(
        header=header,
        values=values,
        lefts=lefts,
        buses=buses(header),
        version=evcot.__version__.rpartition(".")[0],
        file=file,
        map_bytes={port.name: 2 << lefts[port.name] for port in header.ports if port.name.endswith("_awaddr")},
        dependency=_dependency,
    )


def _dependency(expression: str, kind: Literal["MODELPARAM_VALUE", "PARAM_VALUE"]) -> str:
    """A Verilog expression as the XPath that Vivado evaluates; the derived width of a slot number is its only function."""
    text = re.sub(r"\(?(\w+) > 1\)? \? \$clog2\(\1\) : 1", r"ceil(log(2, \1 + (\1 = 1)))", expression)
    text = re.sub(r"\b(ceil|log)\(", r"spirit:\1(", text).replace("/", " div ")
    return re.sub(r"(?<!:)\b[A-Z]\w*\b", lambda found: f"spirit:decode(id('{kind}.{found[0]}'))", text)

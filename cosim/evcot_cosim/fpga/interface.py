# SPDX-License-Identifier: Apache-2.0
"""Ports and parameters of a module, as elaborated by Yosys."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from . import tools
from .sources import closure, flat

__all__ = ["Port", "elaborate", "instance", "ports"]


@dataclass(frozen=True)
class Port:
    """One port of `width` bits; `vector`: whether it is declared with a range, even of one bit."""

    name: str
    direction: Literal["input", "output"]
    width: int


def instance(top: str, parameters: Mapping[str, int]) -> list[str]:
    """Yosys commands that elaborate `top` with these parameters from a design that was read with -defer."""
    chosen = [f"chparam -set {name} {value} $abstract\\{top}" for name, value in parameters.items()]
    return [*chosen, f"hierarchy -check -top {top}"]


def elaborate(top: str, parameters: Mapping[str, int], verilog: Path | None = None) -> dict[str, object]:
    """Yosys' JSON of one module with these parameters.

    Raises:
        ToolchainError: Yosys is missing, or refuses the parameters.
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "design.v").write_text(flat(closure([top], verilog), verilog))
        script = ["read_verilog -defer design.v", *instance(top, parameters), "proc", "write_json design.json"]
        tools.yosys(script, folder)
        modules = json.loads((folder / "design.json").read_text())["modules"]
    found: dict[str, object] = next(module for module in modules.values() if int(module["attributes"].get("top", "0"), 2))
    return found


def ports(top: str, parameters: Mapping[str, int], verilog: Path | None = None) -> list[Port]:
    """The ports of a module with these parameters, in order of declaration."""
    found = elaborate(top, parameters, verilog)["ports"]
    assert isinstance(found, dict)
    return [Port(name, port["direction"], len(port["bits"])) for name, port in found.items()]

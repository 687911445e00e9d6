# SPDX-License-Identifier: Apache-2.0
"""Ports, parameters and combinational paths of a module as Yosys elaborates it, and the harness in which it is measured."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from evcot.templating import templates

from ..rtl.files import modules, rtl_files, search_flags, verilog_dir
from . import tools
from .sources import closure, flat

__all__ = ["HARNESS", "Port", "combinational_paths", "elaborate", "harness_text", "instance", "ports"]


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


_BITWISE = ("$and", "$or", "$xor", "$xnor", "$not", "$pos")
_SILENT = ("$scopeinfo", "$check", "$print", "$assert")


def combinational_paths(
    tops: Iterable[str], folder: Path, sources: Iterable[Path] | None = None
) -> dict[str, dict[str, set[str]]]:
    """For each module: output -> the inputs that it depends on within a clock; outputs that depend on none are left out.

    Args:
        tops: names of modules.
        folder: an existing folder for intermediate files.
        sources: the files of the modules and of all that they need; absolute, or relative to `folder`; the whole RTL if None.

    Raises:
        ToolchainError: Yosys is missing, or refuses a module.
    """
    files, tops = rtl_files(), list(tops)
    includes = " ".join(flag for flag in search_flags(verilog_dir()) if flag.startswith("-I"))
    read = " ".join(str(path) for path in sources or [files[f"{name}.v"] for name in modules()])
    script = [f"read_verilog -defer {includes} {read}", "design -save all"]
    for top in tops:
        script += ["design -load all", f"hierarchy -top {top}", "setattr -mod -unset keep_hierarchy *"]
        script += ["proc", "flatten", "memory_collect", "opt_clean"]
        script.append(f"write_json {top}.json")
    tools.yosys(script, folder)
    return {top: _paths(json.loads((folder / f"{top}.json").read_text())["modules"]) for top in tops}


def _paths(design: dict[str, Any]) -> dict[str, set[str]]:
    module = next(module for module in design.values() if int(module["attributes"].get("top", "0"), 2))
    sources: dict[int, list[int]] = {}
    for cell in module["cells"].values():
        for out, inputs in _arcs(cell):
            if isinstance(out, int):
                sources.setdefault(out, []).extend(bit for bit in inputs if isinstance(bit, int))
    named = {bit: name for name, port in module["ports"].items() if port["direction"] == "input" for bit in port["bits"]}
    found = {}
    for name, port in module["ports"].items():
        if port["direction"] == "output":
            waiting, seen = [bit for bit in port["bits"] if isinstance(bit, int)], set[int]()
            while waiting:
                bit = waiting.pop()
                if bit not in seen:
                    seen.add(bit)
                    waiting += sources.get(bit, ())
            found[name] = {named[bit] for bit in seen if bit in named}
    return {name: inputs for name, inputs in found.items() if inputs}


def _arcs(cell: dict[str, Any]) -> Iterator[tuple[int | str, list[int | str]]]:
    """A bit that a cell drives, and the bits that it follows at once."""
    kind, pins, directions = cell["type"], cell["connections"], cell["port_directions"]
    if "dff" in kind or kind in _SILENT:
        return
    inputs = [name for name in pins if directions[name] == "input"]
    if kind == "$mem_v2":
        ports, address_w, width = (int(cell["parameters"][name], 2) for name in ("RD_PORTS", "ABITS", "WIDTH"))
        clocked = cell["parameters"]["RD_CLK_ENABLE"][::-1]
        for i in (i for i in range(ports) if clocked[i] == "0"):
            for bit in pins["RD_DATA"][i * width : (i + 1) * width]:
                yield bit, pins["RD_ADDR"][i * address_w : (i + 1) * address_w]
        return
    for name in (name for name in pins if directions[name] == "output"):
        for i, bit in enumerate(pins[name]):
            if kind in _BITWISE:
                yield bit, [pins[other][min(i, len(pins[other]) - 1)] for other in inputs]
            elif kind == "$mux":
                yield bit, [pins["A"][i], pins["B"][i], pins["S"][0]]
            elif kind == "$pmux":
                yield bit, [pins["A"][i], *pins["S"], *pins["B"][i :: len(pins[name])]]
            else:
                yield bit, [one for other in inputs for one in pins[other]]


# Measurement harness around a module: two pins, and registers at every port.
#
# All inputs come from one shift register at pin d. All outputs are registered and reduced to pin q by a tree of exclusive ors
# with a register at each level. So each path of the module begins and ends at a register, and no pin limits Fmax. The module's
# hierarchy is kept in synthesis: its cells are counted without the harness, and there is no optimisation across its boundary.

HARNESS = Path(__file__).with_name("templates") / "harness.v.j2"
_CLOCK = "clk"
_FOLD = 4  # inputs of a look-up table


def harness_text(top: str, parameters: Mapping[str, int], ports: Sequence[Port]) -> str:
    """The harness as Verilog, module `harness`, around `top`."""
    inputs = [port for port in ports if port.direction == "input" and port.name != _CLOCK]
    outputs = [port for port in ports if port.direction == "output"]
    levels = [sum(port.width for port in outputs)]
    while levels[-1] > 1:
        levels.append(-(-levels[-1] // _FOLD))
    return (
        templates("evcot_cosim.fpga")
        .get_template(HARNESS.name)
        .render(
            top=top,
            parameters=parameters,
            clock=_CLOCK,
            clocked=any(port.name == _CLOCK for port in ports),
            inputs=_placed(inputs),
            n_inputs=max(1, sum(port.width for port in inputs)),
            outputs=_placed(outputs),
            levels=levels,
            fold=_FOLD,
        )
    )


def _placed(ports: Sequence[Port]) -> list[tuple[Port, int, int]]:
    """Each port with its highest and lowest bit in the concatenation of all."""
    placed, low = [], 0
    for port in ports:
        placed.append((port, low + port.width - 1, low))
        low += port.width
    return placed

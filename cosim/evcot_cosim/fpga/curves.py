# SPDX-License-Identifier: Apache-2.0
"""The picture of docs/fpga.md: LUTs, Fmax and latency over the number of slots."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure as Picture

from evcot.outputs import written_aside

from .devices import DEVICES
from .figures import Figure, Figures, case_name
from .report import PUBLISHED_NS

__all__ = ["draw"]

_COLOURS = {"cot_chain": "#009E73", "cot_array": "#0072B2"}
_MARKERS = {"ecp5-25": "o", "ecp5-45": "s", "ecp5-85": "D"}
_INK = "#333333"
_STYLE: dict[Any, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": _INK,
    "axes.titlesize": 10,
    "axes.titlelocation": "left",
    "axes.titleweight": "bold",
    "legend.frameon": False,
    "legend.fontsize": 8,
}


def draw(figures: Figures, clocks: Mapping[str, int], path: Path, outdated: Collection[str] = ()) -> None:
    """Draw LUTs, Fmax and latency over N, on ECP5; with hollow points the figures of a module that has changed since.

    Args:
        outdated: their names.

    Raises:
        OutputError: the file cannot be written.
    """
    rows = [row for row in figures.values() if row.module in _COLOURS and row.n is not None and row.device in _MARKERS]
    with matplotlib.rc_context(_STYLE):
        picture = Picture(figsize=(13, 4.1), dpi=150, facecolor="white", layout="constrained")
        FigureCanvasAgg(picture)
        luts, fmax, latency = picture.subplots(1, 3)
        luts.set_title("(a) LUTs")
        fmax.set_title("(b) Fmax, MHz: median and range over seeds")
        latency.set_title("(c) event in to record out, ns")
        for module, colour in _COLOURS.items():
            here = sorted((row for row in rows if row.module == module), key=lambda row: row.n or 0)
            smallest = list({row.n: row for row in reversed(here)}.values())[::-1]  # of each N the smallest device
            _points(luts, smallest, [row.luts for row in smallest], outdated, color=colour, marker="o", label=module)
            _fmax(fmax, module, here, colour, outdated)
            routed = list({row.n: row for row in reversed(here) if row.median_mhz}.values())[::-1]
            timed = [row for row in routed if case_name(module, row.n) in clocks]
            times = [clocks[case_name(module, row.n)] / (row.median_mhz or 1.0) * 1e3 for row in timed]
            _points(latency, timed, times, outdated, color=colour, marker="o", label=module)
        for (name, _, ns), (n, side) in zip(PUBLISHED_NS[1:], ((64, "right"), (1, "left"), (64, "right")), strict=True):
            latency.axhline(float(ns), color=_INK, linewidth=0.8, linestyle="dashed")
            latency.text(n, float(ns) * 1.05, name.replace(", ", ",\n"), fontsize=7, color=_INK, ha=side)
        capacity = DEVICES["ecp5-25"].capacity
        assert capacity is not None
        luts.axhline(capacity.luts, color=_INK, linewidth=0.8, linestyle="dashed")
        luts.text(1, capacity.luts * 1.08, "ECP5-25 has", fontsize=7, color=_INK)
        for axes in (luts, fmax, latency):
            axes.set(xlabel="N, tracker slots", xscale="log", xticks=(1, 2, 4, 8, 16, 32, 64))
            axes.xaxis.set_major_formatter("{x:g}")
            axes.grid(linewidth=0.3)
        fmax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=2)  # of all three
        luts.set(yscale="log", ylim=(1_000, max(50_000, luts.get_ylim()[1])))
        luts.yaxis.set_major_formatter("{x:,.0f}")
        fmax.set(ylim=(0, 1.1 * fmax.get_ylim()[1]))
        latency.set(yscale="log", ylim=(50, max(1_000, latency.get_ylim()[1])), yticks=(50, 100, 200, 500, 1_000))
        latency.yaxis.set_major_formatter("{x:,.0f}")
        for axes in (luts, fmax, latency):
            axes.minorticks_off()
        with written_aside(path, force=True) as file:
            picture.savefig(file, format="png")


def _points(axes: Axes, rows: Sequence[Figure], values: Sequence[float], outdated: Collection[str], **look: Any) -> None:
    """A line with a point for each figure; hollow where it is outdated."""
    sizes = [row.n or 0 for row in rows]
    axes.plot(sizes, values, markersize=4, linewidth=1, **look)
    old = [i for i, row in enumerate(rows) if row.name in outdated]
    look = look | {"label": None, "linestyle": "none", "markerfacecolor": "white"}
    axes.plot([sizes[i] for i in old], [values[i] for i in old], markersize=4, zorder=3, **look)


def _fmax(axes: Axes, module: str, rows: list[Figure], colour: str, outdated: Collection[str]) -> None:
    for device, marker in _MARKERS.items():
        here = [row for row in rows if row.device == device and row.median_mhz]
        if not here:
            continue
        middle = [row.median_mhz or 0.0 for row in here]
        low = [at - min(row.fmax_mhz) for at, row in zip(middle, here, strict=True)]
        high = [max(row.fmax_mhz) - at for at, row in zip(middle, here, strict=True)]
        sizes = [row.n or 0 for row in here]
        axes.errorbar(sizes, middle, yerr=[low, high], color=colour, linestyle="none", linewidth=1, capsize=2)
        _points(axes, here, middle, outdated, color=colour, marker=marker, label=f"{module}, {device}")

# SPDX-License-Identifier: Apache-2.0
"""The picture of docs/fpga.md: LUTs, Fmax and latency over the number of slots."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure as Picture

from evcot.outputs import written_aside

from .devices import DEVICES
from .figures import Figure, Figures
from .report import PUBLISHED_NS, latency_name

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


def draw(figures: Figures, clocks: Mapping[str, int], path: Path) -> None:
    """Draw LUTs, Fmax and latency over N, on ECP5.

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
            counts = {row.n: row.luts for row in here}
            luts.plot(list(counts), list(counts.values()), color=colour, marker="o", markersize=4, label=module)
            _fmax(fmax, module, here, colour)
            routed = {row.n: row.median_mhz for row in reversed(here) if row.median_mhz}  # of each N the smallest device
            names = {n: latency_name(module, n) for n in sorted(routed, key=lambda n: n or 0)}
            times = {n: clocks[name] / routed[n] * 1e3 for n, name in names.items() if name in clocks}
            latency.plot(list(times), list(times.values()), color=colour, marker="o", markersize=4, label=module)
        for (name, _, ns), (n, side) in zip(PUBLISHED_NS[1:], ((64, "right"), (1, "left"), (64, "right")), strict=True):
            latency.axhline(float(ns), color=_INK, linewidth=0.8, linestyle="dashed")
            latency.text(n, float(ns) * 1.05, name.replace(", ", ",\n"), fontsize=7, color=_INK, ha=side)
        smallest = DEVICES["ecp5-25"].capacity
        assert smallest is not None
        luts.axhline(smallest.luts, color=_INK, linewidth=0.8, linestyle="dashed")
        luts.text(1, smallest.luts * 1.08, "ECP5-25 has", fontsize=7, color=_INK)
        for axes in (luts, fmax, latency):
            axes.set(xlabel="N, tracker slots", xscale="log", xticks=(1, 2, 4, 8, 16, 32, 64))
            axes.xaxis.set_major_formatter("{x:g}")
            axes.grid(linewidth=0.3)
            axes.legend()
        luts.set(yscale="log", ylim=(1_000, max(50_000, luts.get_ylim()[1])))
        luts.yaxis.set_major_formatter("{x:,.0f}")
        fmax.set(ylim=(0, 1.1 * fmax.get_ylim()[1]))
        latency.set(yscale="log", ylim=(50, max(1_000, latency.get_ylim()[1])), yticks=(50, 100, 200, 500, 1_000))
        latency.yaxis.set_major_formatter("{x:,.0f}")
        for axes in (luts, fmax, latency):
            axes.minorticks_off()
        with written_aside(path, force=True) as file:
            picture.savefig(file, format="png")


def _fmax(axes: Axes, module: str, rows: list[Figure], colour: str) -> None:
    for device, marker in _MARKERS.items():
        here = [row for row in rows if row.device == device and row.median_mhz]
        if not here:
            continue
        middle = [row.median_mhz or 0.0 for row in here]
        low = [at - min(row.fmax_mhz) for at, row in zip(middle, here, strict=True)]
        high = [max(row.fmax_mhz) - at for at, row in zip(middle, here, strict=True)]
        axes.errorbar(
            [row.n or 0 for row in here], middle, yerr=[low, high], color=colour, marker=marker, markersize=4,
            linewidth=1, capsize=2, label=f"{module}, {device}",
        )  # fmt: skip

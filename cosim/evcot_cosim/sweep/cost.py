# SPDX-License-Identifier: Apache-2.0
"""Cost of the hardware on an FPGA, from the figures that `make fpga` has measured: a run of a sweep needs no synthesis."""

from __future__ import annotations

from functools import cache

import numpy as np

from ..fpga.figures import Figure, load
from ..rtl.files import verilog_dir

__all__ = ["DEVICE", "hardware_cost"]

DEVICE = "ecp5-85"  # holds every size of every module


@cache
def _figures(module: str) -> tuple[Figure, ...]:
    """The figures of a module on the device, by number of slots; empty in an installation without the repository's figures."""
    figures = load(verilog_dir().parent / "fpga" / "figures.json").values()
    return tuple(sorted((row for row in figures if (row.module, row.device) == (module, DEVICE)), key=lambda row: row.n or 1))


def hardware_cost(module: str, slots: int) -> dict[str, float]:
    """LUTs, flip-flops, block RAMs and median Fmax of a module in its default widths, without filters.

    Interpolated between two measured numbers of slots; beyond them unknown.
    """
    rows = _figures(module)
    sizes = [row.n or 1 for row in rows]
    if not sizes or not sizes[0] <= slots <= sizes[-1]:
        return {}
    cost = {
        "luts": float(np.interp(slots, sizes, [row.luts for row in rows])),
        "ffs": float(np.interp(slots, sizes, [row.ffs for row in rows])),
        "block_rams": float(np.interp(slots, sizes, [row.block_rams for row in rows])),
    }
    routed = [(row.n or 1, row.median_mhz) for row in rows if row.median_mhz]
    if routed and routed[0][0] <= slots <= routed[-1][0]:
        cost["fmax_mhz"] = float(np.interp(slots, [n for n, _ in routed], [mhz for _, mhz in routed]))
    return cost

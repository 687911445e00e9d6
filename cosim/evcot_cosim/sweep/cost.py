# SPDX-License-Identifier: Apache-2.0
"""Cost of the hardware on an FPGA, from the figures that `make fpga` has measured: a run of a sweep needs no synthesis."""

from __future__ import annotations

from functools import cache

import numpy as np

from ..fpga.devices import DEVICES
from ..fpga.figures import Figure, load
from ..rtl.files import verilog_dir

__all__ = ["hardware_cost"]

_FAMILY = DEVICES["ecp5-25"].synthesis


@cache
def _figures(module: str) -> tuple[Figure, ...]:
    """The figures of a module on an ECP5 by number of slots, each on the smallest that it was routed for if there is one.

    Empty in an installation without the repository's figures.
    """
    by_size: dict[int, Figure] = {}
    for row in load(verilog_dir().parent / "fpga" / "figures.json").values():
        if row.module == module and row.device in DEVICES and DEVICES[row.device].synthesis == _FAMILY:
            known = by_size.get(row.n or 1)
            if known is None or not known.fmax_mhz:
                by_size[row.n or 1] = row
    return tuple(by_size[size] for size in sorted(by_size))


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

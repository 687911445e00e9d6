# SPDX-License-Identifier: Apache-2.0
"""The reset of a simulated module."""

from __future__ import annotations

from pyverilator import PyVerilator

__all__ = ["reset"]


def reset(sim: PyVerilator, clocks: int = 2) -> None:
    """Holds rst high for some clocks."""
    sim.io.rst = 1
    for _ in range(clocks):
        sim.clock.tick()
    sim.io.rst = 0

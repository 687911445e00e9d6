# SPDX-License-Identifier: Apache-2.0
"""How many clocks pass from an event to the answer, measured on the RTL with nothing else under way."""

from __future__ import annotations

from dataclasses import replace
from typing import cast

import numpy as np

from evcot.config import CotConfig, SlotConfig
from evcot.contract import Mode, Shape

from ..build import load
from ..device import Device, Stalls, Top
from ..testing import reset
from .catalogue import Module

__all__ = ["clocks"]

_EVENTS = 20
_APART = 512  # clocks between two events: longer than any module takes
_PATIENCE = 100_000  # clocks for a module to become ready after reset

# One event moves the centre.
_SLOT = SlotConfig(
    mode=Mode.SEEDED, init_radix=8, radix_th=4, radix_step=0, radix_min=8, radix_max=8, hist_avg=0, max_ticks=1 << 20,
    clust_nev=1, nev_min=1, nev_max=1, nev_th=1 << 20, detect_ticks=1 << 20,
)  # fmt: skip


def clocks(module: Module, n: int | None) -> int | None:
    """From the clock edge that takes an event to the one that hands over the answer; None where no answer is defined.

    The answer is the record of the centre that the event moves, in the last of all slots, or the event itself at the output.
    """
    if module.answer == "record":
        return _to_record(cast(Top, module.top), n or 1)
    return _to_token(module) if module.answer == "token" else None


def _to_record(top: Top, n: int) -> int:
    off = replace(_SLOT, mode=Mode.OFF)
    config = CotConfig(Shape(n_slots=n, tick_w=1), (*(off,) * (n - 1), _SLOT))
    now_and_then = np.zeros(_APART, np.uint8)
    now_and_then[0] = 1
    device = Device(config, top, stalls=Stalls(source=now_and_then))
    still = np.full(_EVENTS, 100, np.uint16)
    decisions, times = device.stream_timed(np.arange(1, _EVENTS + 1), still, still, np.zeros(_EVENTS, np.uint8))
    cause = decisions.records["seq"].astype(np.int64)
    return int(np.median(times.recorded - times.accepted[cause]))


def _to_token(module: Module) -> int:
    sim = load(module.top, module.parameters)
    reset(sim)
    io = sim.io
    io.m_ready = 1
    for _ in range(_PATIENCE):
        if io.s_ready and io.idle:
            break
        sim.clock.tick()
    io.s_valid = io.s_event = 1
    sim.clock.tick()
    io.s_valid = 0
    for passed in range(1, _APART):
        if io.m_valid:
            return passed
        sim.clock.tick()
    raise AssertionError(f"{module.name}: an event went in and nothing came out")

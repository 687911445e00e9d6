# SPDX-License-Identifier: Apache-2.0
"""Latency of an idle module in clocks, from an event to the corresponding output, measured on the RTL."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import cast

import numpy as np
from pyverilator import PyVerilator

from evcot.hardware.config import CotConfig, SlotConfig
from evcot.hardware.contract import Mode, Shape
from evcot.hardware.modules import Module as Tracker
from evcot.hardware.published.model import PublishedConfig, decode
from evcot.hardware.streams import pack_events
from evcot.ticks import TickedEvents

from ..devices.base import Stalls, reset
from ..devices.device import Device
from ..devices.published_device import LIBRARY, at, play
from ..devices.top_device import TopDevice
from ..rtl.build import load
from .catalogue import Answer, Module

__all__ = ["clocks"]

_EVENTS = 20
_APART = 512  # clocks between two events: longer than any module takes
_PATIENCE = 100_000  # clocks: longer than any memory takes to become empty after reset
_PLACE = 100  # where events are, x and y

# One event moves the centre.
_SLOT = SlotConfig(
    mode=Mode.SEEDED, init_radix=8, radix_th=4, radix_step=0, radix_min=8, radix_max=8, hist_avg=0, max_ticks=1 << 20,
    clust_nev=1, nev_min=1, nev_max=1, nev_th=1 << 20, detect_ticks=1 << 20,
)  # fmt: skip
_PUBLISHED = PublishedConfig(init_cm_high=_PLACE, init_cm_low=_PLACE, nev_th=1)

# A time mark and an event of it: data and keep of each beat.
_EVT_BEATS = {
    "evt2_decoder": ((8 << 28, 15), (1 << 28, 15)),
    "evt21_decoder": ((8 << 60, 255), (1 << 60 | 1, 255)),
    "evt3_decoder": ((8 << 12, 3), (6 << 12, 3), (0 << 12, 3), (2 << 12, 3)),
}


def clocks(module: Module, n: int | None) -> int | None:
    """Clocks from the edge that accepts an event to the edge that transfers the output; None if no output is defined.

    `catalogue.Answer` defines both.
    """
    return None if module.answer is None else _MEASURES[module.answer](module, n)


def _to_record(module: Module, n: int | None) -> int:
    now_and_then = np.zeros(_APART, np.uint8)
    now_and_then[0] = 1
    device = Device(_last_of(n or 1, cast(Tracker, module.top), tick_w=1), stalls=Stalls(source=now_and_then))
    still = np.full(_EVENTS, _PLACE, np.uint16)
    events = TickedEvents(np.arange(1, _EVENTS + 1), still, still, np.zeros(_EVENTS, np.uint8))
    decisions, times = device.stream_timed(events)
    cause = decisions.records["seq"].astype(np.int64)
    return int(np.median(times.recorded - times.accepted[cause]))


def _last_of(n_slots: int, module: Tracker = "cot_array", **shape: int) -> CotConfig:
    """Register settings with only the last slot enabled."""
    off = replace(_SLOT, mode=Mode.OFF)
    return CotConfig(Shape(n_slots=n_slots, **shape), (*(off,) * (n_slots - 1), _SLOT), module=module)


def _to_beat(module: Module, n: int | None) -> int:
    device = TopDevice(_last_of(n or 1), module.parameters)
    device.configure()
    found = []
    for t_us in range(_EVENTS):
        run = device.run(pack_events(*(np.array([value]) for value in (t_us, _PLACE, _PLACE, 0))), quiet_clocks=_APART)
        found += (run.recorded - run.accepted).tolist()
    return int(np.median(found))


def _to_centre(module: Module, n: int | None) -> int:
    elsewhere = replace(_PUBLISHED, init_cm_low=2 * _PLACE)
    requested = _APART
    played = play(at([requested], _PLACE, _PLACE), elsewhere, elsewhere, elsewhere, _PUBLISHED, top=LIBRARY)
    return int(played.word_clock[~decode(played.word)["event"]][0]) - requested


def _to_token(module: Module, n: int | None) -> int:
    sim = _fresh(module, m_ready=1)
    _offer(sim, "s_", [{"s_event": 1}])
    return 1 + _wait(sim, "m_valid", 1)


def _to_event(module: Module, n: int | None) -> int:
    sim = _fresh(module, m_ready=1)
    _offer(sim, "s_axis_t", [{"s_axis_tdata": data, "s_axis_tkeep": keep} for data, keep in _EVT_BEATS[module.top]])
    return 1 + _wait(sim, "m_valid", 1)


def _to_aer_event(module: Module, n: int | None) -> int:
    sim = _fresh(module, m_ready=1, active_low=1, aer_req=1)
    sim.io.aer_req = 0
    sim.clock.tick()
    return 1 + _wait(sim, "m_valid", 1)


def _to_aer_request(module: Module, n: int | None) -> int:
    sim = _fresh(module, active_low=1, aer_ack=1)
    _offer(sim, "s_", [{}])
    return 1 + _wait(sim, "aer_req", 0)


def _fresh(module: Module, **ports: int) -> PyVerilator:
    """The module after reset, idle, with all other inputs 0."""
    sim = load(module.top, module.parameters)
    for port, value in ports.items():
        sim.io[port] = value
    reset(sim)
    _wait(sim, "idle", 1)
    return sim


def _offer(sim: PyVerilator, prefix: str, words: Sequence[Mapping[str, int]]) -> None:
    """Offer words, values of ports, one after the other, until the clock edge that accepts the last."""
    for word in words:
        for port, value in {f"{prefix}valid": 1, **word}.items():
            sim.io[port] = value
        _wait(sim, f"{prefix}ready", 1)
        sim.clock.tick()
    sim.io[f"{prefix}valid"] = 0


def _wait(sim: PyVerilator, port: str, value: int) -> int:
    """Clock until a port has this value; returns the number of clocks."""
    for passed in range(_PATIENCE):
        if sim.io[port] == value:
            return passed
        sim.clock.tick()
    raise AssertionError(f"{port} is not {value} after {_PATIENCE} clocks")


_MEASURES: Mapping[Answer, Callable[[Module, int | None], int]] = {
    "record": _to_record,
    "token": _to_token,
    "event": _to_event,
    "aer_request": _to_aer_request,
    "aer_event": _to_aer_event,
    "centre": _to_centre,
    "beat": _to_beat,
}

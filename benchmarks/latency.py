# SPDX-License-Identifier: Apache-2.0
"""Clocks of the hardware: per event, and from the event that moves a centre to the centre on the port."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import streams
from evcot.hardware.config import with_module
from evcot.hardware.modules import Module
from evcot.tracks.log import Kind
from evcot_cosim.devices.base import Stalls
from evcot_cosim.devices.device import Device, StreamTimes, build_device
from measure import Goal, Result

__all__ = ["measure"]

_SIZES: dict[Module, tuple[int, ...]] = {"cot": (1,), "cot_chain": (1, 8, 32), "cot_array": (1, 8, 32)}

# The published VHDL, its cell (its library with the output line needs 14): clocks to a centre, and for each tracker in front.
_PUBLISHED_CLOCKS, _PUBLISHED_PER_TRACKER = 7, 3

_SETTLE_CLOCKS = 256  # between events of the unloaded run: longer than a merge or a way through the chain takes


def measure(_folder: Path, quick: bool) -> Iterator[Result]:
    """clocks_per_event_*, latency_* and latency_loaded_* for every module and size."""
    for module, sizes in _SIZES.items():
        for slots in sizes:
            yield from _one(module, slots, 20_000 if quick else 200_000)


def _one(module: Module, slots: int, n: int) -> Iterator[Result]:
    config = with_module(streams.config(slots).hardware, module)
    model = build_device(config)
    events = streams.joined(n, discs=slots)

    def run(stalls: Stalls, count: int) -> tuple[float, NDArray[np.int64], NDArray[np.uint8]]:
        device = Device(config, stalls=stalls, model=model)
        before = device.cycle
        decisions, times = device.stream_timed(events[:count])
        return (device.cycle - before) / count, *_latencies(decisions.records, times)

    name = f"{module}_{slots}"
    loaded_clocks, loaded, _ = run(Stalls(), n)
    now_and_then = np.zeros(_SETTLE_CLOCKS, np.uint8)
    now_and_then[0] = 1
    _, alone, slot = run(Stalls(source=now_and_then), n // 10)
    deepest = int(slot.max())
    ahead = deepest if module == "cot_chain" else 0
    published = _PUBLISHED_CLOCKS + _PUBLISHED_PER_TRACKER * ahead

    yield Result(f"clocks_per_event_{name}", loaded_clocks, "clocks", how="events offered at every clock")
    at = alone[slot == deepest]
    goal = None if module == "cot_array" else Goal(1, at_most=True)  # the array's pipeline is for the rate: an event per clock
    yield Result(
        f"latency_{name}", float(np.median(at)), "clocks", float(published), "published VHDL, its cell",
        goal=goal,
        how=f"unloaded, slot {deepest}, median; all slots {alone.min()} to {alone.max()}",
    )  # fmt: skip
    yield Result(
        f"latency_loaded_{name}", float(np.median(loaded)), "clocks",
        how=f"events offered at every clock, median over all slots; {loaded.min()} to {loaded.max()}",
    )  # fmt: skip


def _latencies(records: NDArray[np.void], times: StreamTimes) -> tuple[NDArray[np.int64], NDArray[np.uint8]]:
    """Clocks from the edge that takes an event to the edge that hands over the centre it moved, and its slot.

    The first record of each event counts: a merge that follows reports a second centre for it.
    """
    moves = np.flatnonzero((records["kind"] == Kind.MOVED) | (records["kind"] == Kind.BORN))
    _, first = np.unique(records["seq"][moves], return_index=True)
    moves = moves[first]
    cause = records["seq"][moves].astype(np.int64)
    return times.recorded[moves] - times.accepted[cause], records["slot"][moves]

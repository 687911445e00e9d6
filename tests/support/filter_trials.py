# SPDX-License-Identifier: Apache-2.0
"""Support for tests of the filters: random traffic that stresses them, and a comparison that reports the first difference."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from evcot.ticks import TickedEvents
from evcot_cosim.devices.filter_device import FilterDevice

from .tokens import ticked

__all__ = ["FilterTraffic", "compare_with_reference", "filter_traffic", "parameters", "run_story"]


@dataclass(frozen=True, eq=False)
class FilterTraffic(TickedEvents):
    """Events as a filter takes them, and which of them those before it let stay, (n,) bool."""

    keep: NDArray[np.bool_]


def filter_traffic(
    rng: np.random.Generator,
    n: int,
    width: int,
    height: int,
    *,
    ticks_per_event: float = 1,
    longest_gap: int = 0,
    gaps: float = 1e-3,
    skips: float = 0.05,
    beyond: int = 0,
    first_tick: int = 0,
) -> FilterTraffic:
    """Random events concentrated on a filter's corner cases: neighbouring and equal pixels, equal ticks, sensor borders.

    Args:
        rng: the only source of randomness.
        n: events.
        width, height: pixels of the sensor.
        ticks_per_event: about how many ticks pass from one event to the next.
        longest_gap: maximum length in ticks of an occasional gap; its bit length is uniformly distributed.
        gaps: probability of such a gap before an event.
        skips: probability that an event has already been dropped when it arrives.
        beyond: an occasional event lies up to this many pixels outside the sensor.
        first_tick: tick before the first event.
    """
    hot = rng.integers(0, [width, height], (4, 2))  # pixels that fire continually
    axes = []
    kind = rng.choice(4, n, p=[0.35, 0.35, 0.15, 0.15])  # near the previous event, anywhere, a hot pixel, a border
    at_hot = rng.integers(0, 4, n)
    on_x = rng.random(n) < 0.5  # the axis whose coordinate is on the border
    for axis, size in enumerate((width, height)):
        anywhere = rng.integers(0, size, n)
        # A random walk of short steps, restarted at every event of another kind.
        start = np.where(kind == 2, hot[at_hot, axis], anywhere)
        border = rng.choice([0, size - 1], n)
        start = np.where((kind == 3) & (on_x == (axis == 0)), border, start)
        steps = np.where(kind == 0, rng.integers(-1, 2, n), 0)
        origin = np.maximum.accumulate(np.where(kind == 0, 0, np.arange(n)))
        walked = np.cumsum(steps)
        place = start[origin] + walked - walked[origin]
        outside = rng.random(n) < (0.02 if beyond else 0)
        place = np.clip(place, 0, size - 1)
        axes.append(np.where(outside, size + rng.integers(0, max(1, beyond), n), place).astype(np.uint16))
    waits = rng.poisson(ticks_per_event, n).astype(np.int64)
    if longest_gap:
        long = rng.random(n) < gaps
        waits[long] += (2 ** rng.uniform(0, np.log2(longest_gap + 1), n)[long]).astype(np.int64) - 1
    return FilterTraffic(
        first_tick + np.cumsum(waits), axes[0], axes[1], rng.integers(0, 2, n, np.uint8), rng.random(n) >= skips
    )  # fmt: skip


def parameters(width: int, height: int, *, tick_w: int, **others: int) -> dict[str, int]:
    """Verilog parameters of a filter on this sensor, with addresses wide enough for a pixel beyond it."""
    return {"X_W": width.bit_length(), "Y_W": height.bit_length(), "WIDTH": width, "HEIGHT": height, "TICK_W": tick_w, **others}


def run_story(device: FilterDevice, events: Iterable[tuple[int, int, int]]) -> list[bool]:
    """Run a short story from reset; returns which of the events (tick, x, y) are kept."""
    device.reset()
    ticks, x, y = np.array(list(events), np.int64).reshape(-1, 3).T
    return [bool(stays) for stays in device.stream(ticked(ticks, x, y, np.arange(len(ticks)) % 2))]


def compare_with_reference(
    device: FilterDevice, traffic: FilterTraffic, reference: Callable[[FilterTraffic], NDArray[np.bool_]], parts: int = 1
) -> float:
    """Stream the traffic through both hardware and reference and return the fraction of events kept.

    Args:
        reference: returns which of all events are kept, (n,); its result for skipped events is ignored.
        parts: number of parts in which the hardware gets the events; it becomes idle in between.

    Raises:
        AssertionError: they differ; the message names the first differing event.
    """
    cuts = np.linspace(0, len(traffic), parts + 1).astype(int)
    keep = np.concatenate([device.stream(traffic[a:b], traffic.keep[a:b]) for a, b in pairwise(cuts)])
    differ = np.flatnonzero(keep != (reference(traffic) & traffic.keep))
    if len(differ):
        i = int(differ[0])
        raise AssertionError(
            f"{device.top}: {len(differ)} of {len(keep)} events differ, the first is event {i} "
            f"(tick {traffic.ticks[i]}, x {traffic.x[i]}, y {traffic.y[i]}, skip {not traffic.keep[i]}): "
            f"hardware {'keeps' if keep[i] else 'drops'} it"
        )
    return float(np.mean(keep)) if len(keep) else 0.0

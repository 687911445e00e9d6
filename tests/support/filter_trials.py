# SPDX-License-Identifier: Apache-2.0
"""Support for tests of the filters: their hardware, random traffic that stresses them, a comparison with a reference."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from evcot.ticks import TickedEvents
from evcot_cosim.devices.base import HardwareError, Stalls, check_waits

from .stream_device import StreamDevice, check_reset
from .tokens import TOKENS_IN, TOKENS_OUT, ticked

__all__ = [
    "FilterDevice",
    "FilterTimes",
    "FilterTraffic",
    "check_reset_amid_events",
    "compare_with_reference",
    "filter_traffic",
    "parameters",
    "run_story",
]


class FilterTimes(NamedTuple):
    """Clocks at which events were accepted and sent on, (n,) int64 each."""

    accepted: NDArray[np.int64]
    given: NDArray[np.int64]


class FilterDevice(StreamDevice):
    """One simulated module with the token ports of a filter.

    Every output token is checked against the input: the same number of tokens in the same order with the same ticks, an
    event unchanged or dropped, a skipped event still skipped, and each token held until accepted.

    Args:
        ports: values of its configuration inputs, such as `enable`; `set` changes them.
        stalls: as of `stall`.
    """

    def __init__(
        self,
        top: str,
        parameters: Mapping[str, int] | None = None,
        ports: Mapping[str, int] | None = None,
        *,
        stalls: Stalls | None = None,
        verilog: Path | None = None,
    ) -> None:
        super().__init__(top, parameters, inputs=[TOKENS_IN], outputs=[TOKENS_OUT], ports=ports, has_idle=True, verilog=verilog)
        self.stall(stalls or Stalls())

    def stall(self, stalls: Stalls) -> None:
        """Stall the input by `source` and the output by `passed` from now on."""
        self.stalls = {"s_": stalls.source, "m_": stalls.passed}

    def reset(self) -> None:
        """Reset the hardware to tick 0 and wait until it is idle; `settled_after` is the number of clocks that took."""
        super().reset()
        self.now = 0
        self.settled_after = self.settle()
        self.cycle = 0

    def settle(self) -> int:
        """Clock without input until the hardware is idle; returns how many clocks that took."""
        return self.run().clocks - 1  # in the last it is idle

    def write(self, address: int, data: int) -> None:
        """Write one register through the port `cfg_valid`, `cfg_addr`, `cfg_data`."""
        self.set(cfg_valid=1, cfg_addr=address, cfg_data=data)
        self.sim.clock.tick()
        self.set(cfg_valid=0)

    def stream(self, events: TickedEvents, keep: NDArray[np.bool_] | None = None) -> NDArray[np.bool_]:
        """Drive a run of events through the hardware, wait until it is idle again, and return which of them stay, (n,).

        Args:
            events: with addresses below 2^X_W and 2^Y_W; long waits become tokens of ticks alone.
            keep: (n,) bool, what filters in front let stay; the others go in as skipped events. None: all.

        Raises:
            HardwareError: a token was lost, invented, changed or withdrawn, or there was no progress.
            RecordingError: a wait between two events would take too many clocks. Nothing was driven.
        """
        return self.stream_timed(events, keep)[0]

    def stream_timed(
        self, events: TickedEvents, keep: NDArray[np.bool_] | None = None
    ) -> tuple[NDArray[np.bool_], FilterTimes]:
        """As `stream`, with the clocks at which events were taken and handed on."""
        tick_max = (1 << int(self.sim.io["s_tick"].signal.width)) - 1
        check_waits(events.ticks, self.now, tick_max)
        waits = np.diff(events.ticks, prepend=self.now)
        full = np.maximum(waits - 1, 0) // tick_max  # tokens of ticks alone before each event
        of_event = np.cumsum(full + 1) - 1
        sent = np.zeros((int(of_event[-1]) + 1 if len(events) else 0, len(TOKENS_IN.fields)), np.uint64)
        sent[:, 0] = tick_max
        sent[of_event, 0] = waits - full * tick_max
        skip = np.zeros(len(events), np.bool_) if keep is None else ~events.mask(keep)
        sent[of_event, 1], sent[of_event, 2] = ~skip, skip
        for column, values in ((3, events.x), (4, events.y), (5, events.p)):
            sent[of_event, column] = values
        run = self.run({"s_": sent})
        self.now = int(events.ticks[-1]) if len(events) else self.now
        return self._checked(sent, run.words["m_"], of_event), FilterTimes(
            run.accepted["s_"][of_event], run.given["m_"][of_event]
        )

    def _checked(self, sent: NDArray[np.uint64], given: NDArray[np.uint64], of_event: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Which events stay, where every token is what it may be."""
        both = min(len(sent), len(given))
        ours, theirs = sent[:both], given[:both]
        stays = theirs[:, 1] == 1
        alone = (ours[:, 1] | ours[:, 2]) == 0
        unchanged = (theirs[:, 1:] == ours[:, 1:]).all(axis=1)
        dropped = (theirs[:, 1] == 0) & (theirs[:, 2] == 1) & ~alone
        for what, wrong in (
            ("changed the ticks", theirs[:, 0] != ours[:, 0]),
            ("changed more than whether it stays,", ~np.where(alone, (theirs[:, 1:3] == 0).all(axis=1), unchanged | dropped)),
        ):
            if wrong.any():
                event = int(np.searchsorted(of_event, np.argmax(wrong)))
                raise HardwareError(f"{self.top} {what} at event {event}", event)
        if len(sent) != len(given):
            raise HardwareError(f"{self.top} gave {len(given)} tokens for {len(sent)}", both)
        kept: NDArray[np.bool_] = stays[of_event]
        return kept


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


def check_reset_amid_events(device: FilterDevice) -> None:
    """As `check_reset`, with events and skipped events on a few pixels."""
    rng, n = np.random.default_rng(1), 100
    tick, skip, x, y, p = (rng.integers(0, below, n) for below in (2, 2, 3, 3, 2))
    check_reset(device, {"s_": np.stack([tick, 1 - skip, skip, x, y, p], axis=1)})
    device.stall(Stalls())
    device.reset()

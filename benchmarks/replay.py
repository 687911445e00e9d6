# SPDX-License-Identifier: Apache-2.0
"""What replaying costs the array, which decides all events behind one that moves a centre again: how many of them did that
window touch, and how many clocks would an event take if only these were decided again?
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

import streams
from evcot.hardware.model import Decisions
from evcot.tracks.log import Kind
from evcot_cosim.devices.device import Device
from measure import Result

__all__ = ["Replayed", "measure", "replayed"]

_FAR_SLOTS = 16  # with more, the pipeline is a stage longer


class Replayed(NamedTuple):
    """Of events that are behind one that moves a centre.

    Attributes:
        special: events that move a centre.
        decided_again: events behind them, `lost` - 1 each.
        touched: of these, those in the slot's window before or after, or of that slot.
        saved: clocks that would be saved at best: a clock stays for the centre, which uses the adders of the average; and from
            the first touched event on all is as now.
    """

    special: int
    decided_again: int
    touched: int
    saved: int


def measure(folder: Path, quick: bool) -> Iterator[Result]:
    """replay_touched and replay_bound for 8 and 32 slots, on the stream of `streaming`."""
    count = 50_000 if quick else 200_000
    for slots in (8, 32):
        events = streams.joined(count, slots)
        device = Device(streams.config(slots).hardware)
        began = device.cycle
        found = replayed(device.stream(events), events.x, events.y, device.shape.frac, lost=6 + (slots > _FAR_SLOTS))
        clocks = (device.cycle - began) / count
        yield Result(
            f"replay_touched_{slots}",
            100 * found.touched / found.decided_again,
            "%",
            how=f"of {found.decided_again:,} events decided again",
        )
        yield Result(
            f"replay_bound_{slots}", clocks - found.saved / count, "clocks", clocks, "as it is",
            how="an event, if only touched events were decided again and no merge were waited for",
        )  # fmt: skip


def replayed(decisions: Decisions, x: NDArray[np.uint16], y: NDArray[np.uint16], frac: int, lost: int) -> Replayed:
    """Count the events that are decided again in `lost` clocks after each event that moves a centre, and those touched."""
    records = decisions.records[np.isin(decisions.records["kind"], (Kind.BORN, Kind.MOVED))]
    centres = [(records[name].astype(np.int64) + ((1 << frac) >> 1)) >> frac for name in ("cm_x", "cm_y")]
    radius = records["radius"].astype(np.int64)
    windows = np.stack([centres[0] - radius, centres[0] + radius, centres[1] - radius, centres[1] + radius])
    before = _previous(records["slot"], records["kind"] == Kind.BORN)
    behind = records["seq"].astype(np.int64)[:, None] + np.arange(1, lost)
    there = behind < len(x)
    behind = np.minimum(behind, len(x) - 1)
    touched = decisions.owner[behind] == records["slot"][:, None]
    at_x, at_y = x[behind].astype(np.int64), y[behind].astype(np.int64)
    for which in (windows, windows[:, before]):
        low_x, high_x, low_y, high_y = (bound[:, None] for bound in which)
        touched |= (low_x <= at_x) & (at_x <= high_x) & (low_y <= at_y) & (at_y <= high_y)
    touched &= there
    first = np.where(touched.any(axis=1), touched.argmax(axis=1), lost - 1)
    return Replayed(len(records), int(there.sum()), int(touched.sum()), int(np.minimum(first, lost - 1).sum()))


def _previous(slots: NDArray[np.integer], begins: NDArray[np.bool_]) -> NDArray[np.intp]:
    """For each record the one before it of the same slot; itself where a life begins."""
    order = np.argsort(slots, kind="stable")
    previous = np.empty(len(slots), np.intp)
    previous[order] = np.concatenate([order[:1], order[:-1]])
    own = np.arange(len(slots))
    return np.where(begins | (slots[previous] != slots), own, previous)

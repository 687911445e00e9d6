# SPDX-License-Identifier: Apache-2.0
"""TrackLog: what every engine returns, whether it is software, model or hardware."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["TRACK", "TrackLog"]

TRACK = np.dtype(
    [
        ("t_us", "<i8"),
        ("event_index", "<i8"),
        ("kind", "u1"),
        ("track_id", "<i8"),
        ("slot", "<i2"),
        ("x", "<f8"),
        ("y", "<f8"),
        ("radius", "<f8"),
        ("n_ev", "<i4"),
        ("support", "<i8"),
        ("other_id", "<i8"),
    ]
)


@dataclass(frozen=True, eq=False)
class TrackLog:
    """Births, moves, merges and losses of all tracks, and who took each event.

    Attributes:
        engine: name of the engine that wrote it: "rct", "cot-model" or "cot-rtl".
        records: (m,) of dtype `TRACK`, in the order in which they happened. `kind` is a `contract.Kind`. `event_index` is
            the event that caused the record; for LOST, which time causes, the next event, so that "everything with
            event_index <= i" is the state after event i. `other_id` is the survivor of a MERGED track, else -1.
            `x`, `y`, `radius` in pixels, `t_us` in the recording's microseconds.
        owner: (n,) int16, one per event: the slot that took it, -1 where it passed through.
    """

    engine: str
    records: NDArray[np.void]
    owner: NDArray[np.int16]

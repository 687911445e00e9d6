# SPDX-License-Identifier: Apache-2.0
"""TC over time: the time since a cluster's last event."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from evcot.tracks.log import Kind, TrackLog

__all__ = ["QuietPeaks", "quiet_peaks"]

_CELLS_MAX = 100_000  # slots times stretches
_STRETCHES_MAX = 800
_BORN, _MOVED, _MERGED, _LOST = (int(kind) for kind in (Kind.BORN, Kind.MOVED, Kind.MERGED, Kind.LOST))


class QuietPeaks(NamedTuple):
    """`peaks_us`: (slots, intervals) int64, the longest gap of the slot's cluster that ended in the interval, -1 if none did;
    `stretch_us`: length of an interval."""

    peaks_us: NDArray[np.int64]
    stretch_us: int


def quiet_peaks(log: TrackLog, t_us: NDArray[np.int64]) -> QuietPeaks:
    """Longest gaps between events of visible clusters, over equal intervals of the recording.

    A gap extends from one event of a cluster to its next, or to its loss.

    Args:
        log: log of the events at (n,) `t_us`.
    """
    slots = int(max(log.records["slot"].max(initial=0), log.owner.max(initial=0))) + 1
    stretches = max(1, min(_STRETCHES_MAX, _CELLS_MAX // slots))
    begin_us, end_us = (int(t_us[0]), int(t_us[-1])) if len(t_us) else (0, 0)
    stretch_us = max(1, -(-(end_us - begin_us + 1) // stretches))
    peaks = np.full((slots, stretches), -1, np.int64)
    records = log.records
    _walk(
        t_us, log.owner, records["event_index"].copy(), records["kind"].copy(), records["slot"].copy(),
        records["t_us"].copy(), begin_us, stretch_us, peaks,
    )  # fmt: skip
    return QuietPeaks(peaks, stretch_us)


@njit(cache=True, nogil=True)
def _walk(t_us, owner, cause, kind, slot, record_us, begin_us, stretch_us, peaks):  # type: ignore[no-untyped-def]
    last_us = np.full(peaks.shape[0], -1, np.int64)
    visible = np.zeros(peaks.shape[0], np.bool_)
    j = 0
    for i in range(len(t_us) + 1):
        # What time ended comes before the event, what the event caused after it.
        while j < len(cause) and cause[j] <= i and kind[j] == _LOST:
            _note(peaks, slot[j], record_us[j], last_us, visible, begin_us, stretch_us)
            visible[slot[j]] = False
            last_us[slot[j]] = -1
            j += 1
        if i < len(t_us) and owner[i] >= 0:
            _note(peaks, owner[i], t_us[i], last_us, visible, begin_us, stretch_us)
            last_us[owner[i]] = t_us[i]
        while j < len(cause) and cause[j] <= i:
            if kind[j] == _BORN or kind[j] == _MOVED:  # without BORN one that was lost and found again
                visible[slot[j]] = True
            elif kind[j] == _MERGED or kind[j] == _LOST:
                visible[slot[j]] = False
                last_us[slot[j]] = -1
            j += 1


@njit(cache=True, nogil=True)
def _note(peaks, slot, now_us, last_us, visible, begin_us, stretch_us):  # type: ignore[no-untyped-def]
    if visible[slot] and last_us[slot] >= 0:
        stretch = min((now_us - begin_us) // stretch_us, peaks.shape[1] - 1)
        peaks[slot, stretch] = max(peaks[slot, stretch], now_us - last_us[slot])

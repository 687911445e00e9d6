# SPDX-License-Identifier: Apache-2.0
"""Outputs of a log at any times, window by window: memory holds a run of records and the tracks that are alive."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .log import TRACK, Kind, TrackLog
from .timeline import SAMPLE, expiring, sample

__all__ = ["Window", "sampled", "windows"]

_EVER_US = 1 << 61


@dataclass(frozen=True, eq=False)
class Window:
    """A log in which states expire, complete for the times from `from_us` up to, without, `until_us`."""

    from_us: int
    until_us: int
    states: TrackLog


def windows(runs: Iterable[NDArray[np.void]], max_age_us: int) -> Iterator[Window]:
    """Cut the whole of time into windows.

    Args:
        runs: records in time order, see `reading.RecordRuns`.
        max_age_us: as of `timeline.expiring`.
    """
    newest, from_us = np.empty(0, TRACK), -_EVER_US
    for records in runs:
        if not len(records):
            continue
        every, until_us = np.concatenate((newest, records)), int(records["t_us"][-1])
        yield Window(from_us, until_us, _expiring(every, max_age_us))
        newest, from_us = _newest(every, until_us - max_age_us), until_us
    yield Window(from_us, _EVER_US, _expiring(newest, max_age_us))


def sampled(runs: Iterable[NDArray[np.void]], times_us: NDArray[np.int64], max_age_us: int) -> NDArray[np.void]:
    """As `timeline.sample` of the log in which states expire, at (k,) ascending times."""
    parts = [np.empty(0, SAMPLE)]
    for window in windows(runs, max_age_us):
        first, past = np.searchsorted(times_us, (window.from_us, window.until_us))
        if first < past:
            own = sample(window.states, times_us[first:past])
            own["sample"] += first
            parts.append(own)
    return np.concatenate(parts)


def _expiring(records: NDArray[np.void], max_age_us: int) -> TrackLog:
    return expiring(TrackLog("", records, np.empty(0, np.int16)), max_age_us)


def _newest(records: NDArray[np.void], since_us: int) -> NDArray[np.void]:
    """The last record of each track that has not ended, unless it is older."""
    order = np.argsort(records["track_id"], kind="stable")
    track_id = records["track_id"][order]
    last = records[order[np.append(track_id[1:] != track_id[:-1], True)[: len(order)]]]
    kept: NDArray[np.void] = last[(last["kind"] <= Kind.MOVED) & (last["t_us"] >= since_us)]
    return kept

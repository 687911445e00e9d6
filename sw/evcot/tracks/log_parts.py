# SPDX-License-Identifier: Apache-2.0
"""A track log in parts, one after the other, each a log of its own that begins with the tracks that are alive then.

A part holds the records that belong to its events, by the order of the log. Before them come three records for every track
that is alive: where it was born and the corners of the places where it has been, then its newest state, so that lifetimes,
positions, merges and how far a track has travelled are those of the whole log.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .column import Column, in_runs
from .log import TRACK, Kind, TrackLog
from .npz import NpzFile
from .parquet import LogFile
from .spool import LogColumns
from .timeline import OPEN, SAMPLE, by_life, expiring, lifetimes, sample

__all__ = ["AnyLog", "LogParts", "LogWindow", "life_lengths", "sampled", "windows"]

AnyLog = LogColumns | LogFile | NpzFile
"""A log that can be read run by run: in memory, while it grows, or in a file."""


_OWNERS, _RECORDS = 1 << 16, 1 << 14  # of a run
_BEFORE = -(1 << 62)  # `event_index` of what was before the part


def _runs_of(log: AnyLog) -> Iterator[tuple[NDArray[np.void], NDArray[np.int16]]]:
    """A log as records and owners, run by run, as `parquet.LogFile.blocks` gives them."""
    if isinstance(log, LogFile):
        return log.blocks()
    if isinstance(log, NpzFile):
        return _in_step(log.record_runs(), log.owner_runs())
    records, owners = (in_runs(log.records, _RECORDS), in_runs(log.owner, _OWNERS))
    return _in_step((run for _, run in records), (run for _, run in owners))


def _in_step(
    records: Iterator[NDArray[np.void]], owners: Iterator[NDArray[np.int16]]
) -> Iterator[tuple[NDArray[np.void], NDArray[np.int16]]]:
    """Records and owners of a log, each run by run, brought together as `parquet.LogFile.blocks` gives them."""
    owner: NDArray[np.int16] | None = next(owners, np.empty(0, np.int16))
    waiting, end = np.empty(0, TRACK), 0
    while owner is not None:
        following = next(owners, None)
        end += len(owner)
        own = [np.empty(0, TRACK)]
        while len(waiting) or len(waiting := next(records, waiting)):
            last = following is None
            count = len(waiting) if last else int(np.searchsorted(np.maximum.accumulate(waiting["event_index"]), end))
            own.append(waiting[:count])
            waiting = waiting[count:]
            if len(waiting):
                break
        yield np.concatenate(own), owner
        owner = following


class LogParts:
    """Cuts a log; every part has all verdicts and names of classes."""

    def __init__(self, log: AnyLog) -> None:
        self._engine, self._verdicts, self._class_names = log.engine, log.verdicts, log.class_names
        self._runs = _runs_of(log)
        self._records = np.empty(0, TRACK)
        self._owner = np.empty(0, np.int16)
        self._done = 0
        self._past = np.empty(0, TRACK)

    def take(self, n: int, *, last: bool = False) -> tuple[TrackLog, TrackLog]:
        """The log of the next `n` events, event 0 being the first of them, twice: with the past, and to be drawn.

        What is drawn has one record of every track alive before, its newest state at the time of the part's first record.
        """
        records, owner, past = [self._past, self._records], [self._owner], len(self._past)
        have = len(self._owner)
        while have < n or last:
            run = next(self._runs, None)
            if run is None:
                break
            records.append(run[0])
            owner.append(run[1])
            have += len(run[1])
        every, owners = np.concatenate(records), np.concatenate(owner)
        del records, owner  # each is some megabytes, and so are those below
        end = self._done + n
        event = every["event_index"][past:]
        count = len(event) if last else int(np.searchsorted(np.maximum.accumulate(event), end))
        taken = owners[:n].copy()
        whole = TrackLog(self._engine, every[: past + count], taken)
        own = whole.records[past:]
        own["event_index"] -= self._done
        self._records, self._owner, self._done = (
            every[past + count :].copy(),
            owners[n:].copy(),
            end,
        )  # no views
        del owners
        drawn = np.concatenate((self._newest(own), own))
        shown = TrackLog(self._engine, drawn, taken, verdicts=self._verdicts, class_names=self._class_names)
        np.clip(shown.records["event_index"], 0, n, out=shown.records["event_index"])
        self._past = _past(whole)
        return whole, shown

    def _newest(self, own: NDArray[np.void]) -> NDArray[np.void]:
        newest = self._past[2 * len(self._past) // 3 :].copy()
        if len(own):
            newest["t_us"] = np.minimum(np.maximum(newest["t_us"], own["t_us"][0]), own["t_us"][0])
        return newest


def _past(log: TrackLog) -> NDArray[np.void]:
    """The three records of every track that is alive at the end, in the order of their births."""
    lives = lifetimes(log, 0)
    if not len(lives):
        return np.empty(0, TRACK)
    order, first = by_life(log)
    last = np.append(first[1:], len(order)) - 1
    born, corner, newest = (log.records[order[at]] for at in (first, last, last))
    x, y, width, height = (log.records[name][order] for name in ("x", "y", "width", "height"))
    for name, values in (("x", x), ("y", y)):
        born[name] = np.minimum.reduceat(values, first)
        corner[name] = np.maximum.reduceat(values, first)
    born["width"] = born["height"] = np.maximum.reduceat(np.maximum(width, height), first)
    past = np.concatenate([rows[lives["ended"] == OPEN] for rows in (born, corner, newest)])
    past["kind"], past["event_index"] = Kind.MOVED, _BEFORE
    return past


_EVER_US = 1 << 61


@dataclass(frozen=True, eq=False)
class LogWindow:
    """A log in which states expire, complete for the times from `from_us` up to, without, `until_us`."""

    from_us: int
    until_us: int
    states: TrackLog


def windows(runs: Iterable[NDArray[np.void]], max_age_us: int) -> Iterator[LogWindow]:
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
        yield LogWindow(from_us, until_us, _expiring(every, max_age_us))
        newest, from_us = _newest(every, until_us - max_age_us), until_us
    yield LogWindow(from_us, _EVER_US, _expiring(newest, max_age_us))


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


_DIGIT = 16  # bits that one pass finds


def life_lengths(lives: Column) -> dict[str, Any]:
    """`tracks`, `lost`, `median_s`, `longest_s` of lives, of dtype `timeline.LIFE` or `track_pairs.ROW`; None without any."""
    count, lost, longest_us = len(lives), 0, 0
    for _, run in in_runs(lives):
        lost += int(np.count_nonzero(run["ended"] == Kind.LOST))
        longest_us = max(longest_us, int(_lengths_us(run).max()))
    middle_us = [_in_order(lives, place, longest_us) for place in {(count - 1) // 2, count // 2}] if count else []
    return {
        "tracks": count,
        "lost": lost,
        "median_s": float(np.mean(np.array(middle_us) / 1e6)) if count else None,
        "longest_s": longest_us / 1e6 if count else None,
    }


def _lengths_us(lives: NDArray[np.void]) -> NDArray[np.int64]:
    return np.asarray(lives["end_us"] - lives["birth_us"], np.int64)


def _in_order(lives: Column, place: int, longest_us: int) -> int:
    """The length at a place, if lengths were in order: digit by digit, the highest first."""
    found = 0
    for digit in reversed(range(-(-longest_us.bit_length() // _DIGIT))):
        shift = digit * _DIGIT
        counts = np.zeros(1 << _DIGIT, np.int64)
        for _, run in in_runs(lives):
            lengths_us = _lengths_us(run)
            same = lengths_us[lengths_us >> (shift + _DIGIT) == found >> (shift + _DIGIT)]
            counts += np.bincount(same >> shift & (1 << _DIGIT) - 1, minlength=1 << _DIGIT)
        so_far = np.cumsum(counts)
        value = int(np.searchsorted(so_far, place, "right"))
        place -= int(so_far[value - 1]) if value else 0
        found |= value << shift
    return found

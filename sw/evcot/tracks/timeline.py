# SPDX-License-Identifier: Apache-2.0
"""Time queries on a TrackLog: lifetimes, positions at given times, and merges.

All functions need records in time order, as written by every engine. In a log that was cut out of a longer one, a track that
was born earlier begins with its first record, and a track whose only record is its end has a lifetime of 0.
"""

from __future__ import annotations

from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from .log import Kind, TrackLog
from .record import labels_at
from .tally import IdSet

__all__ = [
    "LIFE",
    "MERGE",
    "OPEN",
    "SAMPLE",
    "FoundAgain",
    "alive",
    "by_life",
    "expiring",
    "lifetimes",
    "merges",
    "sample",
    "track_labels",
]

_BY_LIFE: WeakKeyDictionary[TrackLog, tuple[NDArray[np.int64], NDArray[np.int64]]] = WeakKeyDictionary()
OPEN = -1  # `LIFE.ended` of a track that is still alive at the end of the log

LIFE = np.dtype(
    [
        ("track_id", "<i8"),
        ("slot", "<i2"),
        ("birth_us", "<i8"),  # BORN, else the first record
        ("end_us", "<i8"),  # MERGED or LOST, else `until_us`
        ("ended", "i1"),  # Kind.MERGED, Kind.LOST or OPEN
        ("other_id", "<i8"),  # the survivor of a MERGED track, else -1
    ]
)

SAMPLE = np.dtype(
    [
        ("sample", "<i8"),  # index into the requested times
        ("track_id", "<i8"),
        ("slot", "<i2"),
        ("x", "<f8"),
        ("y", "<f8"),
        ("radius", "<f8"),
        ("width", "<f8"),
        ("height", "<f8"),
        ("angle", "<f8"),
        ("vx", "<f8"),
        ("vy", "<f8"),
        ("confidence", "<f8"),
    ]
)

MERGE = np.dtype(
    [
        ("t_us", "<i8"),
        ("track_id", "<i8"),  # absorbed
        ("other_id", "<i8"),  # survivor
        ("x", "<f8"),  # where the survivor stood after it
        ("y", "<f8"),
    ]
)


def alive(log: TrackLog, times_us: NDArray[np.int64]) -> NDArray[np.int64]:
    """The number of visible tracks at each time, after all records up to and including that time; (k,) int64."""
    lives = lifetimes(log, 0)
    ends_us = np.sort(lives["end_us"][lives["ended"] != OPEN])
    return np.asarray(
        np.searchsorted(lives["birth_us"], times_us, "right") - np.searchsorted(ends_us, times_us, "right"), np.int64
    )


def lifetimes(log: TrackLog, until_us: int) -> NDArray[np.void]:
    """One row of dtype `LIFE` per track, in order of birth; a track without an end lives until `until_us`.

    An id that is born again, as happens with narrow ids in hardware, is another track.
    """
    records = log.records
    order, at = by_life(log)
    first, last = order[at], order[np.append(at[1:], len(order))[: len(at)] - 1]
    lives = np.empty(len(first), LIFE)
    for name, source in (("track_id", "track_id"), ("slot", "slot"), ("birth_us", "t_us")):
        lives[name] = records[source][first]
    ended = np.isin(records["kind"][last], (Kind.MERGED, Kind.LOST))
    lives["end_us"] = np.where(ended, records["t_us"][last], until_us)
    lives["ended"] = np.where(ended, records["kind"][last].astype(np.int8), OPEN)
    lives["other_id"] = np.where(ended, records["other_id"][last], -1)
    return lives


class FoundAgain:
    """Which lives go on with a track that was lost before, in a log that comes in parts, see `log_parts.LogParts`.

    Such a life begins without BORN.
    """

    def __init__(self) -> None:
        self._lost = IdSet()
        self._open = np.empty(0, np.bool_)  # what is known of the lives that the part before has left open

    def of(self, log: TrackLog, lives: NDArray[np.void]) -> NDArray[np.bool_]:
        """(k,) bool, one for each of `lives`, which are the `lifetimes` of the next part."""
        order, first = by_life(log)
        found = np.asarray(log.records["kind"][order[first]] != Kind.BORN, np.bool_)
        found[: len(self._open)] = self._open
        for row in (len(self._open) + np.flatnonzero(found[len(self._open) :])).tolist():
            found[row] = self._was_lost(lives, row)
        self._open = found[lives["ended"] == OPEN]
        self._lost.add(lives["track_id"][lives["ended"] == Kind.LOST])
        return found

    def _was_lost(self, lives: NDArray[np.void], row: int) -> bool:
        """Whether the track of a life has been there before, in this part or in one before."""
        track_id = lives["track_id"][row]
        return bool((lives["track_id"][:row] == track_id).any()) or int(track_id) in self._lost


def by_life(log: TrackLog) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """(order, first): `order` sorts the records by life, the lives by birth, and `first` is where each life begins in it.

    Life i is row i of `lifetimes`. It is kept as long as the log, whose records must not change: several figures ask for it.
    """
    found = _BY_LIFE.get(log)
    if found is None:
        found = _BY_LIFE[log] = _sorted_by_life(log.records)
    return found


def _sorted_by_life(records: NDArray[np.void]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    order = np.argsort(records["track_id"], kind="stable")
    kind, track_id = records["kind"][order], records["track_id"][order]
    is_end = (kind == Kind.MERGED) | (kind == Kind.LOST)
    begins = kind == Kind.BORN
    begins[:1] = True
    begins[1:] |= (track_id[1:] != track_id[:-1]) | is_end[:-1]
    at = np.flatnonzero(begins)
    counts = np.diff(at, append=len(order))
    in_time = np.argsort(order[at])
    counts = counts[in_time]
    first = np.cumsum(counts) - counts
    within = np.arange(len(order)) - np.repeat(first, counts)
    return order[np.repeat(at[in_time], counts) + within], first


def sample(log: TrackLog, times_us: NDArray[np.int64]) -> NDArray[np.void]:
    """The visible tracks at each of the (k,) ascending times, after all records up to and including that time.

    Returns:
        Rows of dtype `SAMPLE` in order of sample.
    """
    records = log.records
    # A record is the state of its track until the track's next record.
    order = np.argsort(records["track_id"], kind="stable")
    track_id, t_us = records["track_id"][order], records["t_us"][order]
    begin = np.searchsorted(times_us, t_us, "left")
    end = np.full(len(records), len(times_us))
    followed = np.flatnonzero(track_id[1:] == track_id[:-1])
    end[followed] = begin[followed + 1]
    ended = (records["kind"][order] == Kind.MERGED) | (records["kind"][order] == Kind.LOST)
    count = np.where(ended, 0, end - begin)
    state = np.repeat(np.arange(len(records)), count)
    at = np.arange(len(state)) - np.repeat(np.cumsum(count) - count, count) + begin[state]
    in_time = np.argsort(at, kind="stable")
    rows = records[order[state[in_time]]]
    samples = np.empty(len(rows), SAMPLE)
    samples["sample"] = at[in_time]
    for name in (SAMPLE.names or ())[1:]:
        samples[name] = rows[name]
    return samples


def track_labels(log: TrackLog, track_id: NDArray[np.int64], t_us: NDArray[np.int64]) -> list[str]:
    """How (n,) tracks at a time are called in pictures: their id, with their class so far if they have one."""
    labels = labels_at(log.verdicts, log.class_names, track_id, t_us)
    return [f"{one} {label}".rstrip() for one, label in zip(track_id.tolist(), labels, strict=True)]


def expiring(log: TrackLog, max_age_us: int) -> TrackLog:
    """A log in which a track is lost, until its next state, while its newest state (BORN or MOVED) is older than `max_age_us`.

    `sample` of the result gives the outputs at any times.
    """
    records = log.records
    order = np.argsort(records["track_id"], kind="stable")
    track_id, t_us = records["track_id"][order], records["t_us"][order]
    silent = np.ones(len(records), bool)
    silent[:-1] = (track_id[1:] != track_id[:-1]) | (t_us[1:] - t_us[:-1] > max_age_us)
    silent &= records["kind"][order] <= Kind.MOVED
    lost = records[order[silent]]
    lost["kind"] = Kind.LOST
    lost["t_us"] += max_age_us + 1
    # These first: a new state in the same microsecond takes precedence.
    every = np.concatenate((lost, records))
    return TrackLog(log.engine, every[np.argsort(every["t_us"], kind="stable")], log.owner)


def merges(log: TrackLog) -> NDArray[np.void]:
    """One row of dtype `MERGE` per MERGED record, in order."""
    merged, moved = log.of_kind(Kind.MERGED), log.of_kind(Kind.MOVED)
    moved = moved[np.isin(moved["event_index"], merged["event_index"])]
    after = {(int(row["event_index"]), int(row["track_id"])): row for row in moved}
    rows = np.empty(len(merged), MERGE)
    for name in ("t_us", "track_id", "other_id"):
        rows[name] = merged[name]
    for row, record in zip(rows, merged, strict=True):
        survivor = after.get((int(record["event_index"]), int(record["other_id"])), record)
        row["x"], row["y"] = survivor["x"], survivor["y"]
    return rows

# SPDX-License-Identifier: Apache-2.0
"""How good a track log looks without a truth: whether tracks last, which events they took, how much of it is noise."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..events import Events
from ..filters.config import FilterConfig
from ..filters.run import filtered
from ..tracks.log import DROPPED, Kind, TrackLog
from ..tracks.timeline import OPEN, FoundAgain, by_life, lifetimes

__all__ = ["Quality", "QualityCounter", "isolated", "isolation", "quality_of"]

_SHORT_US = 200_000  # a shorter track is short, unless it travels
_SHORT_PART = 0.1  # of the recording: of shorter recordings that is short
_TRAVEL = 0.5  # of its own box: a track that travels further is not short
_NEIGHBOUR_US = 10_000  # an event without a neighbouring event for so long is isolated
_RUN = 1 << 21  # events at a time


@dataclass(frozen=True)
class Quality:
    """Figures of one log. A figure without data is None.

    Attributes:
        tracks: number of tracks, without the absorbed ones; `alive_mean`: how many were alive, on average over the recording.
        absorbed: tracks that merged into another one in the moment of their birth, which nobody sees: they are no lives here.
        tracks_per_alive: tracks for each object alive.
        short_us: a life of a track is short if it ended sooner and travelled less than half its box.
        short: number of short lives; `short_merged` of them ended in another track, `short_lost` in silence;
            `short_time_fraction`: their share of the time of all lives.
        owned_fraction: share of the events that passed the filters and have a neighbour, that belong to a visible track that is
            not short.
        isolated_fraction: share of all events without an event on one of the eight pixels around within the 10 ms before.
        isolated_dropped_fraction, isolated_owned_fraction: shares of the isolated events that filters dropped, and that
            belong to a visible track.
        noise_tracks: number of lives most of whose events are isolated; `noise_time_fraction`: their share of the time of all
            lives.
        found_again: how often a track was found again after it had been lost; each time it begins another life.
    """

    tracks: int
    alive_mean: float
    tracks_per_alive: float | None
    short_us: int
    short: int
    short_merged: int
    short_lost: int
    owned_fraction: float | None
    isolated_fraction: float | None
    isolated_dropped_fraction: float | None
    isolated_owned_fraction: float | None
    noise_tracks: int
    noise_time_fraction: float | None
    found_again: int = 0
    short_time_fraction: float | None = None
    absorbed: int = 0

    @property
    def lives(self) -> int:
        """Number of lives: one a track, and one more each time that one was found again."""
        return self.tracks + self.found_again

    def to_dict(self) -> dict[str, Any]:
        """Plain values, as summary.json stores them."""
        return asdict(self)


def isolated(events: Events, sensor: tuple[int, int]) -> NDArray[np.bool_]:
    """The mask of the events that have no event on one of the eight pixels around within the 10 ms before, (n,) bool."""
    mask = isolation(sensor)
    parts = [mask(events[begin : begin + _RUN]) for begin in range(0, len(events), _RUN)]
    return np.concatenate([np.empty(0, np.bool_), *parts])


def isolation(sensor: tuple[int, int]) -> Callable[[Events], NDArray[np.bool_]]:
    """As `isolated`, for a recording that comes in runs: the mask of each run after the other."""
    keep = filtered((), FilterConfig(activity_us=_NEIGHBOUR_US), sensor).keep
    return lambda run: ~keep(run)


def quality_of(log: TrackLog, events: Events, alone: NDArray[np.bool_]) -> Quality:
    """The figures of a log.

    Args:
        events: (n,) those that the log decided.
        alone: (n,) as `isolated` gives it; the logs of one recording share it.
    """
    span_us = (int(events.t_us[0]), int(events.t_us[-1])) if len(events) else (0, 0)
    counter = QualityCounter(*span_us)
    counter.add(log, events, alone)
    return counter.quality()


class QualityCounter:
    """The figures of a log that comes in parts, see `tracks.log_parts.LogParts`: the same as of the whole.

    Args:
        begin_us, end_us: times of the recording's first and last event.
    """

    def __init__(self, begin_us: int, end_us: int) -> None:
        self._end_us = end_us
        self._span_us = max(end_us - begin_us, 1)
        self._short_us = int(min(_SHORT_US, _SHORT_PART * self._span_us))
        self._sums = Counter[str]()
        self._open = np.zeros((0, 3), np.int64)  # of each track alive: events, isolated ones, and those that count as lasting
        self._found_again = FoundAgain()

    def add(self, log: TrackLog, events: Events, alone: NDArray[np.bool_], *, last: bool = True) -> None:
        """Count a part; arguments as of `quality_of`, and whether it is the last one.

        The log begins with the tracks that were alive at the end of the part before, in the order of their births.
        """
        lives = lifetimes(log, self._end_us)
        lengths_us = lives["end_us"] - lives["birth_us"]
        found_again = self._found_again.of(log, lives)[len(self._open) :]
        absorbed = (lives["ended"] == Kind.MERGED) & (lengths_us == 0)
        over = ((lives["ended"] != OPEN) | last) & ~absorbed
        short = ~absorbed & (lengths_us < self._short_us) & (lives["ended"] != OPEN) & ~_travelled(log)
        life = _life_of_event(log, events.t_us, lives)
        owned, passed = life >= 0, log.owner != DROPPED
        near = owned & passed & ~alone
        counts = np.column_stack([np.bincount(life[which], minlength=len(lives)) for which in (owned, owned & alone, near)])
        counts[: len(self._open)] += self._open
        noise = over & (2 * counts[:, 1] > counts[:, 0])
        self._open = counts[~over & ~absorbed]
        self._sums.update(
            lives=int(over.sum()),
            absorbed=int(absorbed.sum()),
            found_again=int(found_again.sum()),
            alive_us=int(lengths_us[over].sum()),
            short=int(short.sum()),
            short_merged=int((short & (lives["ended"] == Kind.MERGED)).sum()),
            short_lost=int((short & (lives["ended"] == Kind.LOST)).sum()),
            short_time_us=int(lengths_us[short].sum()),
            lasting=int(counts[over & ~short, 2].sum()),
            near=int(np.count_nonzero(passed & ~alone)),
            events=len(events),
            alone=int(np.count_nonzero(alone)),
            alone_dropped=int(np.count_nonzero(alone & ~passed)),
            alone_owned=int(np.count_nonzero(alone & owned)),
            noise=int(noise.sum()),
            noise_us=int(lengths_us[noise].sum()),
        )

    def quality(self) -> Quality:
        """The figures of all parts."""
        sums = self._sums
        alive_mean = sums["alive_us"] / self._span_us
        tracks = sums["lives"] - sums["found_again"]
        return Quality(
            tracks=tracks,
            alive_mean=alive_mean,
            tracks_per_alive=tracks / alive_mean if alive_mean else None,
            short_us=self._short_us,
            short=sums["short"],
            short_merged=sums["short_merged"],
            short_lost=sums["short_lost"],
            owned_fraction=_share(sums["lasting"], sums["near"]),
            isolated_fraction=_share(sums["alone"], sums["events"]),
            isolated_dropped_fraction=_share(sums["alone_dropped"], sums["alone"]),
            isolated_owned_fraction=_share(sums["alone_owned"], sums["alone"]),
            noise_tracks=sums["noise"],
            noise_time_fraction=_share(sums["noise_us"], sums["alive_us"]),
            found_again=sums["found_again"],
            short_time_fraction=_share(sums["short_time_us"], sums["alive_us"]),
            absorbed=sums["absorbed"],
        )


def _share(part: int, whole: int) -> float | None:
    return part / whole if whole else None


def _travelled(log: TrackLog) -> NDArray[np.bool_]:
    """For each life, whether its places are further apart than a part of its box."""
    order, first = by_life(log)
    if not len(first):
        return np.empty(0, np.bool_)
    records = log.records[order]
    reach = np.hypot(*(np.maximum.reduceat(records[axis], first) - np.minimum.reduceat(records[axis], first) for axis in "xy"))
    side = np.maximum.reduceat(np.maximum(records["width"], records["height"]), first)
    return np.asarray(reach > _TRAVEL * side, np.bool_)


def _life_of_event(log: TrackLog, t_us: NDArray[np.int64], lives: NDArray[np.void]) -> NDArray[np.int64]:
    """For each event, the row of the life that it belongs to, -1 where its owner is none, or not visible at the time."""
    if not len(lives) or not len(t_us):
        return np.full(len(t_us), -1, np.int64)
    order = np.lexsort((lives["birth_us"], lives["slot"]))
    by_slot = lives[order]
    begin_us = int(min(t_us[0], lives["birth_us"].min()))
    span_us = int(max(t_us[-1], lives["end_us"].max())) - begin_us + 1
    slot = by_slot["slot"].astype(np.int64) * span_us - begin_us
    births, ends = slot + by_slot["birth_us"], slot + by_slot["end_us"]
    found = np.empty(len(t_us), np.int64)
    for begin in range(0, len(t_us), _RUN):
        run = slice(begin, begin + _RUN)
        owner = log.owner[run]
        by_owner = np.argsort(owner, kind="stable")  # within a slot they stay in time order
        keys = owner[by_owner].astype(np.int64) * span_us + (t_us[run][by_owner] - begin_us)
        first, past = np.searchsorted(keys, births, "left"), np.searchsorted(keys, ends, "right")
        past = np.minimum(past, np.append(first[1:], len(keys)))  # at the same time the later life of a slot owns
        steps = np.zeros(len(keys) + 1, np.int64)
        np.add.at(steps, first, order + 1)
        np.add.at(steps, past, -(order + 1))
        rows = np.empty(len(keys), np.int64)
        rows[by_owner] = np.cumsum(steps[:-1]) - 1
        found[run] = rows
    return found

# SPDX-License-Identifier: Apache-2.0
"""Compare the output of two trackers: numbers of clusters, distances, and matching lifetimes and merges."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import ConfigError
from .log import TrackLog
from .pairing import best_pairs, closest_pairs
from .timeline import MERGE, OPEN, FoundAgain, alive, lifetimes, merges, sample

__all__ = ["Agreement", "Comparison", "MergePair", "TrackPair", "compare"]

_STEP_US = 1_000
_STEPS_MAX = 20_000
_LARGEST = 10**12


@dataclass(frozen=True)
class TrackPair:
    """A hardware and a software track of the same object; differences are software minus hardware."""

    hardware_id: int
    software_id: int
    together_us: int
    birth_difference_us: int
    end_difference_us: int
    corresponds: bool  # both differences within the tolerance


@dataclass(frozen=True)
class MergePair:
    """A merge that both report, identified by the absorbed tracks; the difference is software minus hardware."""

    hardware_id: int
    software_id: int
    time_difference_us: int
    distance_px: float


@dataclass(frozen=True)
class Agreement:
    """Agreement of hardware and software. A figure without data (no samples, no pairs) is None.

    Attributes:
        begin_us, end_us, step_us: the times at which both logs were sampled.
        radius_px: largest distance between the centres of a pair.
        tolerance_us: largest time difference between births, ends and merges.
        samples: number of sample times.
        alive_equal_fraction: share of samples with the same number of clusters in both.
        alive_mean_difference: mean over the samples of |hardware - software|, clusters.
        alive_mean_hardware, alive_mean_software: mean number of clusters.
        distance_median_px, distance_p90_px: distance between the centres of pairs, over all samples.
        paired_fraction_hardware, paired_fraction_software: share of all cluster-samples that have a partner.
        tracks_hardware, tracks_software: number of tracks within the sampled span.
        tracks_corresponding: pairs of tracks whose births and ends both agree.
        tracks: all pairs of tracks, chosen to maximise the total time together.
        tracks_unpaired_hardware, tracks_unpaired_software: ids of the tracks without a partner.
        merges_hardware, merges_software: number of merges of each.
        merges: the merges that agree in time and place.
        merges_unpaired_hardware, merges_unpaired_software: ids of the absorbed tracks of all other merges.
    """

    begin_us: int
    end_us: int
    step_us: int
    radius_px: float
    tolerance_us: int
    samples: int
    alive_equal_fraction: float | None
    alive_mean_difference: float | None
    alive_mean_hardware: float | None
    alive_mean_software: float | None
    distance_median_px: float | None
    distance_p90_px: float | None
    paired_fraction_hardware: float | None
    paired_fraction_software: float | None
    tracks_hardware: int
    tracks_software: int
    tracks_corresponding: int
    tracks: tuple[TrackPair, ...]
    tracks_unpaired_hardware: tuple[int, ...]
    tracks_unpaired_software: tuple[int, ...]
    merges_hardware: int
    merges_software: int
    merges: tuple[MergePair, ...]
    merges_unpaired_hardware: tuple[int, ...]
    merges_unpaired_software: tuple[int, ...]

    def to_dict(self) -> dict[str, Any]:
        """Plain values, as summary.json stores them."""
        return asdict(self)


def compare(
    hardware: TrackLog,
    software: TrackLog,
    *,
    radius_px: float = 12.0,
    tolerance_us: int = 20_000,
    step_us: int | None = None,
    span_us: tuple[int, int] | None = None,
) -> Agreement:
    """Sample both logs at the same times, pair their clusters, tracks and merges, and compute the agreement.

    At each sample as many clusters as possible are paired, with the smallest total distance. Tracks are then paired to
    maximise their total time together; a track that is too short to be sampled has no partner.

    Args:
        hardware, software: the logs; either may be empty.
        radius_px: largest distance between the centres of a pair, and between the places of a merge.
        tolerance_us: largest time difference between births, ends and merges.
        step_us: sampling interval; by default 1 ms, or longer if that would take more than 20 000 steps.
        span_us: first and last time, usually those of the recording; by default those of the first and last record. Tracks
            that are still alive end with it.

    Raises:
        ConfigError: a value outside its range.
    """
    begin_us, end_us = _span(hardware, software) if span_us is None else span_us
    if step_us is None:
        step_us = _step_us(begin_us, end_us)
    for name, value, low in (("step_us", step_us, 1), ("tolerance_us", tolerance_us, 0), ("radius_px", radius_px, 0)):
        if not low <= value <= _LARGEST:
            raise ConfigError(f"compare.{name} = {value!r}: must be from {low} to {_LARGEST}")
    if end_us < begin_us:
        raise ConfigError(f"compare.span_us = ({begin_us}, {end_us}): must not end before it begins")

    nothing = span_us is None and not len(hardware.records) and not len(software.records)
    times_us = np.arange(begin_us, begin_us if nothing else end_us + 1, step_us)
    comparison = Comparison(begin_us, end_us, radius_px=radius_px, tolerance_us=tolerance_us, step_us=step_us)
    comparison.add(hardware, software, times_us)
    return comparison.agreement()


class Comparison:
    """The agreement of two logs that come in parts, see `tracks.log_parts.LogParts`: the same as of the whole.

    Memory holds the distances of all pairs, 8 bytes each at no more than 20 000 samples, and 75 bytes a track and a merge.

    Args:
        begin_us, end_us: of the recording; the others as of `compare`.
    """

    def __init__(
        self, begin_us: int, end_us: int, *, radius_px: float = 12.0, tolerance_us: int = 20_000, step_us: int | None = None
    ) -> None:
        self.begin_us, self.end_us = begin_us, end_us
        self.radius_px, self.tolerance_us = radius_px, tolerance_us
        self.step_us = _step_us(begin_us, end_us) if step_us is None else step_us
        self._lives: tuple[list[NDArray[np.void]], list[NDArray[np.void]]] = ([], [])
        self._found_again = FoundAgain(), FoundAgain()
        self._goes_on: tuple[list[NDArray[np.bool_]], list[NDArray[np.bool_]]] = ([], [])  # of each of the lives
        self._merges: tuple[list[NDArray[np.void]], list[NDArray[np.void]]] = ([], [])
        self._alive: tuple[list[NDArray[np.int64]], list[NDArray[np.int64]]] = ([], [])
        self._distances: list[NDArray[np.float64]] = []
        self._met: list[NDArray[np.int64]] = [np.empty((0, 2), np.int64)]

    def times_us(self, from_us: int, before_us: int | None) -> NDArray[np.int64]:
        """The sample times from `from_us` on and before `before_us`; None: to the end."""
        first = -(-(from_us - self.begin_us) // self.step_us)
        end_us = self.end_us + 1 if before_us is None else before_us
        return np.arange(self.begin_us + first * self.step_us, end_us, self.step_us)

    def add(
        self, hardware: TrackLog, software: TrackLog, times_us: NDArray[np.int64], *, last: bool = True
    ) -> tuple[NDArray[np.int64], NDArray[np.int64], int]:
        """Compare a part at its sample times; returns how many tracks are alive at each, on both sides, and how many pairs."""
        for side, (log, lives, merged, living) in enumerate(
            zip((hardware, software), self._lives, self._merges, self._alive, strict=True)
        ):
            own = lifetimes(log, self.end_us)
            over = (own["ended"] != OPEN) | last
            lives.append(own[over])
            self._goes_on[side].append(self._found_again[side].of(log, own)[over])
            merged.append(merges(log))
            living.append(alive(log, times_us))
        hw_ids, sw_ids, distance_px = _pair_clusters(sample(hardware, times_us), sample(software, times_us), self.radius_px)
        self._distances.append(distance_px)
        self._met.append(np.column_stack((hw_ids, sw_ids)))
        return self._alive[0][-1], self._alive[1][-1], len(distance_px)

    @property
    def lives(self) -> tuple[NDArray[np.void], NDArray[np.void]]:
        """The lifetimes of hardware and software, of dtype `timeline.LIFE`, in order of birth."""
        hardware, software = (_by_birth(parts) for parts in self._lives)
        return hardware, software

    def agreement(self) -> Agreement:
        """The agreement of all parts."""
        hw_alive, sw_alive = (np.concatenate([np.empty(0, np.int64), *parts]) for parts in self._alive)
        distance_px, met = np.concatenate([np.empty(0), *self._distances]), np.concatenate(self._met)
        hw_tracks, sw_tracks = map(_tracks_of, self._lives, self._goes_on)
        tracks, hw_alone, sw_alone = _pair_tracks(hw_tracks, sw_tracks, met[:, 0], met[:, 1], self.step_us, self.tolerance_us)
        hw_merges, sw_merges = (np.concatenate([np.empty(0, MERGE), *parts]) for parts in self._merges)
        joint, hw_merged, sw_merged = _pair_merges(hw_merges, sw_merges, self.radius_px, self.tolerance_us)
        return Agreement(
            begin_us=self.begin_us,
            end_us=self.end_us,
            step_us=self.step_us,
            radius_px=self.radius_px,
            tolerance_us=self.tolerance_us,
            samples=len(hw_alive),
            alive_equal_fraction=_mean(hw_alive == sw_alive),
            alive_mean_difference=_mean(np.abs(hw_alive - sw_alive)),
            alive_mean_hardware=_mean(hw_alive),
            alive_mean_software=_mean(sw_alive),
            distance_median_px=_quantile(distance_px, 0.5),
            distance_p90_px=_quantile(distance_px, 0.9),
            paired_fraction_hardware=_share(len(distance_px), int(hw_alive.sum())),
            paired_fraction_software=_share(len(distance_px), int(sw_alive.sum())),
            tracks_hardware=len(tracks) + len(hw_alone),
            tracks_software=len(tracks) + len(sw_alone),
            tracks_corresponding=sum(pair.corresponds for pair in tracks),
            tracks=tracks,
            tracks_unpaired_hardware=hw_alone,
            tracks_unpaired_software=sw_alone,
            merges_hardware=len(joint) + len(hw_merged),
            merges_software=len(joint) + len(sw_merged),
            merges=joint,
            merges_unpaired_hardware=hw_merged,
            merges_unpaired_software=sw_merged,
        )


def _by_birth(parts: list[NDArray[np.void]]) -> NDArray[np.void]:
    """The lives of all parts, which come as they end; equal births keep that order."""
    if len(parts) == 1:
        return parts[0]
    lives = np.concatenate(parts)
    return lives[np.argsort(lives["birth_us"], kind="stable")]


def _tracks_of(parts: list[NDArray[np.void]], goes_on: list[NDArray[np.bool_]]) -> NDArray[np.void]:
    """The tracks of all lives, in order of birth; one that was lost and found again lasts from its first life to its last."""
    lives, again = np.concatenate(parts), np.concatenate(goes_on)
    order = np.lexsort((lives["birth_us"], lives["track_id"]))
    first = np.flatnonzero(~again[order])
    last = np.append(first[1:], len(order)) - 1 if len(first) else first
    tracks = lives[order[first]]
    for name in ("end_us", "ended", "other_id"):
        tracks[name] = lives[name][order[last]]
    return tracks[np.argsort(order[first] if len(parts) == 1 else tracks["birth_us"], kind="stable")]


def _step_us(begin_us: int, end_us: int) -> int:
    return max(_STEP_US, -(-(end_us - begin_us) // _STEPS_MAX))


def _span(*logs: TrackLog) -> tuple[int, int]:
    ends = [int(log.records["t_us"][i]) for log in logs if len(log.records) for i in (0, -1)]
    return min(ends, default=0), max(ends, default=0)


def _mean(values: NDArray[Any]) -> float | None:
    return float(values.mean()) if len(values) else None


def _quantile(values: NDArray[np.float64], q: float) -> float | None:
    return float(np.quantile(values, q)) if len(values) else None


def _share(part: int, whole: int) -> float | None:
    return part / whole if whole else None


def _within(left: NDArray[np.number], right: NDArray[np.number], reach: float) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """All (i, j) with |left[i] - right[j]| <= reach; `right` ascending."""
    first = np.searchsorted(right, left - reach, "left")
    count = np.searchsorted(right, left + reach, "right") - first
    i = np.repeat(np.arange(len(left)), count)
    j = np.arange(len(i)) - np.repeat(np.cumsum(count) - count, count) + first[i]
    return i, j


def _distances(a: NDArray[np.void], b: NDArray[np.void]) -> NDArray[np.float64]:
    return np.asarray(np.hypot(a["x"] - b["x"], a["y"] - b["y"]), np.float64)


def _pair_clusters(
    hw: NDArray[np.void], sw: NDArray[np.void], radius_px: float
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
    """Hardware and software track ids, and distance, of every pair of every sample."""
    # Offset each sample in x by more than any distance: one search then finds all neighbours in x within the same sample.
    xs = np.concatenate((hw["x"], sw["x"]))
    stride = float(np.ptp(xs)) + 2 * radius_px + 1 if len(xs) else 1.0
    hw_x, sw_x = (rows["sample"] * stride + rows["x"] for rows in (hw, sw))
    by_x = np.argsort(sw_x)
    i, j = _within(hw_x, sw_x[by_x], radius_px + 1e-3)
    j = by_x[j]
    distance_px = _distances(hw[i], sw[j])
    near = distance_px <= radius_px
    i, j, distance_px = i[near], j[near], distance_px[near]
    chosen = closest_pairs(i, j, distance_px)
    return hw["track_id"][i[chosen]], sw["track_id"][j[chosen]], distance_px[chosen]


def _pair_tracks(
    hw: NDArray[np.void],
    sw: NDArray[np.void],
    hw_ids: NDArray[np.int64],
    sw_ids: NDArray[np.int64],
    step_us: int,
    tolerance_us: int,
) -> tuple[tuple[TrackPair, ...], tuple[int, ...], tuple[int, ...]]:
    """Pairs of tracks, and the unpaired ids of both sides, all in order of birth."""
    hw_row = {int(track_id): row for row, track_id in enumerate(hw["track_id"])}
    sw_row = {int(track_id): row for row, track_id in enumerate(sw["track_id"])}
    met, together = np.unique(np.column_stack((hw_ids, sw_ids)), axis=0, return_counts=True)
    i = np.array([hw_row[track_id] for track_id in met[:, 0].tolist()], np.int64)
    j = np.array([sw_row[track_id] for track_id in met[:, 1].tolist()], np.int64)
    chosen = best_pairs(i, j, together.astype(np.float64))
    chosen = chosen[np.argsort(i[chosen])]
    pairs = []
    for a, b, samples in zip(hw[i[chosen]], sw[j[chosen]], together[chosen], strict=True):
        birth_us, end_us = int(b["birth_us"] - a["birth_us"]), int(b["end_us"] - a["end_us"])
        pairs.append(
            TrackPair(
                hardware_id=int(a["track_id"]),
                software_id=int(b["track_id"]),
                together_us=int(samples) * step_us,
                birth_difference_us=birth_us,
                end_difference_us=end_us,
                corresponds=abs(birth_us) <= tolerance_us and abs(end_us) <= tolerance_us,
            )
        )
    return tuple(pairs), _others(hw["track_id"], i[chosen]), _others(sw["track_id"], j[chosen])


def _pair_merges(
    hw: NDArray[np.void], sw: NDArray[np.void], radius_px: float, tolerance_us: int
) -> tuple[tuple[MergePair, ...], tuple[int, ...], tuple[int, ...]]:
    """Pairs of merges, and the absorbed ids of the unpaired merges of both sides, all in order of time."""
    i, j = _within(hw["t_us"], sw["t_us"], tolerance_us)
    near = _distances(hw[i], sw[j]) <= radius_px
    i, j = i[near], j[near]
    late_us, distance_px = sw["t_us"][j] - hw["t_us"][i], _distances(hw[i], sw[j])
    chosen = closest_pairs(i, j, np.abs(late_us) / max(tolerance_us, 1) + distance_px / max(radius_px, 1.0))
    pairs = tuple(
        MergePair(int(hw["track_id"][i[k]]), int(sw["track_id"][j[k]]), int(late_us[k]), float(distance_px[k])) for k in chosen
    )
    return pairs, _others(hw["track_id"], i[chosen]), _others(sw["track_id"], j[chosen])


def _others(ids: NDArray[np.int64], taken: NDArray[np.int64]) -> tuple[int, ...]:
    return tuple(np.delete(ids, taken).tolist())

# SPDX-License-Identifier: Apache-2.0
"""Compare the output of two trackers: numbers of clusters, distances, and matching lifetimes and merges."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import ConfigError
from .column import Column, GrowingColumn, HeldColumn, PackedColumn, in_runs
from .log import TrackLog
from .timeline import MERGE, OPEN, FoundAgain, alive, lifetimes, merges, sample
from .track_pairs import ROW, PairedTracks, closest_pairs, pair_merges, pair_tracks, within

__all__ = ["Agreement", "Comparison", "MergePair", "TrackPair", "compare"]

_STEP_US = 1_000
_STEPS_MAX = 20_000
_LARGEST = 10**12
_TRACK_PAIR = np.dtype(
    [(name, "<i8") for name in ("hardware_id", "software_id", "together_us")]
    + [("birth_difference_us", "<i8"), ("end_difference_us", "<i8"), ("corresponds", "?")]
)
_MERGE_PAIR = ["hardware_id", "software_id", "late_us", "distance_px"]


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
        tracks_paired, tracks_corresponding: pairs of tracks; those whose births and ends both agree.
        tracks: the pairs of tracks, chosen to maximise the total time together.
        tracks_unpaired_hardware, tracks_unpaired_software: ids of the tracks without a partner.
        merges_hardware, merges_software, merges_paired: number of merges of each, and of those that agree in time and place.
        merges_comparable_hardware, merges_comparable_software: of the merges, those that agree, and those whose absorbed track
            has a partner: without one, the other side has nothing there that could have merged.
        merges: the merges that agree.
        merges_unpaired_hardware, merges_unpaired_software: ids of the absorbed tracks of the other merges.

    Pairs and ids are in order of birth and of time; of a long run only the first ones, see `Comparison`.
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
    tracks_paired: int
    tracks_corresponding: int
    tracks: tuple[TrackPair, ...]
    tracks_unpaired_hardware: tuple[int, ...]
    tracks_unpaired_software: tuple[int, ...]
    merges_hardware: int
    merges_software: int
    merges_paired: int
    merges_comparable_hardware: int
    merges_comparable_software: int
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

    Memory holds the pairs of at most 20 000 samples, a bit a track and a byte a merge; without `folder`, all lives and merges.

    Args:
        begin_us, end_us: of the recording; the others as of `compare`.
        folder: for files with lives and merges, which the caller removes after `close`.
        most: of pairs and of ids, the agreement lists no more; None: all.
    """

    def __init__(
        self,
        begin_us: int,
        end_us: int,
        *,
        radius_px: float = 12.0,
        tolerance_us: int = 20_000,
        step_us: int | None = None,
        folder: Path | None = None,
        most: int | None = None,
    ) -> None:
        self.begin_us, self.end_us = begin_us, end_us
        self.radius_px, self.tolerance_us = radius_px, tolerance_us
        self.step_us = _step_us(begin_us, end_us) if step_us is None else step_us
        self.most = most
        self._parts = 0
        self._tracks = [0, 0]
        self._lives = _column(folder, "hardware.lives", ROW), _column(folder, "software.lives", ROW)
        self._merges = _column(folder, "hardware.merges", MERGE), _column(folder, "software.merges", MERGE)
        self._found_again = FoundAgain(), FoundAgain()
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
        self._parts += 1
        for side, (log, lives, merged, living) in enumerate(
            zip((hardware, software), self._lives, self._merges, self._alive, strict=True)
        ):
            own = lifetimes(log, self.end_us)
            over = (own["ended"] != OPEN) | last
            rows = np.empty(len(own), ROW)
            for name in ROW.names or ():
                rows[name] = self._found_again[side].of(log, own) if name == "goes_on" else own[name]
            lives.append(rows[over])
            self._tracks[side] += int(np.count_nonzero(over & ~rows["goes_on"]))
            merged.append(merges(log))
            living.append(alive(log, times_us))
        hw_ids, sw_ids, distance_px = _pair_clusters(sample(hardware, times_us), sample(software, times_us), self.radius_px)
        self._distances.append(distance_px)
        self._met.append(np.column_stack((hw_ids, sw_ids)))
        return self._alive[0][-1], self._alive[1][-1], len(distance_px)

    @property
    def lives(self) -> tuple[Column, Column]:
        """The lives of hardware and software, of dtype `track_pairs.ROW`, as they ended."""
        return self._lives

    def close(self) -> None:
        """Close the files."""
        for column in (*self._lives, *self._merges):
            if isinstance(column, PackedColumn):
                column.close()

    def agreement(self) -> Agreement:
        """The agreement of all parts."""
        hw_alive, sw_alive = (np.concatenate([np.empty(0, np.int64), *parts]) for parts in self._alive)
        distance_px, met = np.concatenate([np.empty(0), *self._distances]), np.concatenate(self._met)
        paired = pair_tracks(*self._lives, met, by_row=self._parts == 1, most=self.most)
        tracks = _track_pairs(paired, self.step_us, self.tolerance_us)
        joint = pair_merges(*self._merges, self.radius_px, self.tolerance_us, self.most)
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
            tracks_hardware=self._tracks[0],
            tracks_software=self._tracks[1],
            tracks_paired=len(tracks),
            tracks_corresponding=int(np.count_nonzero(tracks["corresponds"])),
            tracks=tuple(TrackPair(*row) for row in tracks[: self.most].tolist()),
            tracks_unpaired_hardware=tuple(paired.hardware_alone.tolist()),
            tracks_unpaired_software=tuple(paired.software_alone.tolist()),
            merges_hardware=len(self._merges[0]),
            merges_software=len(self._merges[1]),
            merges_paired=joint.count,
            merges_comparable_hardware=_comparable(self._merges[0], joint.taken[0], tracks["hardware_id"]),
            merges_comparable_software=_comparable(self._merges[1], joint.taken[1], tracks["software_id"]),
            merges=tuple(MergePair(*row) for row in joint.pairs[_MERGE_PAIR].tolist()),
            merges_unpaired_hardware=tuple(joint.hardware_alone.tolist()),
            merges_unpaired_software=tuple(joint.software_alone.tolist()),
        )


def _track_pairs(paired: PairedTracks, step_us: int, tolerance_us: int) -> NDArray[np.void]:
    """The fields of a `TrackPair` for each pair."""
    hw, sw = paired.hardware, paired.software
    rows = np.empty(len(hw), _TRACK_PAIR)
    rows["hardware_id"], rows["software_id"], rows["together_us"] = hw["track_id"], sw["track_id"], paired.samples * step_us
    rows["corresponds"] = True
    for name, end in (("birth_difference_us", "birth_us"), ("end_difference_us", "end_us")):
        rows[name] = sw[end] - hw[end]
        rows["corresponds"] &= np.abs(rows[name]) <= tolerance_us
    return rows


def _comparable(merged: Column, taken: NDArray[np.bool_], tracks: NDArray[np.int64]) -> int:
    """How many merges are taken, or absorb one of the tracks."""
    found = 0
    for begin, run in in_runs(merged):
        found += int(np.count_nonzero(taken[begin : begin + len(run)] | np.isin(run["track_id"], tracks)))
    return found


def _column(folder: Path | None, name: str, dtype: np.dtype[Any]) -> GrowingColumn:
    return HeldColumn(dtype) if folder is None else PackedColumn(folder / name, dtype)


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
    i, j = within(hw_x, sw_x[by_x], radius_px + 1e-3)
    j = by_x[j]
    distance_px = _distances(hw[i], sw[j])
    near = distance_px <= radius_px
    i, j, distance_px = i[near], j[near], distance_px[near]
    chosen = closest_pairs(i, j, distance_px)
    return hw["track_id"][i[chosen]], sw["track_id"][j[chosen]], distance_px[chosen]

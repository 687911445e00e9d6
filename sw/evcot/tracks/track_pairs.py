# SPDX-License-Identifier: Apache-2.0
"""Which tracks, and which merges, of two logs are the same ones: those near each other in place and time."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from importlib.machinery import PathFinder
from importlib.util import find_spec, module_from_spec
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .column import Column, in_runs
from .timeline import LIFE, MERGE

__all__ = [
    "ROW",
    "PairedMerges",
    "PairedTracks",
    "assignment",
    "best_pairs",
    "closest_pairs",
    "most_first",
    "pair_merges",
    "pair_tracks",
    "within",
]


def assignment(gain: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Rows and columns, each at most once, that maximise the total gain; rows ascending.

    Args:
        gain: (rows, columns) gain of each pair.
    """
    rows, columns = _solver()(gain, maximize=True)
    return rows, columns


@cache
def _solver() -> Callable[..., tuple[NDArray[np.int64], NDArray[np.int64]]]:
    """`scipy.optimize.linear_sum_assignment`: from its extension module alone, as its package takes 0.5 s to import."""
    package = find_spec("scipy")
    places = [str(Path(place) / "optimize") for place in (package and package.submodule_search_locations) or ()]
    extension = PathFinder.find_spec("_lsap", places)
    if extension is not None and extension.loader is not None:
        with suppress(ImportError, AttributeError):
            module = module_from_spec(extension)
            extension.loader.exec_module(module)
            found: Callable[..., tuple[NDArray[np.int64], NDArray[np.int64]]] = module.linear_sum_assignment
            return found
    from scipy.optimize import linear_sum_assignment

    solver: Callable[..., tuple[NDArray[np.int64], NDArray[np.int64]]] = linear_sum_assignment
    return solver


def best_pairs(left: NDArray[np.int64], right: NDArray[np.int64], gain: NDArray[np.float64]) -> NDArray[np.int64]:
    """Choose pairs, with each element in at most one, that maximise the total gain.

    The pairs are split into connected components, which are solved independently, so that the cost depends on the size of
    the components and not on the total.

    Args:
        left, right: (n,) the allowed pairs, each once, as non-negative element indices.
        gain: (n,) gain of each pair, above 0.

    Returns:
        Indices of the chosen pairs, ascending.
    """
    if not len(left):
        return np.empty(0, np.int64)
    # As in `assignment`: a command that compares nothing loads none of scipy.
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    n_left = int(left.max()) + 1
    size = n_left + int(right.max()) + 1
    graph = coo_array((np.ones(len(left), np.int8), (left, n_left + right)), shape=(size, size))
    group = connected_components(graph, directed=False)[1][left]
    order = np.argsort(group, kind="stable")
    starts = np.flatnonzero(np.diff(group[order], prepend=-1))
    sizes = np.diff(starts, append=len(order))
    chosen = [order[starts[sizes == 1]]]
    for start, count in zip(starts[sizes > 1], sizes[sizes > 1], strict=True):
        pairs = order[start : start + count]
        rows, row = np.unique(left[pairs], return_inverse=True)
        columns, column = np.unique(right[pairs], return_inverse=True)
        gains = np.zeros((len(rows), len(columns)))
        gains[row, column] = gain[pairs]
        index = np.full(gains.shape, -1)
        index[row, column] = pairs
        picked = index[assignment(gains)]
        chosen.append(picked[picked >= 0])
    return np.sort(np.concatenate(chosen))


def closest_pairs(left: NDArray[np.int64], right: NDArray[np.int64], cost: NDArray[np.float64]) -> NDArray[np.int64]:
    """Choose as many pairs as possible and, among all such choices, the one with the smallest total cost.

    Args:
        left, right: (n,) the allowed pairs.
        cost: (n,) cost of each pair, at least 0.

    Returns:
        Indices of the chosen pairs, ascending.
    """
    if not len(left):
        return np.empty(0, np.int64)
    return best_pairs(left, right, most_first(len(left), float(cost.max())) - cost)


def most_first(count: int, dearest: float) -> float:
    """What a pair is worth, before its cost, so that one more pair is worth more than the cost of all others.

    Args:
        count: number of allowed pairs.
        dearest: the largest cost of one.
    """
    return (count + 1) * max(dearest, 1.0)


def within(left: NDArray[np.number], right: NDArray[np.number], reach: float) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """All (i, j) with |left[i] - right[j]| <= reach; `right` ascending."""
    first = np.searchsorted(right, left - reach, "left")
    count = np.searchsorted(right, left + reach, "right") - first
    i = np.repeat(np.arange(len(left)), count)
    j = np.arange(len(i)) - np.repeat(np.cumsum(count) - count, count) + first[i]
    return i, j


ROW = np.dtype([(name, LIFE[name]) for name in ("track_id", "birth_us", "end_us", "ended")] + [("goes_on", "?")])
"""A life, and whether it goes on with a track that was lost before."""

_TRACK = np.dtype([*ROW.descr, ("row", "<i8")])  # from its first life to the end of its last; the number of the first one


@dataclass(frozen=True)
class PairedTracks:
    """Pairs, in order of the hardware track's birth, and tracks without a partner.

    Attributes:
        hardware, software: (n,) the tracks of each pair: `track_id`, `birth_us`, `end_us`.
        samples: (n,) how often each pair met.
        hardware_alone, software_alone: ids of the first tracks without a partner, in order of birth.
    """

    hardware: NDArray[np.void]
    software: NDArray[np.void]
    samples: NDArray[np.int64]
    hardware_alone: NDArray[np.int64]
    software_alone: NDArray[np.int64]


def pair_tracks(hardware: Column, software: Column, met: NDArray[np.int64], *, by_row: bool, most: int | None) -> PairedTracks:
    """Pair tracks so that their total time together is longest.

    Args:
        hardware, software: rows of dtype `ROW`.
        met: (k, 2) hardware and software id, for each sample at which they were paired.
        by_row: rows are in order of birth; otherwise equal births are in order of ids.
        most: largest number of ids without a partner; None: all.
    """
    met, together = np.unique(met, axis=0, return_counts=True)
    hw, sw = (_tracks(rows, np.unique(met[:, side]), by_row=by_row) for side, rows in enumerate((hardware, software)))
    i, j = _row_of(hw, met[:, 0]), _row_of(sw, met[:, 1])
    chosen = best_pairs(i, j, together.astype(np.float64))
    chosen = chosen[np.argsort(i[chosen])]
    ours, theirs = hw[i[chosen]], sw[j[chosen]]
    alone = (_other_tracks(rows, np.sort(own["row"]), by_row, most) for rows, own in ((hardware, ours), (software, theirs)))
    return PairedTracks(ours, theirs, together[chosen], *alone)


def _tracks(rows: Column, ids: NDArray[np.int64], *, by_row: bool) -> NDArray[np.void]:
    """The tracks with these ids, in order of birth; one that was lost and found again lasts from its first life to its last."""
    parts = [np.empty(0, _TRACK)]
    for begin, run in in_runs(rows):
        which = np.flatnonzero(np.isin(run["track_id"], ids))
        part = np.empty(len(which), _TRACK)
        for name in ROW.names or ():
            part[name] = run[name][which]
        part["row"] = begin + which
        parts.append(part)
    lives = np.concatenate(parts)
    lives = lives[np.lexsort((lives["birth_us"], lives["track_id"]))]
    first = np.flatnonzero(~lives["goes_on"])
    last = np.append(first[1:], len(lives)) - 1 if len(first) else first
    tracks = lives[first]
    tracks["end_us"] = lives["end_us"][last]
    return tracks[_by_birth(tracks, by_row)]


def _by_birth(tracks: NDArray[np.void], by_row: bool) -> NDArray[np.int64]:
    return np.lexsort((tracks["row"],) if by_row else (tracks["row"], tracks["track_id"], tracks["birth_us"]))


def _row_of(tracks: NDArray[np.void], ids: NDArray[np.int64]) -> NDArray[np.int64]:
    """Where each id is; of tracks with the same id, the last one."""
    order = np.argsort(tracks["track_id"], kind="stable")
    return order[np.searchsorted(tracks["track_id"][order], ids, "right") - 1] if len(order) else np.empty(0, np.int64)


def _other_tracks(rows: Column, taken: NDArray[np.int64], by_row: bool, most: int | None) -> NDArray[np.int64]:
    """Ids of the first tracks whose first lives are not the rows `taken`, which ascend."""
    found = np.empty(0, _TRACK)
    for begin, run in in_runs(rows):
        free = ~run["goes_on"]
        free[taken[slice(*np.searchsorted(taken, (begin, begin + len(run))))] - begin] = False
        which = np.flatnonzero(free)
        part = np.empty(len(which), _TRACK)
        for name in ("track_id", "birth_us"):
            part[name] = run[name][which]
        part["row"] = begin + which
        found = np.concatenate((found, part))
        found = found[_by_birth(found, by_row)[:most]]
    return np.asarray(found["track_id"], np.int64)


# Which merges of two logs are the same one: those near each other in time and place.
#
# Merges come as rows of dtype `timeline.MERGE` in order of time, and are read run by run: memory holds what is near a run,
# and a byte a merge.

_RUN = 1 << 14
_PAIR = np.dtype(
    [
        ("i", "<i8"),  # numbers of the hardware's and the software's merge
        ("j", "<i8"),
        ("hardware_id", "<i8"),  # of the absorbed tracks
        ("software_id", "<i8"),
        ("late_us", "<i8"),  # software minus hardware
        ("distance_px", "<f8"),
        ("cost", "<f8"),
    ]
)


@dataclass(frozen=True)
class PairedMerges:
    """Merges that are the same, and those that one side has alone, all in order of time.

    Attributes:
        count: number of pairs.
        pairs: the first ones: `hardware_id`, `software_id`, `late_us`, `distance_px`.
        hardware_alone, software_alone: absorbed ids of the first merges without a partner.
        taken: for hardware and software, which merges have a partner.
    """

    count: int
    pairs: NDArray[np.void]
    hardware_alone: NDArray[np.int64]
    software_alone: NDArray[np.int64]
    taken: tuple[NDArray[np.bool_], NDArray[np.bool_]]


def pair_merges(hardware: Column, software: Column, radius_px: float, tolerance_us: int, most: int | None) -> PairedMerges:
    """Pair as many merges as possible, and of these choices the nearest.

    Args:
        radius_px, tolerance_us: largest distance of a pair in place and in time.
        most: largest number of pairs and of ids that are returned; None: all.
    """

    def allowed() -> Iterator[tuple[int, NDArray[np.void]]]:
        return _allowed(hardware, software, radius_px, tolerance_us)

    total, dearest = 0, 0.0
    for _, part in allowed():
        total, dearest = total + len(part), max(dearest, float(part["cost"].max(initial=0.0)))
    gain = most_first(total, dearest)
    taken = np.zeros(len(hardware), np.bool_), np.zeros(len(software), np.bool_)
    count, pairs, waiting = 0, np.empty(0, _PAIR), np.empty(0, _PAIR)
    for next_j, part in allowed():
        part = np.concatenate((waiting, part))
        done = _separate(part, next_j)
        part, waiting = part[:done], part[done:].copy()
        chosen = part[best_pairs(part["i"], part["j"], gain - part["cost"])]
        taken[0][chosen["i"]] = taken[1][chosen["j"]] = True
        count, pairs = count + len(chosen), np.concatenate((pairs, chosen))[:most]
    return PairedMerges(count, pairs, _other_merges(hardware, taken[0], most), _other_merges(software, taken[1], most), taken)


def _allowed(hw: Column, sw: Column, radius_px: float, tolerance_us: int) -> Iterator[tuple[int, NDArray[np.void]]]:
    """For each run of the hardware, the pairs that are near each other, and the first `j` that a later run may have."""
    first, held = 0, np.empty(0, MERGE)
    for begin, run in in_runs(hw, _RUN):
        early_us, late_us = run["t_us"][0] - tolerance_us, run["t_us"][-1] + tolerance_us
        while first + len(held) < len(sw) and (not len(held) or held["t_us"][-1] <= late_us):
            past = first + len(held)
            held = np.concatenate((held, sw[past : past + _RUN]))
            over = int(np.searchsorted(held["t_us"], early_us))
            first, held = first + over, held[over:]
        i, j = within(run["t_us"], held["t_us"], tolerance_us)
        distance_px = np.hypot(run["x"][i] - held["x"][j], run["y"][i] - held["y"][j])
        near = distance_px <= radius_px
        i, j, distance_px = i[near], j[near], distance_px[near]
        part = np.empty(len(i), _PAIR)
        part["i"], part["j"], part["distance_px"] = begin + i, first + j, distance_px
        part["hardware_id"], part["software_id"] = run["track_id"][i], held["track_id"][j]
        part["late_us"] = held["t_us"][j] - run["t_us"][i]
        part["cost"] = np.abs(part["late_us"]) / max(tolerance_us, 1) + distance_px / max(radius_px, 1.0)
        last = begin + len(run) == len(hw)
        later = first + int(np.searchsorted(held["t_us"], run["t_us"][-1] - tolerance_us))
        yield len(sw) if last else later, part


def _separate(pairs: NDArray[np.void], next_j: int) -> int:
    """How many pairs, in order of `i`, share no merge with the others or with later ones, whose `j` is `next_j` or more."""
    i, j = pairs["i"], pairs["j"]
    before = np.append(-1, np.maximum.accumulate(j))
    after = np.append(np.minimum(np.minimum.accumulate(j[::-1])[::-1], next_j), next_j)
    other = np.concatenate(([True], i[1:] != i[:-1], [True]))[: len(pairs) + 1]
    return int(np.flatnonzero(other & (before < after))[-1])


def _other_merges(merges: Column, taken: NDArray[np.bool_], most: int | None) -> NDArray[np.int64]:
    found = np.empty(0, np.int64)
    for begin, run in in_runs(merges, _RUN):
        found = np.concatenate((found, run["track_id"][~taken[begin : begin + len(run)]]))[:most]
        if len(found) == most:
            break
    return found

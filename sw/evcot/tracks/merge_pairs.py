# SPDX-License-Identifier: Apache-2.0
"""Which merges of two logs are the same one: those near each other in time and place.

Merges come as rows of dtype `timeline.MERGE` in order of time, and are read run by run: memory holds what is near a run, and a
byte a merge.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .column import Column, in_runs
from .pairing import best_pairs, most_first, within
from .timeline import MERGE

__all__ = ["PairedMerges", "pair_merges"]

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
    return PairedMerges(count, pairs, _others(hardware, taken[0], most), _others(software, taken[1], most), taken)


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


def _others(merges: Column, taken: NDArray[np.bool_], most: int | None) -> NDArray[np.int64]:
    found = np.empty(0, np.int64)
    for begin, run in in_runs(merges, _RUN):
        found = np.concatenate((found, run["track_id"][~taken[begin : begin + len(run)]]))[:most]
        if len(found) == most:
            break
    return found

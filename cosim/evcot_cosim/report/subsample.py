# SPDX-License-Identifier: Apache-2.0
"""Subsampling of long runs, so that a report stays small."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from evcot.tracks.log import Kind

__all__ = ["EVENTS_MAX", "LIVES_MAX", "RECORDS_MAX", "longest_lives", "thinned_events", "thinned_records"]

EVENTS_MAX = 2_000_000
LIVES_MAX = 4_000  # per side
RECORDS_MAX = 200_000  # per side

_SEED = 1


def thinned_events(n: int, most: int) -> NDArray[np.int64]:
    """At most `most` of the numbers 0 to n - 1, ascending: one random number from each of `most` equal intervals."""
    if n <= most:
        return np.arange(n)
    edges = np.linspace(0, n, most + 1).astype(np.int64)
    at = np.random.default_rng(_SEED).random(most)
    return edges[:-1] + (at * np.diff(edges)).astype(np.int64)


def longest_lives(lives: NDArray[np.void], most: int = LIVES_MAX) -> NDArray[np.bool_]:
    """Select the `most` longest rows of dtype `timeline.LIFE`; (k,) bool."""
    keep = np.ones(len(lives), np.bool_)
    keep[np.argsort(lives["birth_us"] - lives["end_us"], kind="stable")[most:]] = False
    return keep


def thinned_records(kind: NDArray[np.uint8], most: int = RECORDS_MAX) -> NDArray[np.bool_]:
    """Select records of a log: every birth and end, and an even selection of moves up to the limit."""
    moved = kind == Kind.MOVED
    room = max(most - int(np.count_nonzero(~moved)), 0)
    keep: NDArray[np.bool_] = ~moved
    keep[np.flatnonzero(moved)[thinned_events(int(moved.sum()), room)]] = True
    return keep

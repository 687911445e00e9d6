# SPDX-License-Identifier: Apache-2.0
"""When clusters merge, with options; the paper's merging is in test_tracker.py."""

from __future__ import annotations

from dataclasses import replace

import pytest

from evcot.trackers.rct.config import RctConfig
from evcot.tracks.log import Kind

from .stories import events_of, of_kind, still, tracked

BASE = RctConfig(radius_px=10.0, alpha=0.25)


def merges(rows: list[tuple[int, int, int]], config: RctConfig) -> int:
    """How many visible clusters merged."""
    return len(of_kind(tracked(events_of(rows), config)[0], Kind.MERGED))


@pytest.mark.parametrize(
    ("share", "gap_px", "merged"), [(0.0, 20, 1), (0.0, 21, 0), (0.2, 16, 1), (0.2, 17, 0), (0.44, 11, 1), (0.46, 11, 0)]
)
def test_two_merge_that_share_enough_of_the_smaller_window(share: float, gap_px: int, merged: int) -> None:
    """Windows of 20 px, side by side: 20 - gap of 20 is shared."""
    rows = still(100, 50, 6) + still(100 + gap_px, 50, 6, begin_us=100)
    assert merges(rows, replace(BASE, merge_overlap=share)) == merged


def test_merging_can_be_turned_off() -> None:
    assert merges(still(100, 50, 6) + still(112, 50, 6, begin_us=100), replace(BASE, merge_overlap=1.1)) == 0


@pytest.mark.parametrize(("rate_hz", "survivor", "x"), [(0.0, 0, 108.2), (100.0, 1, 115.3)])
def test_the_older_stays_or_by_rate_the_one_with_more_events_of_late(rate_hz: float, survivor: int, x: float) -> None:
    """The first had 60 events 40 ms ago and 10 now, the other 59 now; that one drifts into the first one's reach."""
    now_us = 40_000
    rows = [
        *still(100, 50, 60),
        *still(100, 50, 10, now_us),
        *still(121, 50, 30, now_us + 20),
        *still(118, 50, 29, now_us + 1_000),
    ]
    records, _, clusters = tracked(events_of(rows), replace(BASE, visible_rate_hz=rate_hz))
    (merged,) = of_kind(records, Kind.MERGED)
    assert (merged["track_id"], merged["other_id"]) == (1 - survivor, survivor)
    assert clusters["x"] == pytest.approx([x], abs=0.1)

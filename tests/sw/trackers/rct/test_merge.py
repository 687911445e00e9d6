# SPDX-License-Identifier: Apache-2.0
"""When clusters merge, with options; the paper's merging is in test_tracker.py."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from evcot.trackers.rct.config import RctConfig
from evcot.tracks.log import Kind

from .stories import events_of, object_at, of_kind, still, together, tracked

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
    assert merges(still(100, 50, 6) + still(112, 50, 6, begin_us=100), replace(BASE, merging=False)) == 0


@pytest.mark.parametrize(("veto", "merged"), [(180.0, True), (90.0, False)])
def test_fast_clusters_that_meet_head_on_pass_each_other(veto: float, merged: bool) -> None:
    events = together(
        object_at((200, 300), (400, 0), half=(4, 4), us=(0, 500_000)),
        object_at((400, 304), (-400, 0), half=(4, 4), us=(0, 500_000), seed=2),
    )
    config = replace(
        BASE, radius_px=7.0, alpha=0.05, velocity="regression", path_points=20, predict=1.0, merge_angle_deg=veto,
        merge_overlap=0.05,
    )  # fmt: skip
    records = tracked(events, config)[0]
    assert (len(of_kind(records, Kind.MERGED)) > 0) == merged
    if not merged:
        last = {int(i): records[records["track_id"] == i][-1] for i in np.unique(records["track_id"])}
        assert (last[0]["x"], last[1]["x"]) == pytest.approx((400, 200), abs=4)


def test_slow_clusters_merge_whatever_their_directions() -> None:
    rows = [row for i in range(60) for row in [(1_000 * i, 100 + i // 12, 50), (1_000 * i + 500, 122 - i // 12, 50)]]
    config = replace(BASE, merge_angle_deg=10.0, velocity_alpha=0.5)
    assert merges(rows, replace(config, merge_speed_px_s=10_000.0)) == 1
    assert merges(rows, replace(config, merge_speed_px_s=0.0)) == 0


@pytest.mark.parametrize("grow", [False, True])
def test_the_one_that_stays_can_grow_to_cover_both(grow: bool) -> None:
    rows = still(100, 50, 6) + still(116, 50, 6, begin_us=100)
    (cluster,) = tracked(events_of([*rows, (1_000, 108, 50)]), replace(BASE, merge_grow=grow))[2]
    assert cluster["x"] == pytest.approx(108)
    assert cluster["half_width"] == pytest.approx(18 if grow else 10)
    assert cluster["half_height"] == 10


def test_on_and_off_do_not_merge_where_they_are_separate() -> None:
    rows = still(100, 50, 10) + still(105, 50, 10, begin_us=100)
    polarities = [0] * 10 + [1] * 10
    for polarity, merged in (("separate", 0), ("both", 0)):
        records = tracked(events_of(rows, polarities), replace(BASE, polarity=polarity))[0]
        assert len(of_kind(records, Kind.MERGED)) == merged
        assert len(of_kind(records, Kind.BORN)) == (2 if polarity == "separate" else 1)


@pytest.mark.parametrize(("into", "survivor", "x"), [("older", 0, 105.4), ("heavier", 1, 113.5)])
def test_the_one_that_stays_is_the_older_or_the_one_with_more_events_of_late(into: str, survivor: int, x: float) -> None:
    """The first had 60 events 40 ms ago and 10 now, the other 30 now; that one drifts into the first one's reach."""
    now_us = 40_000
    now = still(100, 50, 10, now_us) + still(121, 50, 1, now_us + 20) + still(118, 50, 29, now_us + 30)
    config = replace(BASE, merge_into=into, mass_tau_us=1_000.0)
    records, _, clusters = tracked(events_of(still(100, 50, 60) + now), config)
    (merged,) = of_kind(records, Kind.MERGED)
    assert (merged["track_id"], merged["other_id"]) == (1 - survivor, survivor)
    assert clusters["x"] == pytest.approx([x], abs=0.1)

# SPDX-License-Identifier: Apache-2.0
"""The sets of clusters by cell: seats run out repeatedly, without any effect on the result."""

from __future__ import annotations

from dataclasses import replace

import pytest

from evcot.trackers.rct.config import RctConfig

from .stories import events_of, tracked

SEATS = 64  # of a tracker with few clusters
CONFIG = RctConfig(max_clusters=8, radius_px=10.0, lifetime_us=1_500, surround=1.7)


def strays(n: int) -> list[tuple[int, int, int]]:
    """Single events, a millisecond apart, at distant positions: each takes a seat and is soon removed."""
    return [(1_000 * k, 700, 90 * (k % 11)) for k in range(n)]


@pytest.mark.parametrize("assign", ["nearest", "first"])
def test_an_old_cluster_keeps_its_window_and_its_surround(assign: str) -> None:
    rows = [row for t, x, y in strays(5 * SEATS) for row in ((t, 300, 300), (t + 1, 300, 312), (t + 2, x, y))]
    owners = tracked(events_of(rows), replace(CONFIG, assign=assign))[1].reshape(-1, 3)
    assert (owners[:, :2] == (0, -1)).all()
    assert set(owners[:, 2].tolist()) == {1, 2}

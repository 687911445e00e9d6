# SPDX-License-Identifier: Apache-2.0
"""Clusters that leave the sensor."""

from __future__ import annotations

import pytest

from evcot.errors import ConfigError
from evcot.trackers.rct.config import RctConfig
from evcot.trackers.rct.tracker import RctTracker
from evcot.tracks.log import Kind

from .stories import WIDTH, events_of, of_kind, still, tracked


@pytest.mark.parametrize(
    ("x", "y", "dropped"),
    [(500, 500, False), (0, 500, False), (WIDTH - 1, 500, False), (2, 2, True), (WIDTH - 2, WIDTH - 2, True), (12, 0, False)],
)
def test_a_window_mostly_outside_loses_its_cluster(x: int, y: int, dropped: bool) -> None:
    """At an edge half the window is outside, in a corner three quarters."""
    rows = [*still(x, y, 20), (1_500, 400, 700)]
    records = tracked(events_of(rows), RctConfig(radius_px=10.0, border_share=0.6))[0]
    lost = of_kind(records, Kind.LOST)
    assert len(lost) == dropped
    if dropped:
        assert (lost["t_us"][0], lost["event_index"][0]) == (1_000, 20)


def test_by_default_clusters_stay_at_the_border() -> None:
    assert len(of_kind(tracked(events_of([*still(0, 0, 20), (1_500, 400, 700)]), RctConfig(radius_px=10.0))[0], Kind.LOST)) == 0


def test_the_sensor_must_be_known() -> None:
    with pytest.raises(ConfigError, match=r"^rct\.border_share = 0\.6: needs the sensor's width and height$"):
        RctTracker(RctConfig(border_share=0.6))

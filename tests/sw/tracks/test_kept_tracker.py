# SPDX-License-Identifier: Apache-2.0
"""A tracker behind filters sees what they let stay; the log numbers every event."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.events import Events
from evcot.filters.config import FilterConfig
from evcot.filters.run import apply, filtered
from evcot.scenes.registry import simulate_scene
from evcot.trackers.rct.config import RctConfig
from evcot.trackers.rct.tracker import RctTracker
from evcot.tracks.log import DROPPED, TRACK, Kind, TrackLog
from evcot.tracks.tracking import KeptTracker, Told, log_of

SENSOR = (346, 260)
FILTERS = FilterConfig(activity_us=3_000)
SCENE = simulate_scene("discs", 3, {"duration_us": 150_000, "noise_hz": 5.0}).recording
RCT = RctConfig(visible_events=40, lifetime_us=20_000)


def behind(size: int) -> TrackLog:
    """The scene, in runs of `size` events."""
    tracker = KeptTracker(filtered((), FILTERS, SENSOR).keep, RctTracker(RCT))
    events = SCENE.events
    return log_of("rct", tracker, (events[begin : begin + size] for begin in range(0, len(events), size)))


def test_tracks_are_those_of_the_events_that_stay() -> None:
    kept, keep = apply(SCENE, FILTERS)
    alone, log = log_of("rct", RctTracker(RCT), [kept.events]), behind(len(keep))
    assert 0 < np.count_nonzero(keep) < len(keep)
    assert len(alone.of_kind(Kind.BORN)) >= 4
    assert np.array_equal(log.owner[keep], alone.owner)
    assert (log.owner[~keep] == DROPPED).all()
    for name in TRACK.names or ():
        if name != "event_index":
            assert np.array_equal(log.records[name], alone.records[name])
    place = np.append(np.flatnonzero(keep), len(keep))
    assert np.array_equal(log.records["event_index"], place[alone.records["event_index"]])


@pytest.mark.parametrize("size", [1_000, 20_011])
def test_where_runs_are_cut_changes_nothing(size: int) -> None:
    whole, cut = behind(len(SCENE.events)), behind(size)
    assert np.array_equal(whole.records, cut.records)
    assert np.array_equal(whole.owner, cut.owner)


def test_a_run_of_which_nothing_stays() -> None:
    tracker = KeptTracker(filtered((), FilterConfig(polarity="on"), SENSOR).keep, Silent())
    off = Events(np.arange(5), *(np.zeros(5, np.uint16),) * 2, np.zeros(5, np.uint8))
    records, owner = tracker.feed(off)
    assert (len(records), owner.tolist()) == (0, 5 * [DROPPED])
    assert tracker.finish()["event_index"].tolist() == [5]


class Silent:
    """Tells at the end of an event that follows all."""

    def feed(self, events: Events) -> Told:
        assert not len(events)
        return np.empty(0, TRACK), np.empty(0, np.int16)

    def finish(self) -> NDArray[np.void]:
        return np.zeros(1, TRACK)

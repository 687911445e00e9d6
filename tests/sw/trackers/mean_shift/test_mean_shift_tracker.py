# SPDX-License-Identifier: Apache-2.0
"""Points, packets and clusters; and the tracker on extreme packets and on recorded traffic."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from evcot.events import Events, Recording
from evcot.filters.config import FilterConfig
from evcot.filters.hot_pixels import learn_hot_pixels
from evcot.filters.run import apply
from evcot.metrics import evaluate, load_rule, read_truth
from evcot.recordings.files import read_recording
from evcot.trackers.mean_shift.clusters import cluster, event_points, fuse
from evcot.trackers.mean_shift.config import PRESETS, MeanShiftConfig
from evcot.trackers.mean_shift.tracker import MeanShiftTracker
from evcot.tracks.tracking import track_recording
from shared import SHARED


def test_an_event_is_its_place_its_polarity_and_its_age() -> None:
    x, y, p = np.array([7, 7, 1], np.uint16), np.array([9, 9, 2], np.uint16), np.array([1, 0, 1], np.uint8)
    events = Events(np.array([5_000, 15_000, 25_000]), x, y, p).read_only()
    points, after_us = event_points(events.t_us, events.x, events.y, events.p)
    np.testing.assert_allclose(points, [[7, 7, 1], [9, 9, 2], [2, 0, 2], [2 * np.exp(-2), 2 * np.exp(-1), 2]], rtol=1e-15)
    assert after_us.tolist() == [0, 10_000, 20_000]


@pytest.mark.parametrize(
    ("packet_events", "t_us", "ends"),
    [
        (3, [0, 1, 2, 3, 4, 5, 6], [3, 6]),
        # The second packet counts its time from its own first event.
        (3, [0, 19_999, 20_000, 39_999, 40_000, 40_001, 40_002], [2, 4, 7]),
        (2, [7, 7, 7, 7, 8], [2, 4]),
    ],
)
def test_a_packet_ends_after_its_events_or_its_time(packet_events: int, t_us: list[int], ends: list[int]) -> None:
    tracker = MeanShiftTracker(MeanShiftConfig(packet_events=packet_events))
    assert tracker.frame_ends(np.array(t_us)).tolist() == ends


def test_the_mode_of_the_most_points_absorbs_modes_near_it() -> None:
    """In a chain of modes 4 apart the middle one takes both neighbours, and not theirs."""
    modes = np.array([[0.0, 4, 8, 12, 16], [0, 0, 0, 0, 0], [9, 0, 9, 0, 9], [0, 9, 0, 9, 0]])
    member, n = fuse(np.array([0, 1, 2, 2, 2, 3, 4, 4]), modes, 5.0)
    assert n == 3
    assert member.tolist() == [2, 0, 0, 0, 0, 0, 1, 1]


def test_a_cluster_has_the_middle_sides_and_time_of_its_points() -> None:
    """A twentieth of the points lies beyond each side; clusters with few points are discarded."""
    points = np.zeros((4, 22))
    points[0], points[1] = [*range(10, 30), 200, 202], 20
    found, _, _ = cluster(points, np.arange(22.0), 20.0, 0.0, 3)
    names = ["x", "y", "width", "height", "after_us", "n"]
    assert found[names].tolist() == [(19.5, 20.0, 18.0, 1.0, 9.5, 20)]
    np.testing.assert_allclose(found["radius"], 1.5 * np.std(points[0, :20]) / np.sqrt(2))


def test_extreme_packets() -> None:
    """All events on one pixel, in the sensor's far corner, at one instant; far apart; alone."""
    n = 2_000
    corner = np.full(n, 65_535, np.uint16)
    at_once = Events(np.zeros(n, np.int64), corner, corner, np.ones(n, np.uint8))
    ends = corner * (np.arange(n, dtype=np.uint16) % 2)
    apart = Events(np.arange(n, dtype=np.int64) * 10**12, ends, corner, np.zeros(n, np.uint8))
    for events in (at_once, apart, at_once[:1]):
        _, owner = MeanShiftTracker(PRESETS["discs"]).feed(events)
        assert len(owner) == len(events)


def test_hota_on_the_first_half_of_the_recorded_traffic() -> None:
    """The half on which the preset was tuned."""
    path = SHARED / "traffic_outbound.aedat4"
    if not path.is_file():
        pytest.skip(f"no {path}")
    recording = read_recording(path, to_us=2_000_000)
    filters = FilterConfig(hot_pixels=learn_hot_pixels(recording.events, (346, 260)))
    kept: Recording = apply(recording, filters)[0]
    rule = load_rule("traffic")
    truth = read_truth(SHARED / "traffic_outbound_gt.csv", rule)
    half = truth.instants_us <= recording.events.t_us[-1]
    first = replace(truth, instants_us=truth.instants_us[half], objects=truth.objects[half[truth.objects["frame"]]])
    log = track_recording("mean-shift", MeanShiftTracker(PRESETS["traffic"]), kept)
    assert evaluate(log, first, rule).hota > 0.7

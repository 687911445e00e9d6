# SPDX-License-Identifier: Apache-2.0
"""The clusters of the moment, from records as they come."""

from __future__ import annotations

import numpy as np
import pytest

from evcot.scenes.registry import simulate_scene
from evcot.trackers.rct.presets import PRESETS
from evcot.trackers.rct.tracker import track
from evcot.tracks.log import Kind
from evcot.tracks.timeline import sample
from evcot_cosim.live.visible_clusters import Alive

from .stories import record


def test_a_life() -> None:
    alive = Alive()
    alive.apply(record(Kind.BORN, 100, 0, 7, x=1))
    assert (alive.clusters.states["track_id"].tolist(), alive.clusters.birth_us.tolist()) == ([7], [100])
    alive.apply(
        np.concatenate([record(Kind.MOVED, 110, 1, 7, x=2), record(Kind.BORN, 120, 2, 3), record(Kind.MOVED, 130, 3, 7, x=4)])
    )
    assert alive.clusters.states["track_id"].tolist() == [3, 7]
    assert alive.clusters.states["x"].tolist() == [0, 4]
    assert alive.clusters.birth_us.tolist() == [120, 100]
    alive.apply(record(Kind.MERGED, 140, 4, 3))
    assert alive.clusters.states["track_id"].tolist() == [7]
    alive.apply(np.concatenate([record(Kind.BORN, 150, 5, 8), record(Kind.LOST, 160, 6, 8), record(Kind.LOST, 170, 7, 7)]))
    assert len(alive.clusters.states) == len(alive.clusters.birth_us) == 0
    assert [alive.count[kind] for kind in Kind] == [3, 2, 1, 2]


def test_a_track_that_was_lost_and_is_found_again_is_visible_since_then() -> None:
    alive = Alive()
    alive.apply(record(Kind.BORN, 100, 0, 7))
    alive.apply(record(Kind.LOST, 150, 5, 7))
    assert len(alive.clusters.states) == 0
    alive.apply(record(Kind.MOVED, 200, 9, 7, x=3))
    assert (alive.clusters.states["x"].tolist(), alive.clusters.birth_us.tolist()) == ([3], [200])
    alive.apply(np.concatenate([record(Kind.LOST, 210, 10, 7), record(Kind.MOVED, 220, 11, 7), record(Kind.MOVED, 230, 12, 7)]))
    assert alive.clusters.birth_us.tolist() == [220]
    assert alive.count[Kind.BORN] == 1


@pytest.mark.parametrize("size", [1, 7, 1_000_000])
def test_it_agrees_with_the_whole_log_however_the_records_are_cut(size: int) -> None:
    recording = simulate_scene("discs", 5, {"duration_us": 200_000}).recording
    log = track(recording, PRESETS["plain"])
    alive = Alive()
    for begin in range(0, len(log.records), size):
        part = log.records[begin : begin + size]
        alive.apply(part)
        following = log.records[begin + size : begin + size + 1]
        t_us = int(part["t_us"][-1])
        if len(following) and following["t_us"][0] == t_us:
            continue
        wanted = sample(log, np.array([t_us]))
        wanted = wanted[np.argsort(wanted["track_id"])]
        for name in ("track_id", "x", "y", "radius"):
            assert np.array_equal(alive.clusters.states[name], wanted[name]), name
    assert alive.count[Kind.BORN] == len(log.of_kind(Kind.BORN)) >= 4

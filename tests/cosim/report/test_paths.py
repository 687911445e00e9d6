# SPDX-License-Identifier: Apache-2.0
"""A track that was lost and found again has two lives of one name, each with its own points, and is alive in both."""

from __future__ import annotations

import numpy as np

from evcot.events import Events, Recording
from evcot.tracks.log import Kind, TrackLog
from evcot_cosim.report import Material, Side
from evcot_cosim.report.collect import collect
from evcot_cosim.report.paths import log_paths
from support.logs import log_of

FOUND_AGAIN = log_of(
    [
        (0, Kind.BORN, 4, 1, 0), (10, Kind.MOVED, 4, 2, 0), (15, Kind.BORN, 5, 9, 0), (20, Kind.LOST, 4, 3, 0),
        (50, Kind.MOVED, 4, 7, 0), (60, Kind.MERGED, 5, 8, 0, 4), (70, Kind.MOVED, 4, 8, 0), (80, Kind.LOST, 4, 8, 0),
    ]
)  # fmt: skip


def test_each_life_has_its_own_points() -> None:
    paths = log_paths(FOUND_AGAIN, 100)
    assert paths.names == ("4", "5", "4")
    assert paths.counts.tolist() == [3, 2, 3]
    assert np.split(paths.points["x"], np.cumsum(paths.counts)[:-1])[2].tolist() == [7, 8, 8]
    assert paths.columns("a", 0)["a.other"].values.tolist() == [-1, 2, -1]


def test_of_many_lives_the_longest_stay_and_the_first_point_of_each() -> None:
    paths = log_paths(FOUND_AGAIN, 100, lives_max=2, records_max=0)
    assert paths.names == ("5", "4")
    assert paths.points["t_us"].tolist() == [15, 60, 50, 80]


def test_it_is_alive_in_both() -> None:
    t_us = np.arange(0, 101, 5)
    zeros = np.zeros(len(t_us), np.uint16)
    recording = Recording(Events(t_us, zeros, zeros, zeros.astype(np.uint8)), 16, 16, "by hand")
    log = TrackLog("adaptive", FOUND_AGAIN.records, np.full(len(t_us), -1, np.int16))
    columns = collect(Material(recording, {}, (Side("software", log),), None), 100).columns
    steps = zip(columns["software.alive_t"].values.tolist(), columns["software.alive"].values.tolist(), strict=True)
    assert list(steps) == [(0, 1), (15, 2), (20, 1), (50, 2), (60, 1), (80, 0)]

# SPDX-License-Identifier: Apache-2.0
"""TC over time: the gaps of visible clusters in a short story."""

from __future__ import annotations

import numpy as np

from evcot.tracks.log import TRACK, Kind, TrackLog
from evcot_cosim.report.tc_curve import quiet_peaks


def log_of(owner: list[int], *rows: tuple[int, int, Kind, int]) -> TrackLog:
    """Records of (event index, time, kind, slot)."""
    records = np.zeros(len(rows), TRACK)
    for record, (index, t_us, kind, slot) in zip(records, rows, strict=True):
        record["event_index"], record["t_us"], record["kind"], record["slot"] = index, t_us, kind, slot
    return TrackLog("cot_array", records, np.array(owner, np.int16))


def test_a_cluster_waits_and_is_lost() -> None:
    # Slot 1 gathers from 0, is born at 10, waits until 250, and is lost 400 after that; slot 0 is never visible.
    t_us = np.array([0, 10, 30, 250, 700, 799])
    log = log_of([1, 1, 0, 1, 0, -1], (1, 10, Kind.BORN, 1), (4, 650, Kind.LOST, 1))
    peaks, stretch_us = quiet_peaks(log, t_us)
    assert (peaks.shape, stretch_us) == ((2, 800), 1)
    assert {int(i): int(peaks[1, i]) for i in np.flatnonzero(peaks[1] >= 0)} == {250: 240, 650: 400}
    assert (peaks[0] == -1).all()


def test_a_new_life_in_a_slot_does_not_inherit_a_silence() -> None:
    t_us = np.array([0, 100, 900, 950])
    log = log_of([0, 0, 0, 0], (0, 0, Kind.BORN, 0), (1, 100, Kind.MERGED, 0), (3, 950, Kind.BORN, 0))
    peaks, stretch_us = quiet_peaks(log, t_us)
    assert stretch_us == 2
    assert {int(i): int(peaks[0, i]) for i in np.flatnonzero(peaks[0] >= 0)} == {50: 100}


def test_a_cluster_that_is_found_again_is_visible_from_then_on() -> None:
    t_us = np.array([0, 100, 500, 600, 700, 799])
    log = log_of([0, 0, 0, 0, 0, -1], (0, 0, Kind.BORN, 0), (2, 200, Kind.LOST, 0), (3, 600, Kind.MOVED, 0))
    peaks, stretch_us = quiet_peaks(log, t_us)
    assert stretch_us == 1
    assert {int(i): int(peaks[0, i]) for i in np.flatnonzero(peaks[0] >= 0)} == {100: 100, 200: 100, 700: 100}


def test_no_events() -> None:
    peaks, _ = quiet_peaks(TrackLog.empty("rct"), np.empty(0, np.int64))
    assert (peaks == -1).all()


def test_many_slots_make_longer_stretches() -> None:
    t_us = np.arange(0, 10_000_000, 1_000)
    owner = np.arange(len(t_us)) % 1_000
    assert quiet_peaks(TrackLog("rct", np.empty(0, TRACK), owner.astype(np.int16)), t_us).peaks_us.size <= 100_000

# SPDX-License-Identifier: Apache-2.0
"""Quality without a truth: every figure against what was put into the log."""

from __future__ import annotations

import numpy as np
import pytest

from evcot.events import Events
from evcot.metrics.quality import QualityCounter, isolated, quality_of
from evcot.tracks.log import TRACK, Kind, TrackLog
from evcot.tracks.log_parts import LogParts

SENSOR = (64, 48)
SECOND = 1_000_000


def record(kind: Kind, track_id: int, t_us: int, x: float = 10.0, slot: int = 0, other: int = -1) -> tuple[object, ...]:
    return (t_us, 0, kind, track_id, slot, other, x)


def log_of(records: list[tuple[object, ...]], owner: list[int]) -> TrackLog:
    rows = np.zeros(len(records), TRACK)
    for row, (t_us, index, kind, track_id, slot, other, x) in zip(rows, records, strict=True):
        row["t_us"], row["event_index"], row["kind"], row["track_id"] = t_us, index, kind, track_id
        row["slot"], row["other_id"], row["x"], row["y"] = slot, other, x, 10.0
        row["width"] = row["height"] = 8.0
    return TrackLog("cot_array", rows[np.argsort(rows["t_us"], kind="stable")], np.array(owner, np.int16))


def events_at(times_us: list[int], x: list[int] | None = None) -> Events:
    n = len(times_us)
    columns = np.array(x if x else [10 + i % 2 for i in range(n)], np.uint16)
    return Events(np.array(times_us, np.int64), columns, np.full(n, 10, np.uint16), np.zeros(n, np.uint8))


def test_an_event_is_isolated_without_one_beside_it_within_ten_ms() -> None:
    events = events_at([0, 1_000, 11_500, 12_000, 12_500], [10, 11, 10, 40, 40])
    #  first of all; its neighbour 1 ms later; 10.5 ms after it; nobody near; the same pixel is no neighbour
    assert isolated(events, SENSOR).tolist() == [True, False, True, True, True]


def test_no_events_and_no_tracks_have_no_figures() -> None:
    events = events_at([])
    found = quality_of(TrackLog.empty("cot_array"), events, isolated(events, SENSOR))
    assert (found.tracks, found.short, found.noise_tracks) == (0, 0, 0)
    assert (found.tracks_per_alive, found.owned_fraction, found.isolated_fraction) == (None, None, None)


@pytest.mark.parametrize(("kind", "merged", "lost"), [(Kind.MERGED, 1, 0), (Kind.LOST, 0, 1)], ids=["absorbed", "silent"])
def test_a_short_track_is_told_from_a_lasting_one_and_by_its_end(kind: Kind, merged: int, lost: int) -> None:
    log = log_of(
        [
            record(Kind.BORN, 0, 0), record(Kind.LOST, 0, 5 * SECOND),
            record(Kind.BORN, 1, SECOND, slot=1), record(kind, 1, SECOND + 50_000, slot=1),
        ],
        [0] * 2,
    )  # fmt: skip
    found = quality_of(log, events_at([0, 10 * SECOND]), np.zeros(2, np.bool_))
    assert (found.tracks, found.short, found.short_merged, found.short_lost) == (2, 1, merged, lost)
    assert found.alive_mean == pytest.approx(0.505)
    assert found.tracks_per_alive == pytest.approx(2 / 0.505)
    assert found.short_time_fraction == pytest.approx(0.05 / 5.05)


def test_a_track_that_merges_in_the_moment_of_its_birth_is_none_that_anybody_sees() -> None:
    log = log_of(
        [
            record(Kind.BORN, 0, 0), record(Kind.BORN, 1, SECOND, slot=1), record(Kind.MERGED, 1, SECOND, slot=1),
            record(Kind.LOST, 0, 5 * SECOND),
        ],
        [0] * 2,
    )  # fmt: skip
    found = quality_of(log, events_at([0, 10 * SECOND]), np.zeros(2, np.bool_))
    assert (found.tracks, found.absorbed, found.lives, found.short) == (1, 1, 1, 0)
    assert found.tracks_per_alive == pytest.approx(2)


def test_a_brief_track_that_travels_or_is_still_alive_is_not_short_and_one_that_began_before_not_found_again() -> None:
    end_us = 10 * SECOND
    log = log_of(
        [
            record(Kind.BORN, 0, 0, x=10.0), record(Kind.MOVED, 0, 50_000, x=15.0), record(Kind.LOST, 0, 60_000, x=15.0),
            record(Kind.BORN, 1, end_us - 1_000, slot=1),
        ],
        [0] * 2,
    )  # fmt: skip
    found = quality_of(log, events_at([0, end_us]), np.zeros(2, np.bool_))
    assert (found.tracks, found.short) == (2, 0)
    log = log_of([record(Kind.MOVED, 0, SECOND), record(Kind.LOST, 0, 2 * SECOND)], [0] * 2)
    found = quality_of(log, events_at([0, 10 * SECOND]), np.zeros(2, np.bool_))
    assert (found.tracks, found.found_again) == (1, 0)


@pytest.mark.parametrize("cut", [None, 1, 2, 4])
def test_a_track_that_is_found_again_counts_once_whole_or_in_parts(cut: int | None) -> None:
    times_us = [0, 1 * SECOND, 2 * SECOND, 3 * SECOND, 4 * SECOND, 10 * SECOND]
    log = log_of(
        [
            record(Kind.BORN, 0, 0), record(Kind.LOST, 0, 1 * SECOND), record(Kind.MOVED, 0, 3 * SECOND),
            record(Kind.LOST, 0, 5 * SECOND), record(Kind.BORN, 1, 4 * SECOND, slot=1), record(Kind.MOVED, 0, 9 * SECOND),
        ],
        [-1] * len(times_us),
    )  # fmt: skip
    log.records["event_index"] = np.searchsorted(times_us, log.records["t_us"])
    events, alone = events_at(times_us), np.zeros(len(times_us), np.bool_)
    counter = QualityCounter(0, 10 * SECOND)
    cutter = LogParts(log)
    for part in (slice(0, cut), slice(cut, None)) if cut else (slice(None),):
        last = part.stop is None
        counter.add(cutter.take(len(events[part]), last=last)[0], events[part], alone[part], last=last)
    found = counter.quality()
    assert (found.tracks, found.found_again, found.lives) == (2, 2, 4)
    assert found.alive_mean == pytest.approx(1.0)
    assert found.tracks_per_alive == pytest.approx(2.0)


def test_events_belong_to_a_track_only_while_it_lasts_and_is_visible() -> None:
    times_us = [0, 100_000, 900_000, 1_500_000, 2_000_000, 10 * SECOND]
    log = log_of(
        [
            record(Kind.BORN, 0, 50_000), record(Kind.LOST, 0, SECOND),
            record(Kind.BORN, 1, 2_000_000), record(Kind.LOST, 1, 2_000_001),
        ],
        [0, 0, 0, 0, 0, -1],
    )  # fmt: skip
    found = quality_of(log, events_at(times_us), np.zeros(6, np.bool_))
    assert found.owned_fraction == pytest.approx(2 / 6)  # before its birth, after its loss, and of a short one: no


def test_dropped_and_isolated_events_are_not_asked_for() -> None:
    log = log_of([record(Kind.BORN, 0, 0)], [0, -2, -1, 0, -2])
    alone = np.array([False, False, False, True, True])
    found = quality_of(log, events_at([0, 1, 2, 3, SECOND]), alone)
    assert found.owned_fraction == pytest.approx(1 / 2)
    assert found.isolated_fraction == pytest.approx(2 / 5)
    assert (found.isolated_dropped_fraction, found.isolated_owned_fraction) == (0.5, 0.5)


def test_a_track_of_isolated_events_is_noise() -> None:
    log = log_of(
        [record(Kind.BORN, 0, 0), record(Kind.BORN, 1, 0, slot=1), record(Kind.LOST, 1, 5 * SECOND, slot=1)],
        [0, 1, 1, 1, 0],
    )
    alone = np.array([False, True, True, False, True])
    found = quality_of(log, events_at([0, 1, 2, 3, 10 * SECOND]), alone)
    assert found.noise_tracks == 1
    assert found.noise_time_fraction == pytest.approx(1 / 3)


def test_a_slot_that_is_used_again_owns_for_its_new_track() -> None:
    log = log_of(
        [
            record(Kind.BORN, 0, 0), record(Kind.LOST, 0, SECOND),
            record(Kind.BORN, 1, 3 * SECOND), record(Kind.LOST, 1, 4 * SECOND),
        ],
        [0, 0, 0, 0],
    )  # fmt: skip
    alone = np.array([False, True, True, True])
    found = quality_of(log, events_at([1, 2, 3 * SECOND + 1, 3 * SECOND + 2]), alone)
    assert found.noise_tracks == 1  # the second; of the first's events half are isolated, which is not most

# SPDX-License-Identifier: Apache-2.0
"""Errors of position, velocity and time, on a bouncing ball, whose path is not similar to a shifted copy of itself."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.metrics.motion import Motion, motion
from evcot.metrics.truth import OBJECT
from evcot.tracks.log import TRACK, Kind, TrackLog
from evcot.tracks.timeline import SAMPLE, sample

NEVER_US = 1 << 40  # no state gets old
INSTANTS_US = np.arange(300_000, 1_700_000, 10_000)


def ball(t_us: NDArray[np.int64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    return 100 + 80 * np.sin(t_us * 3e-6), 100 + 60 * np.sin(t_us * 7e-6)


def objects_at(instants_us: NDArray[np.int64], velocity: bool = True) -> NDArray[np.void]:
    objects = np.zeros(len(instants_us), OBJECT)
    objects["x"], objects["y"] = ball(instants_us)
    (x0, y0), (x1, y1) = ball(instants_us - 500), ball(instants_us + 500)
    objects["vx"], objects["vy"] = ((x1 - x0) * 1e3, (y1 - y0) * 1e3) if velocity else (np.nan, np.nan)
    return objects


def track(late_us: int = 0, dx: float = 0.0, faster: float = 1.0) -> TrackLog:
    records = np.zeros(2_000, TRACK)
    records["t_us"] = 1_000 * np.arange(len(records))
    records["kind"] = Kind.MOVED
    records["x"], records["y"] = ball(records["t_us"] - late_us)
    records["x"] += dx + (faster - 1) * records["t_us"] * 1e-6
    return TrackLog("test", records, np.empty(0, np.int16))


def measured(log: TrackLog, objects: NDArray[np.void] | None = None) -> Motion:
    return motion(
        log, NEVER_US, objects_at(INSTANTS_US) if objects is None else objects, outputs_at(log, INSTANTS_US), INSTANTS_US
    )


def outputs_at(log: TrackLog, instants_us: NDArray[np.int64]) -> NDArray[np.void]:
    """The states of track 0, of which there is always one."""
    return sample(log, instants_us) if len(log.records) else np.zeros(len(instants_us), SAMPLE)


def test_a_track_on_its_object_has_no_errors() -> None:
    found = measured(track())
    assert (found.position_error_px_median, found.position_error_px_p90, found.latency_ms) == (0.0, 0.0, 0.0)
    assert found.velocity_error_median == pytest.approx(0, abs=3)  # of a curved way, over 50 ms


def test_a_track_beside_its_object_is_off_in_place_alone() -> None:
    found, objects = measured(track(dx=2.0)), objects_at(INSTANTS_US)
    assert found.position_error_px_median == pytest.approx(2.0)
    assert found.velocity_error_median == pytest.approx(measured(track()).velocity_error_median)
    objects["x"] += np.where(np.arange(len(objects)) % 4 == 0, 8.0, 1.0)
    found = measured(track(), objects)
    assert (found.position_error_px_median, found.position_error_px_p90) == pytest.approx((1.0, 8.0))


@pytest.mark.parametrize("late_ms", [-37, 1, 40, 99])
def test_lateness_is_found_and_has_its_sign(late_ms: int) -> None:
    assert measured(track(late_us=1_000 * late_ms)).latency_ms == late_ms


def test_what_stands_still_or_is_out_of_range_has_no_lateness() -> None:
    assert measured(track(late_us=150_000)).latency_ms is None
    log, objects = track(), objects_at(INSTANTS_US)
    for axis in "xy":
        log.records[axis], objects[axis] = 5.0, 5.5
    assert measured(log, objects).latency_ms is None


def test_a_track_that_is_too_fast_by_so_much() -> None:
    found, usual = measured(track(faster=31.0)), measured(track())
    assert usual.velocity_error_median is not None
    assert found.velocity_error_median == pytest.approx(30.0, abs=usual.velocity_error_median)


def test_the_stated_velocity_is_held_against_the_objects_where_there_is_one() -> None:
    log = track()
    assert measured(log).stated_velocity_error_median is None
    (x0, y0), (x1, y1) = ball(log.records["t_us"] - 500), ball(log.records["t_us"] + 500)
    log.records["vx"], log.records["vy"] = (x1 - x0) * 1e3 + 3.0, (y1 - y0) * 1e3 - 4.0
    assert measured(log).stated_velocity_error_median == pytest.approx(5.0, abs=1e-3)
    log.records["vx"][:1_500] = log.records["vy"][:1_500] = 0.0  # not yet known
    assert measured(log).stated_velocity_error_median == pytest.approx(5.0, abs=1e-3)
    assert measured(log, objects_at(INSTANTS_US, velocity=False)).stated_velocity_error_median is None


def straight(turned_deg: float = 0.0, faster: float = 1.0, lives_us: int = 2_000_000) -> TrackLog:
    """A track along x at 100 px/s with a record every ms, whose stated velocity is off by an angle and a factor."""
    records = np.zeros(lives_us // 1_000 + 1, TRACK)
    records["t_us"] = 1_000 * np.arange(len(records))
    records["kind"] = Kind.MOVED
    records["kind"][0], records["kind"][-1] = Kind.BORN, Kind.LOST
    records["x"] = 100 * records["t_us"] * 1e-6
    angle = np.radians(turned_deg)
    records["vx"], records["vy"] = 100 * faster * np.cos(angle), 100 * faster * np.sin(angle)
    return TrackLog("test", records, np.empty(0, np.int16))


def against_displacement(log: TrackLog, instants_us: NDArray[np.int64]) -> tuple[float | None, float | None, float | None]:
    outputs = sample(log, instants_us)
    found = motion(log, NEVER_US, np.zeros(len(outputs), OBJECT), outputs, instants_us[outputs["sample"]])
    return found.stated_angle_error_deg_median, found.stated_angle_over_45_deg_fraction, found.stated_relative_error_median


def test_stated_velocity_is_compared_with_displacement_without_velocities_in_the_truth() -> None:
    assert against_displacement(straight(), INSTANTS_US) == pytest.approx((0, 0, 0), abs=1e-9)
    assert against_displacement(straight(turned_deg=-30), INSTANTS_US) == pytest.approx((30, 0, 2 * np.sin(np.radians(15))))
    assert against_displacement(straight(turned_deg=46, faster=2), INSTANTS_US)[:2] == pytest.approx((46, 1))
    assert against_displacement(straight(faster=1.25), INSTANTS_US) == pytest.approx((0, 0, 0.25), abs=1e-9)


def test_slow_or_short_tracks_and_unknown_velocities_are_not_compared_with_displacement() -> None:
    slow, unknown = straight(), straight()
    slow.records["x"] *= 0.149
    unknown.records["vx"] = 0
    for log in (slow, unknown):
        assert against_displacement(log, INSTANTS_US) == (None, None, None)
    instants_us = np.arange(150_000, 350_000, 10_000)
    assert against_displacement(straight(lives_us=499_000), instants_us) == (None, None, None)
    assert against_displacement(straight(lives_us=500_000), instants_us) == pytest.approx((0, 0, 0), abs=1e-9)


def test_a_life_ends_where_its_id_is_born_again() -> None:
    """Two lives of 0.4 s under one id: neither is long enough, though the id is there for 0.9 s."""
    first, second = straight(lives_us=400_000).records, straight(lives_us=400_000).records
    second["t_us"] += 500_000
    log = TrackLog("test", np.concatenate((first, second)), np.empty(0, np.int16))
    assert against_displacement(log, np.arange(0, 900_000, 10_000)) == (None, None, None)


def test_without_velocities_or_pairs_there_are_no_figures() -> None:
    assert measured(track(), objects_at(INSTANTS_US, velocity=False)).velocity_error_median is None
    nobody = motion(track(), NEVER_US, objects_at(INSTANTS_US[:0]), np.empty(0, SAMPLE), INSTANTS_US[:0])
    assert nobody == Motion(None, None, None, None, None, None, None, None)


def test_of_equal_shifts_the_smallest_counts() -> None:
    """States every 40 ms, each 40 ms early: any shift from -40 ms up to the next state fits."""
    log = track()
    records = log.records[::40].copy()
    records["x"], records["y"] = ball(records["t_us"] + 40_000)
    instants_us = INSTANTS_US[INSTANTS_US % 40_000 == 0]
    log = TrackLog("test", records, log.owner)
    found = motion(log, NEVER_US, objects_at(instants_us), outputs_at(log, instants_us), instants_us)
    assert found.latency_ms == -1.0


def test_a_shift_at_which_most_tracks_are_not_there_says_nothing() -> None:
    """A track of 40 ms, 3 px beside its object, whose last state happens to lie where the object was first."""
    instants_us = np.arange(0, 50_000, 10_000)
    objects = np.zeros(len(instants_us), OBJECT)
    objects["x"] = instants_us * 1e-3
    records = np.zeros(42, TRACK)
    records["t_us"] = 1_000 * np.arange(len(records))
    records["kind"] = Kind.MOVED
    records["kind"][-1] = Kind.LOST
    records["x"], records["y"] = records["t_us"] * 1e-3, 3.0
    records["x"][40], records["y"][40] = 0.0, 0.0
    found = motion(TrackLog("test", records, np.empty(0, np.int16)), NEVER_US, objects, np.zeros(5, SAMPLE), instants_us)
    assert found.latency_ms == 0.0

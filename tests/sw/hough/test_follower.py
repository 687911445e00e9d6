# SPDX-License-Identifier: Apache-2.0
"""Lines are followed through the whole turn: exact lines as events, with errors and ids against the truth."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import evcot
from evcot.hough.contract import HoughConfig
from evcot.hough.follower import LineFollower

WIDTH, HEIGHT = 200, 160
TURN_DEG_S, PIVOT = 120.0, (20.0, -10.0)  # from the middle of the sensor


def turning_line(seed: int, turns: float, first_deg: float = 0.0, pivot: tuple[float, float] = PIVOT) -> evcot.Events:
    """A line of 100 px that turns about its middle: 300 events per degree, more where it is faster."""
    rng = np.random.default_rng(seed)
    count = int(300 * 360 * turns)
    t_us = np.sort(rng.integers(0, int(turns * 360 / TURN_DEG_S * 1e6), count))
    normal = np.radians(first_deg + TURN_DEG_S * t_us * 1e-6)
    along, off = 50 * np.sqrt(rng.random(count)) * rng.choice([-1, 1], count), rng.uniform(-1, 1, count)
    x = (WIDTH - 1) / 2 + pivot[0] + off * np.cos(normal) - along * np.sin(normal)
    y = (HEIGHT - 1) / 2 + pivot[1] + off * np.sin(normal) + along * np.cos(normal)
    return evcot.Events(t_us, np.rint(x).astype(np.uint16), np.rint(y).astype(np.uint16), np.zeros(count, np.uint8))


def errors(
    lines: NDArray[np.void], first_deg: float = 0.0, pivot: tuple[float, float] = PIVOT
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Of each entry: half turns between its angle and the truth's, error in degrees, error in pixels."""
    angle_deg = first_deg + TURN_DEG_S * lines["t_us"] * 1e-6
    half_turns = np.round((lines["angle_deg"] - angle_deg) / 180)
    normal = np.radians(angle_deg)
    rho_px = (pivot[0] * np.cos(normal) + pivot[1] * np.sin(normal)) * np.where(half_turns % 2, -1, 1)
    return half_turns, abs(lines["angle_deg"] - angle_deg - 180 * half_turns), abs(lines["rho_px"] - rho_px)


def recording_of(events: evcot.Events) -> evcot.Recording:
    return evcot.Recording(events, WIDTH, HEIGHT)


def test_a_line_keeps_its_id_through_two_turns() -> None:
    lines = evcot.lines(recording_of(turning_line(1, 2.0)))
    half_turns, error_deg, error_px = errors(lines)
    assert set(lines["line_id"]) == {1}
    assert len(set(half_turns)) == 1, "the angle is continuous"
    assert np.ptp(lines["angle_deg"]) > 700
    assert np.median(error_deg) < 0.3
    assert error_deg.max() < 4
    assert np.median(error_px) < 0.3
    settled = lines["t_us"] > 500_000
    assert abs(np.median(lines["turn_deg_s"][settled]) - TURN_DEG_S) < 0.05 * TURN_DEG_S


def test_a_line_that_turns_back_keeps_its_id() -> None:
    forth = turning_line(2, 0.6, -60.0)
    last_us = int(forth.t_us[-1])
    back = evcot.Events(last_us - forth.t_us[::-1] + last_us, forth.x[::-1], forth.y[::-1], forth.p)
    lines = evcot.lines(recording_of(evcot.Events.joined([forth, back])))
    assert set(lines["line_id"]) == {1}
    assert abs(lines["angle_deg"][-1] - lines["angle_deg"][0]) < 3


def test_two_lines_have_an_id_each() -> None:
    one, other = turning_line(3, 1.0, 0.0, (-45.0, 0.0)), turning_line(4, 1.0, 70.0, (45.0, 10.0))
    both = evcot.Events.joined([one, other])
    order = np.argsort(both.t_us, kind="stable")
    events = evcot.Events(both.t_us[order], both.x[order], both.y[order], both.p[order])
    lines = evcot.lines(recording_of(events))
    first, second = (errors(lines, *truth) for truth in ((0.0, (-45.0, 0.0)), (70.0, (45.0, 10.0))))
    is_first = first[1] + first[2] < second[1] + second[2]
    assert len(set(lines["line_id"][is_first])) == len(set(lines["line_id"][~is_first])) == 1
    assert np.median(np.where(is_first, first[1], second[1])) < 0.5


def test_a_line_ends_after_a_tenth_of_a_second_without_a_spike() -> None:
    events = turning_line(5, 0.5)
    for gap_us, ids in ((99_000, {1}), (103_000, {1, 2})):
        moved = events.t_us + np.where(events.t_us > 700_000, gap_us, 0)
        # The line stands still meanwhile.
        lines = evcot.lines(recording_of(evcot.Events(moved, events.x, events.y, events.p)))
        assert set(lines["line_id"]) == ids, gap_us


def test_the_split_into_blocks_does_not_matter() -> None:
    events = turning_line(6, 0.3)
    whole = evcot.lines(recording_of(events))
    follower = LineFollower(HoughConfig(WIDTH, HEIGHT))
    parts = [follower.feed(events[begin : begin + 777]) for begin in range(0, len(events), 777)]
    assert np.array_equal(np.concatenate(parts), whole)


def test_noise_has_no_lines() -> None:
    rng = np.random.default_rng(7)
    count = 200_000
    x, y = rng.integers(0, WIDTH, count).astype(np.uint16), rng.integers(0, HEIGHT, count).astype(np.uint16)
    events = evcot.Events(np.arange(count, dtype=np.int64), x, y, np.zeros(count, np.uint8))
    assert len(evcot.lines(recording_of(events))) == 0


def test_a_file_is_read_block_by_block(tmp_path: Path) -> None:
    recording = recording_of(turning_line(8, 0.2))
    evcot.write(recording, tmp_path / "bar.npz")
    assert np.array_equal(evcot.lines(tmp_path / "bar.npz"), evcot.lines(recording))


def test_a_configuration_for_another_sensor_is_refused() -> None:
    with pytest.raises(evcot.ConfigError, match=r"^hough sensor 346x260: must be the recording's, 200x160$"):
        evcot.lines(recording_of(turning_line(9, 0.01)), evcot.HoughConfig())


def test_a_sensor_that_is_too_large_is_refused() -> None:
    recording = evcot.Recording(turning_line(10, 0.01), 4096, 160)
    with pytest.raises(evcot.ConfigError, match=r"^hough\.width = 4096: must be from 1 to 2048"):
        evcot.lines(recording)

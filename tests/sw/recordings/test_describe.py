# SPDX-License-Identifier: Apache-2.0
"""The description of a recording agrees with a direct count."""

from __future__ import annotations

import json
from collections import defaultdict
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.errors import RecordingError
from evcot.events import Events
from evcot.recordings.describe import BusyPixel, Description, describe
from evcot.recordings.files import open_recording, write_events
from evcot.recordings.formats import numpy_files

SENSOR = (20, 10)


def make_events(n: int, seed: int = 1, step_us: int = 400) -> Events:
    random = np.random.default_rng(seed)
    t_us = 7_000_000 + np.cumsum(random.integers(0, step_us, n))
    x = random.integers(3, 20, n).astype(np.uint16)
    return Events(t_us, x, random.integers(0, 10, n).astype(np.uint16), random.integers(0, 2, n).astype(np.uint8))


def described(folder: Path, events: Events, sensor: tuple[int, int] = SENSOR, **window: int) -> Description:
    write_events(folder / "events.npz", sensor, [events], force=True)
    with open_recording(folder / "events.npz") as file:
        return describe(file, **window)


def test_every_figure_is_what_counting_gives(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(numpy_files, "BLOCK_EVENTS", 333)  # blocks, windows and pixels do not end together
    events = make_events(5000)
    found = described(tmp_path, events)
    rows = list(zip(*(getattr(events, field).tolist() for field in ("t_us", "x", "y", "p")), strict=True))

    windows: dict[int, int] = defaultdict(int)
    pixels: dict[tuple[int, int], list[int]] = defaultdict(list)
    for t_us, x, y, _ in rows:
        windows[(t_us - rows[0][0]) // 10_000] += 1
        pixels[x, y].append(t_us)
    duration_us = rows[-1][0] - rows[0][0]
    assert (found.format, found.width, found.height, found.assumes_sensor) == ("NumPy npz", 20, 10, False)
    assert (found.events, found.first_us, found.duration_us) == (5000, rows[0][0], duration_us)
    assert found.mean_rate == pytest.approx(5000 / duration_us * 1e6)
    assert found.peak_rate == pytest.approx(max(windows.values()) / 0.01)
    assert found.on_share == pytest.approx(sum(p for *_, p in rows) / 5000)
    assert found.left_out == {}

    assert found.pixels is not None
    assert found.pixels.silent == pytest.approx(1 - len(pixels) / 200)
    counts = sorted(((-len(times), y, x) for (x, y), times in pixels.items()))
    assert [each.share for each in found.pixels.busiest] == [-count / 5000 for count, *_ in counts[:5]]
    intervals = np.concatenate([np.diff(times) for times in pixels.values()])
    assert found.pixels.median_interval_us == pytest.approx(np.median(intervals), rel=0.07)


@pytest.mark.parametrize("interval_us", [0, 1, 15, 16, 17, 999, 123_456, 10**12, 2**61])
def test_the_interval_of_a_pixel_is_right_to_seven_percent(tmp_path: Path, interval_us: int) -> None:
    address = np.array([1, 1], np.uint16)
    events = Events(np.array([0, interval_us]), address, address, address.astype(np.uint8))
    pixels = described(tmp_path, events).pixels
    assert pixels is not None
    assert pixels.median_interval_us == pytest.approx(interval_us, rel=0.07)
    assert interval_us > 15 or pixels.median_interval_us == interval_us


def test_a_hot_pixel_leads_the_busiest(tmp_path: Path) -> None:
    events = make_events(1000)
    hot = np.arange(1000) % 4 == 0
    x, y = np.where(hot, 1, events.x).astype(np.uint16), np.where(hot, 9, events.y).astype(np.uint16)
    pixels = described(tmp_path, Events(events.t_us, x, y, events.p)).pixels
    assert pixels is not None
    assert pixels.busiest[0] == BusyPixel(1, 9, 0.25)
    assert pixels.busiest[1].share < 0.03


def test_a_window_is_described_as_a_recording_of_its_own(tmp_path: Path) -> None:
    events = make_events(2000)
    begin, end = (int(each) for each in np.searchsorted(events.t_us, events.t_us[0] + np.array([100_000, 250_000])))
    window = described(tmp_path, events, from_us=100_000, to_us=250_000)
    assert window == described(tmp_path, events[begin:end])
    with pytest.raises(RecordingError, match=r"holds no events from 9 s$"):
        described(tmp_path, events, from_us=9_000_000)


def test_what_cannot_be_said_is_none(tmp_path: Path) -> None:
    one = described(tmp_path, make_events(1))
    assert (one.mean_rate, one.peak_rate, one.duration_us) == (None, None, 0)
    assert one.pixels is not None
    assert one.pixels.median_interval_us is None
    assert [each.share for each in one.pixels.busiest] == [1.0]
    brief = described(tmp_path, make_events(10, step_us=100))
    assert brief.mean_rate is not None
    assert brief.peak_rate is None


def test_bursts_of_one_time_are_told_from_a_stream(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(numpy_files, "BLOCK_EVENTS", 333)  # blocks end within bursts
    events = make_events(2000)
    burst = np.arange(2000) // 100

    def at(t_us: NDArray[np.int64]) -> float | None:
        return described(tmp_path, Events(t_us, events.x, events.y, events.p)).burst_us

    assert at(burst * 20_000) == 20_000
    assert at(burst * 999) is None  # the times of a driver, not of frames
    assert at(np.arange(2000) // 7 * 20_000) is None  # a slow stream
    assert at(events.t_us) is None


def test_it_goes_through_json_and_tells_its_progress(tmp_path: Path) -> None:
    event = (np.array([value], dtype) for value, dtype in ((5, "i8"), (2, "u2"), (2, "u2"), (1, "u1")))
    write_events(tmp_path / "events.npz", (4, 3), [Events(*event)])
    heard: list[tuple[int, int]] = []
    with open_recording(tmp_path / "events.npz") as file:
        found = describe(file, progress=lambda events, after_us: heard.append((events, after_us)))
    assert heard == [(1, 0)]
    assert json.loads(json.dumps(found.to_dict())) == {
        "format": "NumPy npz", "width": 4, "height": 3, "assumes_sensor": False,
        "events": 1, "first_us": 5, "duration_us": 0, "mean_rate": None, "peak_rate": None, "on_share": 1.0, "burst_us": None,
        "pixels": {"silent": 11 / 12, "median_interval_us": None, "busiest": [{"x": 2, "y": 2, "share": 1.0}]},
        "left_out": {}, "remarks": [], "details": {"times in": "microseconds"},
    }  # fmt: skip


def test_times_at_the_ends_of_the_range_or_a_sensor_beyond_belief_do_no_harm(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("-9223372036854775807,1,1,1\n9223372036854775807,1,1,1\n")
    with open_recording(path) as file:
        assert describe(file).duration_us == 2**64 - 2
    assert described(tmp_path, make_events(10), (65536, 65536)).pixels is None


@pytest.mark.parametrize(
    ("each", "step_us", "burst_us"), [(8, 1_000, 1_000), (7, 1_000, None), (8, 999, None), (100, 2_500, 2_500), (8, 0, None)]
)
def test_bursts_have_eight_events_or_more_and_are_a_millisecond_apart(
    tmp_path: Path, each: int, step_us: int, burst_us: int | None
) -> None:
    t_us = np.repeat(np.arange(5) * step_us, each)
    none = np.zeros(len(t_us), np.uint16)
    found = described(tmp_path, Events(t_us, none, none, none.astype(np.uint8)))
    assert (found.burst_us, found.duration_us) == (burst_us, 4 * step_us)


@pytest.mark.parametrize(("last_us", "peak_rate"), [(9_999, None), (10_000, 300.0), (19_999, 300.0), (25_000, 300.0)])
def test_the_busiest_window_of_10_ms_needs_a_recording_of_one(tmp_path: Path, last_us: int, peak_rate: float | None) -> None:
    t_us = np.array([0, 5, 9_998, last_us])
    one = np.ones(4, np.uint16)
    found = described(tmp_path, Events(t_us, one, one, one.astype(np.uint8)))
    assert found.peak_rate == (pytest.approx(peak_rate) if peak_rate else None)
    assert found.mean_rate == pytest.approx(4e6 / last_us)
    assert found.on_share == 1.0


@pytest.mark.parametrize(("height", "told"), [(2, True), (3, False)])
def test_pixels_of_the_largest_sensors_are_not_counted(
    tmp_path: Path, height: int, told: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("evcot.recordings.describe.MOST_PIXELS", 20)
    assert (described(tmp_path, _in_rows(2), (10, height)).pixels is not None) == told


def test_five_pixels_are_named_and_equally_busy_ones_by_row(tmp_path: Path) -> None:
    pixels = described(tmp_path, _in_rows(2), (10, 2)).pixels
    assert pixels is not None
    assert [each.share for each in pixels.busiest] == [1 / 20] * 5
    places = [(each.y, each.x) for each in pixels.busiest]
    assert places == sorted(set(places))
    assert (pixels.silent, pixels.median_interval_us) == (0.0, None)


def _in_rows(rows: int) -> Events:
    """An event of each pixel of rows of ten."""
    at = np.arange(10 * rows)
    return Events(at.astype(np.int64), (at % 10).astype(np.uint16), (at // 10).astype(np.uint16), (at % 2).astype(np.uint8))

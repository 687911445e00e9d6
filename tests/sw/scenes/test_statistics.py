# SPDX-License-Identifier: Apache-2.0
"""Statistics of events made by hand, and of the highway against a real one; snapshots of recordings side by side."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from evcot.events import Events, Recording
from evcot.recordings.files import read_recording, write_recording
from evcot.scenes import simulate_scene
from evcot.scenes.snapshot import main as draw_snapshots
from evcot.scenes.snapshot import snapshot
from evcot.scenes.statistics import main, statistics, table
from shared import SHARED

REAL = SHARED / "traffic_outbound.aedat4"


def recording(rows: list[tuple[int, int, int, int]], width: int = 4, height: int = 3) -> Recording:
    t_us, x, y, p = np.array(rows, np.int64).T
    events = Events(t_us, x.astype(np.uint16), y.astype(np.uint16), p.astype(np.uint8))
    return Recording(events, width, height)


def test_rates_intervals_and_polarities_are_counted_per_pixel() -> None:
    one = statistics(recording([(0, 0, 0, 1), (100, 1, 0, 1), (300, 0, 0, 0), (700, 0, 0, 1), (1_000_000, 1, 0, 1)]))
    assert one.events_per_s == 5
    assert one.on_share == 0.8
    assert sorted(one.pixel_hz.tolist()) == [0] * 10 + [2, 3]
    assert sorted(one.intervals_us.tolist()) == [300, 400, 999_900]
    assert one.silent_share == pytest.approx(10 / 12)
    assert not len(one.hot)


def test_hot_pixels_are_named_and_left_out() -> None:
    rows = [(1_000 * i, 2, 1, 0) for i in range(1_001)] + [(500_000, 0, 0, 1), (600_000, 0, 0, 1)]
    one = statistics(recording(sorted(rows), 200, 100))
    assert one.hot.tolist() == [[2, 1, 1_001]]
    assert one.intervals_us.tolist() == [100_000]
    assert len(one.pixel_hz) == 200 * 100 - 1


def test_recordings_without_events_or_duration_have_no_rates() -> None:
    for rows in ([(5, 0, 0, 1)], [(5, 0, 0, 1), (5, 1, 0, 1)]):
        assert statistics(recording(rows)).events_per_s == 0
    assert len(table(["a"], [statistics(recording([(5, 0, 0, 1)]))])) > 10


def test_the_table_of_files_is_printed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "small.npz"
    write_recording(recording([(0, 0, 0, 1), (500_000, 0, 0, 0)]), path)
    assert main([str(path), str(path)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].split() == ["small", "small"]
    assert lines[1].split() == ["events/s", "4", "4"]
    assert main([str(tmp_path / "none.npz")]) == 2
    assert capsys.readouterr().err.startswith("statistics: ")
    assert main([]) == 2


@pytest.mark.skipif(not REAL.exists(), reason="the real recording of a highway is not here")
def test_the_highway_is_of_the_real_ones_order() -> None:
    """Rates within a factor of 2, intervals within 5, as many ON as OFF events, one hot pixel of the same rate."""
    real, ours = statistics(read_recording(REAL)), statistics(simulate_scene("highway", 1).recording)
    assert 0.5 < ours.events_per_s / real.events_per_s < 2
    assert abs(ours.on_share - real.on_share) < 0.08
    assert [row[2] for row in ours.hot.tolist()] == pytest.approx([row[2] for row in real.hot.tolist()], rel=0.01)
    for part in (0.5, 0.75, 0.9, 0.99):
        assert 0.5 <= np.quantile(ours.pixel_hz, part) / np.quantile(real.pixel_hz, part) <= 2
    for part in (0.1, 0.25, 0.5, 0.75, 0.9):
        assert 0.2 < np.quantile(ours.intervals_us, part) / np.quantile(real.intervals_us, part) < 5


RED, BLUE, WHITE = (200, 60, 0), (0, 90, 180), (255, 255, 255)


def six_pixels() -> Recording:
    rows = np.array([(0, 1, 1, 1), (5_000, 2, 1, 0), (6_000, 1, 1, 0), (7_000, 3, 2, 0), (7_000, 3, 2, 1), (90_000, 0, 0, 1)])
    t_us, x, y, p = rows.T
    return Recording(Events(t_us, x.astype(np.uint16), y.astype(np.uint16), p.astype(np.uint8)), 6, 4)


def test_the_last_event_of_a_pixel_colours_it() -> None:
    picture = snapshot(six_pixels())
    assert picture.shape == (4, 6, 3)
    found = {(x, y): tuple(picture[y, x].tolist()) for y in range(4) for x in range(6)}
    coloured = {place: colour for place, colour in found.items() if colour != WHITE}
    assert coloured == {(1, 1): BLUE, (2, 1): BLUE, (3, 2): RED, (0, 0): RED}


def test_four_recordings_stand_in_two_rows(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, picture = tmp_path / "r.npz", tmp_path / "r.png"
    write_recording(six_pixels(), path)
    assert draw_snapshots([*[str(path)] * 4, "-o", str(picture), "--at", "0"]) == 0
    with Image.open(picture) as image:
        assert image.size == (3 * 6 + 2 * 4, 2 * 4 + 4)
        pixels = image.convert("RGB")
        assert pixels.getpixel((3, 2)) == pixels.getpixel((10 + 3, 8 + 2 - 8)) == RED
        assert pixels.getpixel((0, 0)) == WHITE
    assert draw_snapshots([str(tmp_path / "none.npz"), "-o", str(picture)]) == 2
    assert capsys.readouterr().err.startswith("snapshot: ")
    assert draw_snapshots([str(path), "-o", str(tmp_path / "no" / "r.png"), "--at", "0"]) == 2

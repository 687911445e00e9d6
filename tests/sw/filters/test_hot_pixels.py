# SPDX-License-Identifier: Apache-2.0
"""Hot pixels are detected, merely busy pixels are not, and the file of hot pixels is validated."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from evcot.errors import ConfigError, OutputError
from evcot.events import Events
from evcot.filters.hot_pixels import OVER_MEDIAN, SLICE_US, learn_hot_pixels, load_hot_pixels, save_hot_pixels
from evcot.recordings.files import read_recording
from evcot.scenes.boxes import BoxExperiment, simulate
from shared import SHARED
from support.refusals import refused

SENSOR = (64, 48)
DURATION_US = 10 * SLICE_US


def events_at(*sources: tuple[int, int, int], seed: int = 1, from_us: int = 0, to_us: int = DURATION_US) -> Events:
    """(x, y, count) at random times."""
    random = np.random.default_rng(seed)
    t_us = np.concatenate([random.integers(from_us, to_us, count) for _, _, count in sources])
    x, y = (np.concatenate([np.full(source[2], source[axis]) for source in sources]) for axis in (0, 1))
    order = np.argsort(t_us, kind="stable")
    return Events(t_us[order], x[order].astype(np.uint16), y[order].astype(np.uint16), np.ones(len(t_us), np.uint8))


def background(count: int = 4, but: tuple[int, int, int, int] = (0, 0, -1, -1)) -> list[tuple[int, int, int]]:
    """`count` events on every pixel but those from (x0, y0) to (x1, y1)."""
    x0, y0, x1, y1 = but
    return [(x, y, count) for x in range(64) for y in range(48) if not (x0 <= x <= x1 and y0 <= y <= y1)]


class TestLearning:
    def test_a_pixel_that_fires_all_the_time_is_hot_and_the_hottest_comes_first(self) -> None:
        assert learn_hot_pixels(events_at(*background(), (9, 7, 200), (40, 30, 300)), SENSOR) == ((40, 30), (9, 7))

    @pytest.mark.parametrize("place", [(0, 0), (63, 0), (0, 47), (63, 47), (63, 20)])
    def test_also_on_the_border_and_two_side_by_side(self, place: tuple[int, int]) -> None:
        assert learn_hot_pixels(events_at(*background(), (*place, 200)), SENSOR) == (place,)
        assert learn_hot_pixels(events_at(*background(), (9, 7, 200), (10, 7, 201)), SENSOR) == ((10, 7), (9, 7))

    def test_it_must_be_much_busier_than_others(self) -> None:
        assert learn_hot_pixels(events_at(*background(4), (9, 7, 75)), SENSOR) == ()  # 79 of the needed 80
        assert learn_hot_pixels(events_at(*background(4), (9, 7, 76)), SENSOR) == ((9, 7),)

    def test_nothing_is_hot_where_little_happens(self) -> None:
        assert learn_hot_pixels(events_at((1, 1, 1), (20, 20, 1), (9, 7, OVER_MEDIAN - 1)), SENSOR) == ()
        assert learn_hot_pixels(events_at((1, 1, 1), (20, 20, 1), (9, 7, OVER_MEDIAN)), SENSOR) == ((9, 7),)

    def test_a_busy_road_is_not_hot(self) -> None:
        """An outline one pixel wide, and a strip with one pixel on it four times as busy as the rest."""
        outline = [(x, y, 300) for x in range(5, 60) for y in range(5, 20) if x in (5, 59) or y in (5, 19)]
        strip = [(x, y, 300) for x in range(64) for y in range(30, 34)]
        assert learn_hot_pixels(events_at(*background(2), *outline, *strip, (9, 32, 900)), SENSOR) == ()
        assert learn_hot_pixels(events_at(*background(2), *outline, *strip, (9, 32, 1500)), SENSOR) == ((9, 32),)

    def test_a_glint_is_not_hot(self) -> None:
        calm = events_at(*background(6, but=(9, 7, 9, 7)))
        for slices, found in ((4, ()), (5, ((9, 7),))):
            glint = events_at((9, 7, 400), to_us=slices * SLICE_US)
            together = Events.joined([calm, glint])
            order = np.argsort(together.t_us, kind="stable")
            assert learn_hot_pixels(Events(*(getattr(together, f)[order] for f in ("t_us", "x", "y", "p"))), SENSOR) == found

    def test_silence_is_no_time(self) -> None:
        """Two busy seconds with a minute of nothing between."""
        early = events_at(*background(), (9, 7, 200))
        late = events_at(*background(), (9, 7, 200), from_us=60_000_000, to_us=60_000_000 + DURATION_US)
        assert learn_hot_pixels([early, late], SENSOR) == ((9, 7),)

    def test_in_blocks_as_in_one_piece(self) -> None:
        events = events_at(*background(), (9, 7, 200), (40, 30, 300))
        blocks = [events[begin : begin + 977] for begin in range(0, len(events), 977)]
        assert learn_hot_pixels([Events.empty(), *blocks], SENSOR) == learn_hot_pixels(events, SENSOR) != ()

    def test_of_nothing_nothing_is_hot_and_a_sensor_of_gigapixels_is_a_mistake(self) -> None:
        assert learn_hot_pixels(Events.empty(), SENSOR) == ()
        with pytest.raises(ConfigError, match="sensor 65536x65536: filters remember at most"):
            learn_hot_pixels(Events.empty(), (65536, 65536))

    @pytest.mark.parametrize("noise_hz_per_px", [0.0, 0.1, 5.0])
    def test_a_clean_scene_has_none(self, noise_hz_per_px: float) -> None:
        recording = simulate(BoxExperiment(noise_hz_per_px=noise_hz_per_px, duration_us=1_000_000)).recording
        assert learn_hot_pixels(recording.events, (recording.width, recording.height)) == ()

    @pytest.mark.parametrize(
        ("name", "wanted"),
        [("traffic_outbound.aedat4", ((192, 209),)), ("hand_dvs128.aedat4", ()), ("pendulum_dvs128.aedat", ())],
    )
    def test_real_recordings(self, name: str, wanted: tuple[tuple[int, int], ...]) -> None:
        if not (SHARED / name).is_file():
            pytest.skip(f"no {SHARED / name}")
        recording = read_recording(SHARED / name)
        assert learn_hot_pixels(recording.events, (recording.width, recording.height)) == wanted


class TestFile:
    def test_what_is_saved_or_written_by_hand_is_loaded(self, tmp_path: Path) -> None:
        path = tmp_path / "hot.txt"
        save_hot_pixels(path, [(192, 209), (3, 4)], (346, 260))
        assert path.read_text() == "# hot pixels of a 346x260 sensor\n192 209\n3 4\n"
        assert load_hot_pixels(path) == load_hot_pixels(path, (346, 260)) == ((192, 209), (3, 4))
        with pytest.raises(ConfigError, match=r"line 1: is for a 346x260 sensor: must be for 128x128$"):
            load_hot_pixels(path, (128, 128))
        path.write_text("# mine\n\n 5\t6 # blinks\n5 6\n65535 0\n")
        assert load_hot_pixels(path) == ((5, 6), (65535, 0))

    @pytest.mark.parametrize(
        ("text", "message"),
        [
            ("1 2\n3\n", "line 2: '3': must be two integers, x and y"),
            ("1 -2\n", "line 1: '1 -2': must be two integers, x and y"),
            ("1 2 3\n", "line 1: '1 2 3': must be two integers, x and y"),
            ("1 123456\n", "line 1: '1 123456': must be two integers, x and y"),
            ("1 65536\n", "line 1: pixel (1, 65536): must lie on the 65536x65536 sensor"),
            ("# hot pixels of a 64x48 sensor\n64 0\n", "line 2: pixel (64, 0): must lie on the 64x48 sensor"),
            ("# hot pixels of a 64x48 sensor\n0 48\n", "line 2: pixel (0, 48): must lie on the 64x48 sensor"),
        ],
    )
    def test_a_line_that_is_no_pixel_is_refused(self, tmp_path: Path, text: str, message: str) -> None:
        path = tmp_path / "hot.txt"
        path.write_text(text)
        with refused(ConfigError, f"{path}: {message}"):
            load_hot_pixels(path)

    def test_files_that_cannot_be_used(self, tmp_path: Path) -> None:
        with pytest.raises(ConfigError, match=r"absent\.txt: cannot be read: No such file or directory$"):
            load_hot_pixels(tmp_path / "absent.txt")
        with pytest.raises(ConfigError, match=r": is no file$"):
            load_hot_pixels(tmp_path)
        (tmp_path / "binary").write_bytes(b"1 2\n\xff\n")
        with pytest.raises(ConfigError, match=r"binary: is not text: byte 4 is 0xff$"):
            load_hot_pixels(tmp_path / "binary")
        with pytest.raises(OutputError, match=r"cannot be written"):
            save_hot_pixels(tmp_path / "absent" / "hot.txt", [], SENSOR)

# SPDX-License-Identifier: Apache-2.0
"""MOTChallenge text: what it means, and that it is written as it was read."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from evcot.errors import ConfigError, TrackLogError
from evcot.tracks.formats.base import FrameClock
from evcot.tracks.formats.registry import read_boxes, write_boxes

CLOCK = FrameClock(40_000, 1_000_000)
RESULT = "1,7,1,1,10,20,0.9,-1,-1,-1\n3,7,2.5,1.25,10.123456,20,0.875,-1,-1,-1\n3,12,-3,0.1,4,5,1,-1,-1,-1\n"
TRUTH = "1,1,912,484,97,109,0,7,1\n2,1,912,484,97.5,109,1,2,0.86014\n"


def written(folder: Path, text: str) -> Path:
    path = folder / "boxes.txt"
    path.write_text(text)
    return path


def test_frames_and_pixels_count_from_1(tmp_path: Path) -> None:
    """The box at (1, 1) begins where the first pixel does: at -0.5."""
    boxes = read_boxes(written(tmp_path, RESULT), CLOCK)
    assert boxes.instants_us.tolist() == [1_000_000, 1_040_000, 1_080_000]  # frame 2, without a box, is one, too
    assert boxes.rows["instant"].tolist() == [0, 2, 2]
    assert boxes.rows["id"].tolist() == [7, 7, 12]
    assert boxes.rows[["left", "top"]].tolist() == [(-0.5, -0.5), (1.0, -0.25), (-4.5, 0.1 - 1.5)]
    assert boxes.rows["width"].tolist() == [10.0, 10.123456, 4.0]
    assert boxes.rows["confidence"].tolist() == [0.9, 0.875, 1.0]


def test_a_truth_says_what_counts_and_of_which_class(tmp_path: Path) -> None:
    rows = read_boxes(written(tmp_path, TRUTH), CLOCK).rows
    assert rows[["counted", "class_id", "visibility"]].tolist() == [(False, 7, 1.0), (True, 2, 0.86014)]


@pytest.mark.parametrize(
    ("text", "kind"), [(RESULT, "mot"), (TRUTH, "mot-gt"), (RESULT.replace("7,", "-1,").replace("12,", "-1,"), "mot-det")]
)
def test_what_was_read_is_written_as_it_was(tmp_path: Path, text: str, kind: str) -> None:
    source = written(tmp_path, text)
    write_boxes(tmp_path / "again.txt", read_boxes(source, CLOCK), CLOCK, kind)
    assert (tmp_path / "again.txt").read_text() == text


def test_random_boxes_of_six_digits_go_round_and_others_read_them(tmp_path: Path) -> None:
    random = np.random.default_rng(4)
    lines = []
    for frame in range(1, 400):
        for who in range(3):
            place = [
                f"{value:.6f}".rstrip("0").rstrip(".")
                for value in (*random.uniform(-50, 1300, 2), *random.uniform(0.01, 300, 2))
            ]
            lines.append(",".join([str(frame), str(who), *place, f"{random.uniform():.3g}", "-1", "-1", "-1"]))
    source = written(tmp_path, "\n".join(lines) + "\n")
    boxes = read_boxes(source, CLOCK)
    with source.open(newline="") as file:
        for row, cells in zip(boxes.rows, csv.reader(file), strict=True):
            assert row["left"] + 1.5 == pytest.approx(float(cells[2]), abs=1e-9)
    write_boxes(tmp_path / "again.txt", boxes, CLOCK)
    write_boxes(tmp_path / "third.txt", read_boxes(tmp_path / "again.txt", CLOCK), CLOCK)
    again = (tmp_path / "again.txt").read_text()
    assert [line.split(",")[:6] for line in again.splitlines()] == [line.split(",")[:6] for line in lines]
    assert (tmp_path / "third.txt").read_text() == again


def test_a_frame_of_a_broken_length_is_at_the_nearest_microsecond(tmp_path: Path) -> None:
    clock = FrameClock(1e6 / 30)
    boxes = read_boxes(written(tmp_path, "4,1,1,1,2,2,1,-1,-1,-1\n"), clock)
    assert boxes.instants_us.tolist() == [0, 33_333, 66_667, 100_000]
    write_boxes(tmp_path / "again.txt", boxes, clock)
    assert (tmp_path / "again.txt").read_text() == "4,1,1,1,2,2,1,-1,-1,-1\n"


def test_times_are_exact_on_a_clock_of_centuries(tmp_path: Path) -> None:
    clock = FrameClock(40_000, 2**59 + 1)
    assert read_boxes(written(tmp_path, RESULT), clock).instants_us.tolist() == [2**59 + 1 + 40_000 * k for k in range(3)]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1,1,2,3,4,5,6,7\n", "line 1: 8 values: must be 9 (truth) or 10 (results, detections), separated by commas"),
        (RESULT + "4,1,1,1,1,1,1,1,1\n", "line 4: 9 values: must be 10, as the lines before"),
        ("\n0,1,1,1,2,2,1,-1,-1,-1\n", "line 2: frame = '0': must be an integer from 1 to 1000000"),
        ("1.5,1,1,1,2,2,1,-1,-1,-1\n", "line 1: frame = '1.5': must be an integer from 1 to 1000000"),
        ("99999999,1,1,1,2,2,1,-1,-1,-1\n", "line 1: frame = '99999999': must be an integer from 1 to 1000000"),
        ("1,a,1,1,2,2,1,-1,-1,-1\n", "line 1: id = 'a': must be a number"),
        ("1,-2,1,1,2,2,1,-1,-1,-1\n", "line 1: id = -2: must be 0 or more, or -1 for a detection"),
        ("1,1,nan,1,2,2,1,-1,-1,-1\n", "line 1: left = 'nan': must be a number"),
        ("1,1,1,1,2,0,1,-1,-1,-1\n", "line 1: height = 0: must be from 0.001 to 1e+09"),
        ("1,1,1,1,2,2,1,-1,-1,inf\n", "line 1: z = 'inf': must be a number"),
        ("2,1,1,1,2,2,1,-1,-1,-1\n\n2,1,5,5,2,2,1,-1,-1,-1\n", "line 3: id = 1: must not occur twice at one time"),
    ],
)
def test_what_cannot_be_is_refused_with_its_line(tmp_path: Path, text: str, message: str) -> None:
    path = written(tmp_path, text)
    with pytest.raises(TrackLogError) as caught:
        read_boxes(path, CLOCK)
    assert str(caught.value) == f"{path}: {message}"


def test_frames_need_their_length_and_times_that_are_frames(tmp_path: Path) -> None:
    path = written(tmp_path, RESULT)
    with pytest.raises(
        ConfigError, match=r"boxes\.txt: has frames in place of times: their length must be given \(--frame-us\)$"
    ):
        read_boxes(path)
    boxes = read_boxes(path, CLOCK)
    with pytest.raises(
        TrackLogError, match=r"x\.txt: t = 1080000 us: must be 1000000 plus a multiple of 30000, the time of a frame"
    ):
        write_boxes(tmp_path / "x.txt", boxes, FrameClock(30_000, 1_000_000))
    assert not (tmp_path / "x.txt").exists()
    with pytest.raises(ConfigError, match=r"^frame_us = 0: must be from 1 to 1e\+09"):
        FrameClock(0)

# SPDX-License-Identifier: Apache-2.0
"""Logs become boxes at the times of frames, and boxes become logs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from evcot.errors import EvcotError, TrackLogError
from evcot.metrics.rule import load_rule
from evcot.metrics.scores import evaluate
from evcot.metrics.truth import read_truth
from evcot.tracks.formats import FORMAT_NAMES
from evcot.tracks.formats.base import FrameClock
from evcot.tracks.formats.of_log import boxes_of_log, log_of_boxes
from evcot.tracks.formats.registry import FORMATS, read_boxes, write_boxes
from evcot.tracks.log import Kind
from evcot.tracks.timeline import sample
from support.logs import HEIGHT, WIDTH, log_of

CLOCK = FrameClock(10_000, 5_000)
LOG = log_of(
    [
        (4_000, Kind.BORN, 0, 30.0, 40.0),
        (14_000, Kind.MOVED, 0, 32.0, 40.5),
        (15_000, Kind.BORN, 3, 90.0, 20.0),
        (26_000, Kind.LOST, 0, 33.0, 40.5),
        (46_000, Kind.MOVED, 3, 91.0, 20.0),
        (60_000, Kind.LOST, 3, 91.0, 20.0),
    ]
)


def test_a_log_is_sampled_at_the_times_of_frames() -> None:
    boxes = boxes_of_log(LOG, CLOCK, (346, 260))
    assert boxes.instants_us.tolist() == [5_000, 15_000, 25_000, 35_000, 45_000, 55_000]
    assert boxes.sensor == (346, 260)
    seen = boxes.rows[["instant", "id", "left", "top"]].tolist()
    first = [(0, 1, 30 - WIDTH / 2, 40 - HEIGHT / 2), (1, 1, 32 - WIDTH / 2, 40.5 - HEIGHT / 2)]
    assert seen[:2] == first
    assert [row[:2] for row in seen] == [(0, 1), (1, 1), (1, 4), (2, 1), (2, 4), (3, 4), (4, 4), (5, 4)]  # ids count from 1
    assert set(boxes.rows[["width", "height", "confidence"]].tolist()) == {(WIDTH, HEIGHT, 0.5)}
    young = boxes_of_log(LOG, CLOCK, max_age_us=20_000)
    assert [row[0] for row in young.rows[["instant", "id"]].tolist() if row[1] == 4] == [1, 2, 3, 5]
    later = boxes_of_log(LOG, FrameClock(10_000, 30_000), until_us=41_000)
    assert later.instants_us.tolist() == [30_000, 40_000]


@pytest.mark.parametrize("name", FORMAT_NAMES)
def test_a_result_without_a_box_is_an_empty_log_and_no_truth(name: str, tmp_path: Path) -> None:
    if name == "mcap":
        pytest.importorskip("mcap")
    path = tmp_path / f"r{FORMATS[name].SUFFIX}"
    write_boxes(path, boxes_of_log(log_of([]), CLOCK, (346, 260)), CLOCK, name)
    log = log_of_boxes(path, read_boxes(path, CLOCK, name))
    assert len(log.records) == 0
    truth = read_truth(boxes_file(tmp_path), load_rule("boxes"), clock=CLOCK)
    scores = evaluate(log, truth, load_rule("boxes"))
    assert (scores.hota, scores.tp, scores.fn, scores.fp) == (0.0, 0, 1, 0)
    with pytest.raises(EvcotError, match="no box counts: must have one at least that is to be found"):
        read_truth(path, load_rule("boxes"), clock=CLOCK, format=name)


def boxes_file(folder: Path) -> Path:
    (folder / "t.txt").write_text("1,1,71,109,40,40,1,1,1.0\n")
    return folder / "t.txt"


def test_a_turned_box_is_written_as_the_upright_rectangle_around_it() -> None:
    records = LOG.records.copy()
    records["angle"] = np.pi / 2
    boxes = boxes_of_log(type(LOG)("x", records, LOG.owner), CLOCK)
    np.testing.assert_allclose(boxes.rows["width"], HEIGHT)
    np.testing.assert_allclose(boxes.rows["left"][0], 30 - HEIGHT / 2)


def test_a_track_of_boxes_is_there_at_its_instants_alone(tmp_path: Path) -> None:
    """Track 5 in frames 1, 2 and 4, track 6 in frame 2."""
    lines = ["1,5,1,1,10,20", "2,5,3,1,10,20", "4,5,7,1,10,20", "2,6,50,50,4,4"]
    (tmp_path / "r.txt").write_text("".join(f"{line},0.5,-1,-1,-1\n" for line in lines))
    log = log_of_boxes("r.txt", read_boxes(tmp_path / "r.txt", CLOCK))
    states = sample(log, 5_000 + 10_000 * np.arange(-1, 6))
    assert states[["sample", "track_id", "x", "y"]].tolist() == [
        (1, 5, 4.5, 9.5), (2, 5, 6.5, 9.5), (2, 6, 50.5, 50.5), (4, 5, 10.5, 9.5),
    ]  # fmt: skip
    assert sample(log, np.array([24_999]))["track_id"].tolist() == [5, 6]
    assert (np.diff(log.records["t_us"]) >= 0).all()
    assert set(log.records["confidence"]) == {0.5}


@pytest.mark.parametrize("name", [name for name in FORMAT_NAMES if name != "mot-det"])
def test_boxes_of_a_log_go_through_every_format(tmp_path: Path, name: str) -> None:
    boxes = boxes_of_log(LOG, CLOCK, (346, 260))
    path = tmp_path / f"b{FORMATS[name].SUFFIX}"
    write_boxes(path, boxes, CLOCK, name)
    back = read_boxes(path, CLOCK, name)
    assert (
        back.rows[["id", "left", "top", "width", "height"]].tolist()
        == boxes.rows[["id", "left", "top", "width", "height"]].tolist()
    )
    assert back.instants_us[back.rows["instant"]].tolist() == boxes.instants_us[boxes.rows["instant"]].tolist()
    once, again = (sample(log_of_boxes(path, part), boxes.instants_us) for part in (boxes, back))
    assert once.tolist() == again.tolist()


def test_detections_are_no_tracks(tmp_path: Path) -> None:
    write_boxes(tmp_path / "det.txt", boxes_of_log(LOG, CLOCK), CLOCK, "mot-det")
    with pytest.raises(TrackLogError, match=r"^det\.txt: line 1: id = -1: must be a track's: detections are no tracks$"):
        log_of_boxes("det.txt", read_boxes(tmp_path / "det.txt", CLOCK))


def test_frames_without_end_are_refused() -> None:
    with pytest.raises(TrackLogError, match=r"frames from 0 to 60000000 us: must be at most 1000000"):
        boxes_of_log(LOG, FrameClock(10.0), until_us=60_000_000)


def test_the_names_of_the_formats_are_those_of_the_registry() -> None:
    assert tuple(FORMATS) == FORMAT_NAMES

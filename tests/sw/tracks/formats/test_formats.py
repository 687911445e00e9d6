# SPDX-License-Identifier: Apache-2.0
"""Boxes in the field's formats: COCO JSON, MOTChallenge text, Prophesee's boxes."""

from __future__ import annotations

import json
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from evcot.errors import ConfigError, EvcotError, TrackLogError
from evcot.metrics.rule import load_rule
from evcot.metrics.scores import evaluate
from evcot.metrics.truth import read_truth
from evcot.tracks.formats import FORMAT_NAMES
from evcot.tracks.formats.base import FrameClock
from evcot.tracks.formats.of_log import boxes_of_log, log_of_boxes
from evcot.tracks.formats.prophesee import EVENT_BBOX
from evcot.tracks.formats.registry import FORMATS, read_boxes, write_boxes
from evcot.tracks.log import Kind
from evcot.tracks.timeline import sample
from support.logs import HEIGHT, WIDTH, log_of
from support.refusals import refused

CLOCK = FrameClock(40_000)
IMAGES: list[dict[str, Any]] = [{"id": 3, "width": 346, "height": 260}, {"id": 1, "width": 346, "height": 260}]
BOX: dict[str, Any] = {
    "id": 1, "image_id": 1, "category_id": 2, "bbox": [0, 10.25, 4, 5.5], "track_id": 9, "score": 0.5, "iscrowd": 0,
}  # fmt: skip


def written(folder: Path, data: object) -> Path:
    path = folder / "boxes.json"
    path.write_text(json.dumps(data))
    return path


def test_images_are_frames_and_pixels_count_from_0(tmp_path: Path) -> None:
    crowd = BOX | {"image_id": 3, "iscrowd": 1, "instance_id": 5}
    boxes = read_boxes(written(tmp_path, {"images": IMAGES, "annotations": [crowd, BOX]}), CLOCK)
    assert boxes.instants_us.tolist() == [0, 80_000]
    assert boxes.sensor == (346, 260)
    assert boxes.rows["instant"].tolist() == [0, 1]
    assert boxes.rows[["id", "left", "top", "width", "height"]].tolist() == [(9, -0.5, 9.75, 4, 5.5), (5, -0.5, 9.75, 4, 5.5)]
    assert boxes.rows[["confidence", "class_id", "counted"]].tolist() == [(0.5, 2, True), (0.5, 2, False)]


def test_an_image_without_a_box_is_an_instant_t_us_is_its_time_and_results_are_a_list(tmp_path: Path) -> None:
    timed = [image | {"t_us": 7_000 * image["id"]} for image in IMAGES]
    boxes = read_boxes(written(tmp_path, {"images": timed, "annotations": [BOX]}))
    assert boxes.instants_us.tolist() == [7_000, 21_000]
    boxes = read_boxes(written(tmp_path, [{"image_id": 2, "category_id": 1, "bbox": [1, 2, 3, 4], "score": 0.25}]), CLOCK)
    assert boxes.instants_us.tolist() == [0, 40_000]
    assert boxes.rows[["instant", "id", "confidence"]].tolist() == [(1, -1, 0.25)]


def test_what_was_read_is_written_as_it_was(tmp_path: Path) -> None:
    listed = [
        BOX | {"id": i + 1, "image_id": image, "bbox": [0.1, 2.345678, 3.3, 1000.000001]} for i, image in enumerate((1, 3))
    ]
    source = written(tmp_path, {"images": IMAGES, "annotations": listed})
    write_boxes(tmp_path / "a.json", read_boxes(source, CLOCK), CLOCK)
    write_boxes(tmp_path / "b.json", read_boxes(tmp_path / "a.json"))
    data, again = (json.loads((tmp_path / name).read_text()) for name in ("a.json", "b.json"))
    assert [{name: box[name] for name in BOX} for box in data["annotations"]] == listed
    assert [box["area"] for box in data["annotations"]] == [3300.000003] * 2
    assert data["images"] == [{"id": i, "width": 346, "height": 260, "t_us": t} for i, t in ((1, 0), (3, 80_000))]
    assert data["categories"] == [{"id": 2, "name": "class 2"}]
    assert [image["t_us"] for image in again["images"]] == [0, 80_000]
    assert [box["bbox"] for box in again["annotations"]] == [box["bbox"] for box in data["annotations"]]


def test_names_of_classes_are_read_and_written(tmp_path: Path) -> None:
    data = {"images": IMAGES, "annotations": [BOX], "categories": [{"id": 2, "name": "car"}, {"id": 5}]}
    boxes = read_boxes(written(tmp_path, data), CLOCK)
    assert boxes.class_names == {2: "car"}
    write_boxes(tmp_path / "a.json", boxes, CLOCK)
    assert json.loads((tmp_path / "a.json").read_text())["categories"] == [{"id": 2, "name": "car"}]


@pytest.mark.parametrize(
    ("categories", "message"),
    [
        ({}, "categories: must be a list"),
        ([2], "category 0: must be an object with an id"),
        ([{"name": "car"}], "category 0: id = None: must be an integer"),
        ([{"id": 2, "name": 2}], "category 0: name of a class = 2: must be 1 to 64 printable characters"),
        ([{"id": 2}, {"id": 3, "name": "a\nb"}], r"category 1: name of a class = 'a\nb': must be 1 to 64 printable"),
        ([{"id": 2, "name": "car"}, {"id": 2, "name": "van"}], "category 1: id = 2: must not occur twice"),
    ],
)
def test_categories_that_cannot_be_are_refused(tmp_path: Path, categories: object, message: str) -> None:
    path = written(tmp_path, {"images": IMAGES, "annotations": [BOX], "categories": categories})
    with refused(TrackLogError, start=f"{path}: {message}"):
        read_boxes(path, CLOCK)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ({"images": []}, "must be a list of results, or have the lists images and annotations"),
        ([3], "result 0: must be an object with image_id and bbox"),
        ([{"bbox": [1, 2, 3, 4]}], "result 0: image_id = None: must be an integer"),
        (
            [{"image_id": 0, "bbox": [1, 2, 3, 4]}],
            "image id 0: must be a frame's number, from 1 to 1000000, or every image must have",
        ),
        ([{"image_id": 1, "bbox": [1, 2, 3]}], "result 0: bbox = [1, 2, 3]: must be [left, top, width, height]"),
        ([{"image_id": 1, "bbox": [1, 2, 3, -4]}], "result 0: height = -4: must be from 0.001 to 1e+09"),
        ([{"image_id": 1, "bbox": [1, 2, 3, 4], "score": "high"}], "result 0: score = high: must be a number"),
        ([{"image_id": 1, "bbox": [1, 2, 3, 4], "track_id": 1.5}], "result 0: track_id = 1.5: must be an integer"),
        ({"images": IMAGES, "annotations": [BOX | {"image_id": 2}]}, "annotation 0: image_id = 2: must be the id of an image"),
        ({"images": [*IMAGES, IMAGES[0]], "annotations": [BOX]}, "image id 3: must not occur twice"),
        ({"images": [*IMAGES, {"id": 4, "width": 5, "height": 5}], "annotations": [BOX]}, "images of 2 sizes: must be of one"),
        ({"images": IMAGES, "annotations": [BOX, BOX]}, "annotation 1: id = 9: must not occur twice at one time"),
    ],
)
def test_what_cannot_be_is_refused(tmp_path: Path, data: object, message: str) -> None:
    path = written(tmp_path, data)
    with refused(TrackLogError, start=f"{path}: {message}"):
        read_boxes(path, CLOCK)


def test_text_that_is_no_json_is_refused_with_its_line(tmp_path: Path) -> None:
    (tmp_path / "a.json").write_text('{\n"images": [}')
    with pytest.raises(TrackLogError, match=r"a\.json: line 2: is no JSON: "):
        read_boxes(tmp_path / "a.json", CLOCK)
    (tmp_path / "a.json").write_text("[" * 100_000)
    with pytest.raises(TrackLogError, match=r"a\.json: (is nested too deeply|line 1: is no JSON)"):
        read_boxes(tmp_path / "a.json", CLOCK)


MOT_CLOCK = FrameClock(40_000, 1_000_000)
RESULT = "1,7,1,1,10,20,0.9,-1,-1,-1\n3,7,2.5,1.25,10.123456,20,0.875,-1,-1,-1\n3,12,-3,0.1,4,5,1,-1,-1,-1\n"
TRUTH = "1,1,912,484,97,109,0,7,1\n2,1,912,484,97.5,109,1,2,0.86014\n"


def mot_written(folder: Path, text: str) -> Path:
    path = folder / "boxes.txt"
    path.write_text(text)
    return path


def test_frames_and_pixels_count_from_1(tmp_path: Path) -> None:
    """The box at (1, 1) begins where the first pixel does: at -0.5."""
    boxes = read_boxes(mot_written(tmp_path, RESULT), MOT_CLOCK)
    assert boxes.instants_us.tolist() == [1_000_000, 1_040_000, 1_080_000]  # frame 2, without a box, is one, too
    assert boxes.rows["instant"].tolist() == [0, 2, 2]
    assert boxes.rows["id"].tolist() == [7, 7, 12]
    assert boxes.rows[["left", "top"]].tolist() == [(-0.5, -0.5), (1.0, -0.25), (-4.5, 0.1 - 1.5)]
    assert boxes.rows["width"].tolist() == [10.0, 10.123456, 4.0]
    assert boxes.rows["confidence"].tolist() == [0.9, 0.875, 1.0]


def test_a_truth_says_what_counts_and_of_which_class(tmp_path: Path) -> None:
    rows = read_boxes(mot_written(tmp_path, TRUTH), MOT_CLOCK).rows
    assert rows[["counted", "class_id", "visibility"]].tolist() == [(False, 7, 1.0), (True, 2, 0.86014)]


@pytest.mark.parametrize(
    ("text", "kind"), [(RESULT, "mot"), (TRUTH, "mot-gt"), (RESULT.replace("7,", "-1,").replace("12,", "-1,"), "mot-det")]
)
def test_mot_what_was_read_is_written_as_it_was(tmp_path: Path, text: str, kind: str) -> None:
    source = mot_written(tmp_path, text)
    write_boxes(tmp_path / "again.txt", read_boxes(source, MOT_CLOCK), MOT_CLOCK, kind)
    assert (tmp_path / "again.txt").read_text() == text


def test_random_boxes_of_six_digits_go_round(tmp_path: Path) -> None:
    random, lines = np.random.default_rng(4), []
    for frame, who in product(range(1, 400), range(3)):
        place = [
            f"{value:.6f}".rstrip("0").rstrip(".") for value in random.uniform((-50, -50, 0.01, 0.01), (1300, 1300, 300, 300))
        ]
        lines.append(",".join([str(frame), str(who), *place, f"{random.uniform():.3g}", "-1", "-1", "-1"]))
    boxes = read_boxes(mot_written(tmp_path, "\n".join(lines) + "\n"), MOT_CLOCK)
    assert boxes.rows["left"] + 1.5 == pytest.approx([float(line.split(",")[2]) for line in lines], abs=1e-9)
    write_boxes(tmp_path / "again.txt", boxes, MOT_CLOCK)
    write_boxes(tmp_path / "third.txt", read_boxes(tmp_path / "again.txt", MOT_CLOCK), MOT_CLOCK)
    again = (tmp_path / "again.txt").read_text()
    assert [line.split(",")[:6] for line in again.splitlines()] == [line.split(",")[:6] for line in lines]
    assert (tmp_path / "third.txt").read_text() == again


def test_a_frame_of_a_broken_length_is_at_the_nearest_microsecond_and_centuries_are_exact(tmp_path: Path) -> None:
    clock = FrameClock(1e6 / 30)
    boxes = read_boxes(mot_written(tmp_path, "4,1,1,1,2,2,1,-1,-1,-1\n"), clock)
    assert boxes.instants_us.tolist() == [0, 33_333, 66_667, 100_000]
    write_boxes(tmp_path / "again.txt", boxes, clock)
    assert (tmp_path / "again.txt").read_text() == "4,1,1,1,2,2,1,-1,-1,-1\n"
    clock = FrameClock(40_000, 2**59 + 1)
    assert read_boxes(mot_written(tmp_path, RESULT), clock).instants_us.tolist() == [2**59 + 1 + 40_000 * k for k in range(3)]


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
    path = mot_written(tmp_path, text)
    with refused(TrackLogError, f"{path}: {message}"):
        read_boxes(path, MOT_CLOCK)


def test_frames_need_their_length_and_times_that_are_frames(tmp_path: Path) -> None:
    path = mot_written(tmp_path, RESULT)
    with pytest.raises(
        ConfigError, match=r"boxes\.txt: has frames in place of times: their length must be given \(--frame-us\)$"
    ):
        read_boxes(path)
    boxes = read_boxes(path, MOT_CLOCK)
    with pytest.raises(
        TrackLogError, match=r"x\.txt: t = 1080000 us: must be 1000000 plus a multiple of 30000, the time of a frame"
    ):
        write_boxes(tmp_path / "x.txt", boxes, FrameClock(30_000, 1_000_000))
    assert not (tmp_path / "x.txt").exists()
    with pytest.raises(ConfigError, match=r"^frame_us = 0: must be from 1 to 1e\+09"):
        FrameClock(0)


def labels() -> np.ndarray:  # type: ignore[type-arg]
    made = np.zeros(3, EVENT_BBOX)
    made["t"], made["track_id"], made["class_id"] = (500, 500, 70_500), (3, 4, 3), (0, 1, 0)
    made["x"], made["y"], made["w"], made["h"] = (0, 10.1, -3), (0.3, 20, 7), (5, 6.7, 8), (1, 2, 3)
    made["class_confidence"] = (1, 0.7, 0.25)
    return made


def test_pixels_count_from_0_and_times_are_microseconds(tmp_path: Path) -> None:
    np.save(tmp_path / "a_bbox.npy", labels())
    boxes = read_boxes(tmp_path / "a_bbox.npy")
    assert boxes.instants_us.tolist() == [500, 70_500]
    assert boxes.rows["instant"].tolist() == [0, 0, 1]
    assert boxes.rows["left"].tolist() == [-0.5, float(np.float32(10.1)) - 0.5, -3.5]
    assert boxes.rows[["id", "class_id"]].tolist() == [(3, 0), (4, 1), (3, 0)]
    assert boxes.rows["confidence"].tolist() == [1.0, float(np.float32(0.7)), 0.25]


def test_what_was_read_is_written_bit_by_bit(tmp_path: Path) -> None:
    random = np.random.default_rng(3)
    made = np.zeros(5_000, EVENT_BBOX)
    made["t"] = np.repeat(np.arange(500) * 12_345, 10)
    made["track_id"] = np.tile(np.arange(10), 500) + 2**31
    for name in ("x", "y", "w", "h"):
        made[name] = random.uniform(0.01, 1_300, 5_000)
    made["class_confidence"] = random.uniform(0, 1, 5_000)
    np.save(tmp_path / "a.npy", made)
    write_boxes(tmp_path / "b.npy", read_boxes(tmp_path / "a.npy"))
    again = np.load(tmp_path / "b.npy")
    assert again.dtype == EVENT_BBOX
    assert again.tolist() == made.tolist()


def test_the_names_of_2020_are_read(tmp_path: Path) -> None:
    floats = [(name, "<f4") for name in "xywh"]
    old = np.dtype([("ts", "<u8"), *floats, ("class_id", "u1"), ("confidence", "<f4"), ("track_id", "<u4")])
    now, then = labels(), np.zeros(3, old)
    for name in old.names or ():
        then[name] = now[{"ts": "t", "confidence": "class_confidence"}.get(name, name)]
    np.save(tmp_path / "old.npy", then)
    np.save(tmp_path / "new.npy", now)
    a, b = read_boxes(tmp_path / "old.npy"), read_boxes(tmp_path / "new.npy")
    assert a.instants_us.tolist() == b.instants_us.tolist()
    assert a.rows.tolist() == b.rows.tolist()


def test_prophesee_what_cannot_be_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.npy"
    with refused(TrackLogError, f"{path}: cannot be read: No such file or directory"):
        read_boxes(path)
    path.write_bytes(b"nothing")
    with refused(TrackLogError, start=f"{path}: is no NumPy file: "):
        read_boxes(path)
    width, time, name = labels(), labels(), labels()
    width["w"][1], time["t"][2], name["track_id"] = np.nan, -5, 3
    fields = [(name, EVENT_BBOX[name]) for name in EVENT_BBOX.names or ()]
    for array, message in (
        (np.zeros((3, 3)), "must hold one row a box, with the fields t, x, y, w, h, class_id, track_id, class_confidence"),
        (np.array([{"t": 1}], object), "is no NumPy file: "),
        (np.zeros(2, [("t", "i8"), ("x", "f4")]), "has no field y: must have t, x, y"),
        (np.zeros(2, [*fields, ("z", "f4")]), "unknown field z: must have t, x, y"),
        (width, "box 1: width = nan: must be from 0.001 to 1e+09"),
        (time, "box 2: t = -5: must be from 0 to 2^60"),
        (name, "box 1: id = 3: must not occur twice at one time"),
    ):
        np.save(path, array)
        with refused(TrackLogError, start=f"{path}: {message}"):
            read_boxes(path)


LOG_CLOCK = FrameClock(10_000, 5_000)
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
    boxes = boxes_of_log(LOG, LOG_CLOCK, (346, 260))
    assert boxes.instants_us.tolist() == [5_000, 15_000, 25_000, 35_000, 45_000, 55_000]
    assert boxes.sensor == (346, 260)
    seen = boxes.rows[["instant", "id", "left", "top"]].tolist()
    first = [(0, 1, 30 - WIDTH / 2, 40 - HEIGHT / 2), (1, 1, 32 - WIDTH / 2, 40.5 - HEIGHT / 2)]
    assert seen[:2] == first
    assert [row[:2] for row in seen] == [(0, 1), (1, 1), (1, 4), (2, 1), (2, 4), (3, 4), (4, 4), (5, 4)]  # ids count from 1
    assert set(boxes.rows[["width", "height", "confidence"]].tolist()) == {(WIDTH, HEIGHT, 0.5)}
    young = boxes_of_log(LOG, LOG_CLOCK, max_age_us=20_000)
    assert [row[0] for row in young.rows[["instant", "id"]].tolist() if row[1] == 4] == [1, 2, 3, 5]
    later = boxes_of_log(LOG, FrameClock(10_000, 30_000), until_us=41_000)
    assert later.instants_us.tolist() == [30_000, 40_000]


@pytest.mark.parametrize("name", FORMAT_NAMES)
def test_a_result_without_a_box_is_an_empty_log_and_no_truth(name: str, tmp_path: Path) -> None:
    if name == "mcap":
        pytest.importorskip("mcap")
    path = tmp_path / f"r{FORMATS[name].SUFFIX}"
    write_boxes(path, boxes_of_log(log_of([]), LOG_CLOCK, (346, 260)), LOG_CLOCK, name)
    log = log_of_boxes(path, read_boxes(path, LOG_CLOCK, name))
    assert len(log.records) == 0
    truth = read_truth(boxes_file(tmp_path), load_rule("boxes"), clock=LOG_CLOCK)
    scores = evaluate(log, truth, load_rule("boxes"))
    assert (scores.hota, scores.tp, scores.fn, scores.fp) == (0.0, 0, 1, 0)
    with pytest.raises(EvcotError, match="no box counts: must have one at least that is to be found"):
        read_truth(path, load_rule("boxes"), clock=LOG_CLOCK, format=name)


def boxes_file(folder: Path) -> Path:
    (folder / "t.txt").write_text("1,1,71,109,40,40,1,1,1.0\n")
    return folder / "t.txt"


def test_a_turned_box_is_written_as_the_upright_rectangle_around_it() -> None:
    records = LOG.records.copy()
    records["angle"] = np.pi / 2
    boxes = boxes_of_log(type(LOG)("x", records, LOG.owner), LOG_CLOCK)
    np.testing.assert_allclose(boxes.rows["width"], HEIGHT)
    np.testing.assert_allclose(boxes.rows["left"][0], 30 - HEIGHT / 2)


def test_a_track_of_boxes_is_there_at_its_instants_alone(tmp_path: Path) -> None:
    """Track 5 in frames 1, 2 and 4, track 6 in frame 2."""
    lines = ["1,5,1,1,10,20", "2,5,3,1,10,20", "4,5,7,1,10,20", "2,6,50,50,4,4"]
    (tmp_path / "r.txt").write_text("".join(f"{line},0.5,-1,-1,-1\n" for line in lines))
    log = log_of_boxes("r.txt", read_boxes(tmp_path / "r.txt", LOG_CLOCK))
    states = sample(log, 5_000 + 10_000 * np.arange(-1, 6))
    assert states[["sample", "track_id", "x", "y"]].tolist() == [
        (1, 5, 4.5, 9.5), (2, 5, 6.5, 9.5), (2, 6, 50.5, 50.5), (4, 5, 10.5, 9.5),
    ]  # fmt: skip
    assert sample(log, np.array([24_999]))["track_id"].tolist() == [5, 6]
    assert (np.diff(log.records["t_us"]) >= 0).all()
    assert set(log.records["confidence"]) == {0.5}


@pytest.mark.parametrize("name", [name for name in FORMAT_NAMES if name != "mot-det"])
def test_boxes_of_a_log_go_through_every_format(tmp_path: Path, name: str) -> None:
    boxes = boxes_of_log(LOG, LOG_CLOCK, (346, 260))
    path = tmp_path / f"b{FORMATS[name].SUFFIX}"
    write_boxes(path, boxes, LOG_CLOCK, name)
    back = read_boxes(path, LOG_CLOCK, name)
    fields = ["id", "left", "top", "width", "height"]
    assert back.rows[fields].tolist() == boxes.rows[fields].tolist()
    assert back.instants_us[back.rows["instant"]].tolist() == boxes.instants_us[boxes.rows["instant"]].tolist()
    once, again = (sample(log_of_boxes(path, part), boxes.instants_us) for part in (boxes, back))
    assert once.tolist() == again.tolist()


def test_detections_are_no_tracks(tmp_path: Path) -> None:
    write_boxes(tmp_path / "det.txt", boxes_of_log(LOG, LOG_CLOCK), LOG_CLOCK, "mot-det")
    with pytest.raises(TrackLogError, match=r"^det\.txt: line 1: id = -1: must be a track's: detections are no tracks$"):
        log_of_boxes("det.txt", read_boxes(tmp_path / "det.txt", LOG_CLOCK))


def test_frames_without_end_are_refused() -> None:
    assert tuple(FORMATS) == FORMAT_NAMES
    with pytest.raises(TrackLogError, match=r"frames from 0 to 60000000 us: must be at most 1000000"):
        boxes_of_log(LOG, FrameClock(10.0), until_us=60_000_000)

# SPDX-License-Identifier: Apache-2.0
"""COCO's JSON, as a data set and as a list of results."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from evcot.errors import TrackLogError
from evcot.tracks.formats.base import FrameClock
from evcot.tracks.formats.registry import read_boxes, write_boxes

CLOCK = FrameClock(40_000)
IMAGES: list[dict[str, Any]] = [{"id": 3, "width": 346, "height": 260}, {"id": 1, "width": 346, "height": 260}]
BOX: dict[str, Any] = {
    "id": 1,
    "image_id": 1,
    "category_id": 2,
    "bbox": [0, 10.25, 4, 5.5],
    "track_id": 9,
    "score": 0.5,
    "iscrowd": 0,
}


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


def test_an_image_without_a_box_is_an_instant_and_t_us_is_its_time(tmp_path: Path) -> None:
    timed = [image | {"t_us": 7_000 * image["id"]} for image in IMAGES]
    boxes = read_boxes(written(tmp_path, {"images": timed, "annotations": [BOX]}))
    assert boxes.instants_us.tolist() == [7_000, 21_000]


def test_results_are_a_list(tmp_path: Path) -> None:
    result = {"image_id": 2, "category_id": 1, "bbox": [1, 2, 3, 4], "score": 0.25}
    boxes = read_boxes(written(tmp_path, [result]), CLOCK)
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
    with pytest.raises(TrackLogError) as caught:
        read_boxes(path, CLOCK)
    assert str(caught.value).startswith(f"{path}: {message}")


def test_text_that_is_no_json_is_refused_with_its_line(tmp_path: Path) -> None:
    (tmp_path / "a.json").write_text('{\n"images": [}')
    with pytest.raises(TrackLogError, match=r"a\.json: line 2: is no JSON: "):
        read_boxes(tmp_path / "a.json", CLOCK)
    (tmp_path / "a.json").write_text("[" * 100_000)
    with pytest.raises(TrackLogError, match=r"a\.json: (is nested too deeply|line 1: is no JSON)"):
        read_boxes(tmp_path / "a.json", CLOCK)

# SPDX-License-Identifier: Apache-2.0
"""COCO's JSON: https://cocodataset.org/#format-data. Boxes are [left, top, width, height]; the first pixel begins at 0.

Read are data sets (`images` and `annotations`) and lists of results. An image is the frame with the number of its id, counted
from 1; where every image has `t_us`, which evcot writes, that is its time. A track's id is `track_id` or `instance_id`, its
confidence `score`. A box of a crowd (`iscrowd`) need not be found. `categories` name the classes.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from ...errors import ConfigError, TrackLogError
from ...outputs import note_input
from ..record import check_class_name
from .base import BOX, FRAME_MAX, NOBODY, Boxes, FrameClock, decimal

__all__ = ["CocoBoxes"]

_EDGE = 0.5  # where the first pixel begins, 0, less where it does in evcot, -0.5
_INTEGER_MAX = 2**60


class CocoBoxes:
    """A data set with tracks, or a list of results."""

    NAME, SUFFIX, TITLE = "coco", ".json", "COCO boxes"

    @staticmethod
    def read(path: Path, clock: FrameClock) -> Boxes:
        """See `BoxFormat`."""
        data = _load(path)
        if isinstance(data, list):
            listed, images, name, categories = data, None, "result", []
        elif isinstance(data, dict) and isinstance(data.get("annotations"), list) and isinstance(data.get("images"), list):
            listed, images, name = data["annotations"], data["images"], "annotation"
            categories = data.get("categories", [])
        else:
            raise TrackLogError(f"{path}: must be a list of results, or have the lists images and annotations")
        rows = np.zeros(len(listed), BOX)
        image_ids = np.zeros(len(listed), np.int64)
        for i, entry in enumerate(listed):
            where = f"{path}: {name} {i}"
            if not isinstance(entry, dict):
                raise TrackLogError(f"{where}: must be an object with image_id and bbox")
            image_ids[i] = _integer(where, entry, "image_id")
            box = entry.get("bbox")
            if not (isinstance(box, list) and len(box) == 4 and all(map(_is_number, box))):
                raise TrackLogError(f"{where}: bbox = {str(box)[:40]}: must be [left, top, width, height]")
            row = rows[i]
            row["left"], row["top"], row["width"], row["height"] = box[0] - _EDGE, box[1] - _EDGE, box[2], box[3]
            row["id"] = _integer(where, entry, "instance_id" if "instance_id" in entry else "track_id", NOBODY)
            row["class_id"] = _integer(where, entry, "category_id", 1)
            score = entry.get("score", 1.0)
            if not _is_number(score):
                raise TrackLogError(f"{where}: score = {str(score)[:40]}: must be a number")
            row["confidence"], row["visibility"] = score, 1.0
            row["counted"] = not entry.get("iscrowd", 0)
        sensor, ids, times_us = _images(path, images, image_ids, clock)
        at = np.searchsorted(ids, image_ids)
        missing = ids[np.minimum(at, len(ids) - 1)] != image_ids if len(ids) else np.ones(len(rows), np.bool_)
        if missing.any():
            row_at = int(np.argmax(missing))
            raise TrackLogError(f"{path}: {name} {row_at}: image_id = {image_ids[row_at]}: must be the id of an image")
        instants_us, instant = np.unique(times_us, return_inverse=True)
        rows["instant"] = instant[at] if len(rows) else 0
        return Boxes(instants_us, rows, sensor, name, class_names=_class_names(path, categories))

    @staticmethod
    def write(file: BinaryIO, path: Path, boxes: Boxes, clock: FrameClock) -> None:
        """See `BoxFormat`: a data set with tracks and scores, an image per instant, whose id is its frame's number.

        Without the length of a frame the images are counted.
        """
        known = clock.frame_us is not None
        numbers = (clock.frames(boxes.instants_us, path) if known else np.arange(1, len(boxes.instants_us) + 1)).tolist()
        size = {} if boxes.sensor is None else {"width": boxes.sensor[0], "height": boxes.sensor[1]}
        times = zip(numbers, boxes.instants_us.tolist(), strict=True)
        images = [{"id": number, **size, "t_us": t_us} for number, t_us in times]
        annotations = []
        for i, row in enumerate(boxes.rows):
            sides = (row["left"] + _EDGE, row["top"] + _EDGE, row["width"], row["height"])
            box = [json.loads(decimal(float(value))) for value in sides]
            identity = {} if row["id"] == NOBODY else {"track_id": int(row["id"])}
            annotations.append(
                {
                    "id": i + 1, "image_id": numbers[row["instant"]], "category_id": int(row["class_id"]), "bbox": box,
                    "area": json.loads(decimal(box[2] * box[3])), "iscrowd": int(not row["counted"]), **identity,
                    "score": json.loads(decimal(float(row["confidence"]))),
                }
            )  # fmt: skip
        categories = [
            {"id": number, "name": boxes.class_names.get(number, f"class {number}")}
            for number in np.unique(boxes.rows["class_id"]).tolist()
        ]
        parts = (("images", images), ("annotations", annotations), ("categories", categories))
        listed = (f'"{name}": [\n' + ",\n".join(json.dumps(entry) for entry in entries) + "\n]" for name, entries in parts)
        file.write(("{\n" + ",\n".join(listed) + "\n}\n").encode())


def _load(path: Path) -> Any:
    note_input(path)
    try:
        return json.loads(path.read_text(encoding="utf-8-sig"))
    except OSError as error:
        raise TrackLogError(f"{path}: cannot be read: {error.strerror or error}") from error
    except UnicodeDecodeError as error:
        raise TrackLogError(f"{path}: byte {error.start}: must be UTF-8 text") from error
    except json.JSONDecodeError as error:
        raise TrackLogError(f"{path}: line {error.lineno}: is no JSON: {error.msg}") from error
    except RecursionError as error:
        raise TrackLogError(f"{path}: is nested too deeply") from error


def _images(
    path: Path, images: list[Any] | None, used: NDArray[np.int64], clock: FrameClock
) -> tuple[tuple[int, int] | None, NDArray[np.int64], NDArray[np.int64]]:
    """The size of all images, if they have one; their ids, ascending, and times."""
    if images is None:
        if len(used):
            _check_frames(path, used)
        ids = np.arange(1, used.max(initial=0) + 1)
        return None, ids, clock.times_us(ids, path)
    sizes, ids_listed, times = set(), [], []
    for i, image in enumerate(images):
        where = f"{path}: image {i}"
        if not isinstance(image, dict):
            raise TrackLogError(f"{where}: must be an object with an id")
        ids_listed.append(_integer(where, image, "id"))
        times.append(_integer(where, image, "t_us") if "t_us" in image else None)
        if "width" in image or "height" in image:
            sizes.add((_integer(where, image, "width"), _integer(where, image, "height")))
    if len(sizes) > 1:
        raise TrackLogError(f"{path}: images of {len(sizes)} sizes: must be of one")
    ids = np.array(ids_listed, np.int64)
    order = np.argsort(ids)
    if (np.diff(ids[order]) == 0).any():
        raise TrackLogError(f"{path}: image id {ids[order][np.flatnonzero(np.diff(ids[order]) == 0)[0]]}: must not occur twice")
    if None not in times:
        times_us = np.array(times, np.int64)
    else:
        _check_frames(path, ids)
        times_us = clock.times_us(ids, path)
    return next(iter(sizes), None), ids[order], times_us[order]


def _class_names(path: Path, categories: Any) -> dict[int, str]:
    """The names of the categories that have one."""
    if not isinstance(categories, list):
        raise TrackLogError(f"{path}: categories: must be a list")
    names: dict[int, str] = {}
    for i, category in enumerate(categories):
        where = f"{path}: category {i}"
        if not isinstance(category, dict):
            raise TrackLogError(f"{where}: must be an object with an id")
        number = _integer(where, category, "id")
        if number in names:
            raise TrackLogError(f"{where}: id = {number}: must not occur twice")
        if number >= 0 and "name" in category:
            try:
                names[number] = check_class_name(category["name"])
            except ConfigError as error:
                raise TrackLogError(f"{where}: {error}") from error
    return names


def _check_frames(path: Path, ids: NDArray[np.int64]) -> None:
    wrong = (ids < 1) | (ids > FRAME_MAX)
    if wrong.any():
        value = ids[int(np.argmax(wrong))]
        rule = f"must be a frame's number, from 1 to {FRAME_MAX}, or every image must have t_us"
        raise TrackLogError(f"{path}: image id {value}: {rule}")


def _integer(where: str, entry: Mapping[str, Any], name: str, default: int | None = None) -> int:
    value = entry.get(name, default)
    if type(value) is not int or abs(value) > _INTEGER_MAX:
        raise TrackLogError(f"{where}: {name} = {str(value)[:40]}: must be an integer")
    return value


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)

# SPDX-License-Identifier: Apache-2.0
"""Prophesee's boxes, with the names of 2020 and with those of today."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from evcot.errors import TrackLogError
from evcot.tracks.formats.prophesee import EVENT_BBOX
from evcot.tracks.formats.registry import read_boxes, write_boxes


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


def test_what_cannot_be_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.npy"

    def refused(message: str) -> None:
        with pytest.raises(TrackLogError) as caught:
            read_boxes(path)
        assert str(caught.value).startswith(f"{path}: {message}")
        assert "\n" not in str(caught.value)

    refused("cannot be read: No such file or directory")
    path.write_bytes(b"nothing")
    refused("is no NumPy file: ")
    np.save(path, np.zeros((3, 3)))
    refused("must hold one row a box, with the fields t, x, y, w, h, class_id, track_id, class_confidence")
    np.save(path, np.array([{"t": 1}], object), allow_pickle=True)
    refused("is no NumPy file: ")
    np.save(path, np.zeros(2, [("t", "i8"), ("x", "f4")]))
    refused("has no field y: must have t, x, y")
    np.save(path, np.zeros(2, [*((name, EVENT_BBOX[name]) for name in EVENT_BBOX.names or ()), ("z", "f4")]))
    refused("unknown field z: must have t, x, y")
    wrong = labels()
    wrong["w"][1] = np.nan
    np.save(path, wrong)
    refused("box 1: width = nan: must be from 0.001 to 1e+09")
    wrong = labels()
    wrong["t"][2] = -5
    np.save(path, wrong)
    refused("box 2: t = -5: must be from 0 to 2^60")
    wrong = labels()
    wrong["track_id"] = 3
    np.save(path, wrong)
    refused("box 1: id = 3: must not occur twice at one time")

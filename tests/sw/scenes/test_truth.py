# SPDX-License-Identifier: Apache-2.0
"""A box follows its waypoints; the occluded part of an object, compared with areas computed by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.errors import RecordingError
from evcot.scenes._occlusion_kernel import hidden_parts
from evcot.scenes.shapes import discs, quadrangles
from evcot.scenes.truth import TRUTH, Box, ObjectClass, Truth, sample
from support.refusals import refused

STORY = Box(
    width=4.0,
    height=2.0,
    brighter=True,
    t_us=np.array([100_000.0, 200_000.0, 300_000.0, 400_000.0]),
    x=np.array([-3.0, 7.0, 7.0, -3.0]),
    y=np.array([5.0, 5.0, 5.0, 25.0]),
)


def test_positions_lie_on_straight_lines_between_waypoints_and_rest_beyond_them() -> None:
    x, y = STORY.centre(np.array([0, 100_000, 150_000, 200_000, 250_000, 350_000, 400_000, 900_000]))
    assert x.tolist() == [-3.0, -3.0, 2.0, 7.0, 7.0, 2.0, -3.0, -3.0]
    assert y.tolist() == [5.0, 5.0, 5.0, 5.0, 5.0, 15.0, 25.0, 25.0]


def test_velocity_is_that_of_the_stretch_and_zero_at_rest() -> None:
    vx, vy = STORY.velocity(np.array([0, 100_000, 199_999, 200_000, 300_000, 399_999, 400_000, 900_000]))
    np.testing.assert_allclose(vx, [0, 100, 100, 0, -100, -100, 0, 0])
    np.testing.assert_allclose(vy, [0, 0, 0, 0, 200, 200, 0, 0])


def test_a_box_is_visible_while_its_centre_is_on_the_sensor() -> None:
    times = np.array([124_000, 126_000, 250_000, 349_000, 374_000, 376_000])
    samples = sample((STORY,), times, (10, 15))
    x, y = STORY.centre(times)
    np.testing.assert_allclose(x[:2], [-0.6, -0.4])
    assert samples["visible"].tolist() == [False, True, True, False, False, False]
    assert y[3] > 14.5
    assert samples.dtype.names == (
        "t_us",
        "object_id",
        "x",
        "y",
        "width",
        "height",
        "vx",
        "vy",
        "visible",
        "occluded",
        "class_id",
    )


def test_a_box_is_occluded_by_the_part_that_lies_outside_the_sensor() -> None:
    """4 by 2 pixels before 10 by 15, whose pixels reach from -0.5 to 9.5 and 14.5."""
    times = np.array([0, 115_000, 125_000, 150_000, 200_000, 300_000, 347_500, 400_000])
    samples = sample((STORY,), times, (10, 15))
    # At x = -3, -1.5, -0.5, 2, 7 and 7; then at (2.25, 14.5), then below.
    np.testing.assert_allclose(samples["occluded"], [1.0, 0.75, 0.5, 0.0, 0.0, 0.0, 0.5, 1.0], atol=1e-12)


def test_truth_survives_a_file(tmp_path: Path) -> None:
    samples = sample((STORY, STORY), np.arange(0, 500_000, 7_000), (10, 15))
    path = tmp_path / "story.truth.csv"
    Truth(samples).save(path)
    first = "0,0,-5.0000,4.0000,4.0000,2.0000,0.000,0.000,0,1.0000,0"
    assert path.read_text().startswith(f"{HEADER}{first}\n")
    loaded = Truth.load(path).samples
    assert loaded.dtype == TRUTH
    for name in TRUTH.names or ():
        np.testing.assert_allclose(loaded[name], samples[name], atol=1e-3 if TRUTH[name].kind == "f" else 0)
    assert [entry.name for entry in tmp_path.iterdir()] == ["story.truth.csv"]
    Truth(np.empty(0, TRUTH)).save(tmp_path / "t.csv")
    assert len(Truth.load(tmp_path / "t.csv").samples) == 0


HEADER = "t_us,object_id,left,top,width,height,vx,vy,visible,occluded,class_id\n"


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "line 1: '': must be t_us,object_id,left"),
        (b"a,b\n1,2\n", "line 1: 'a,b': must be t_us,object_id,left"),
        (HEADER.encode() + b"1,2,3\n", "line 2: 3 values: must be 11"),
        (HEADER.encode() + b"1,2,3,4,5,6,7,8,9,10,x\n", "could not convert string 'x' to float64"),
        (HEADER.encode() + b"1,0,3,4,5,6,7,8,1,0,0\n1,2\n", "the number of columns changed from 11 to 2"),
        (b"\xff\xfe\x00", "byte 0: must be UTF-8 text"),
    ],
)
def test_a_file_that_is_no_truth_is_refused(tmp_path: Path, content: bytes, message: str) -> None:
    path = tmp_path / "t.csv"
    path.write_bytes(content)
    with refused(RecordingError, start=f"{path}: {message}"):
        Truth.load(path)
    with pytest.raises(RecordingError, match=r"none\.csv: cannot be read: No such file"):
        Truth.load(tmp_path / "none.csv")


def test_a_file_without_classes_is_still_read(tmp_path: Path) -> None:
    (tmp_path / "old.csv").write_text(HEADER.replace(",class_id", "") + "5,2,10,20,4,6,7,8,1,0.25\n")
    samples = Truth.load(tmp_path / "old.csv").samples
    assert (samples["x"][0], samples["occluded"][0], samples["class_id"][0]) == (12.0, 0.25, ObjectClass.OBJECT)


def test_visible_objects_are_labelled_boxes() -> None:
    samples = np.zeros(4, TRUTH)
    samples["t_us"], samples["object_id"], samples["class_id"] = (0, 0, 9, 9), (0, 1, 0, 1), (1, 3, 1, 3)
    samples["x"], samples["y"], samples["width"], samples["height"] = 10.0, 20.0, 4.0, 6.0
    samples["visible"], samples["occluded"] = (1, 1, 0, 1), (0.0, 0.5, 0.0, 0.6)
    boxes = Truth(samples).labelled_boxes((30, 40))
    assert (boxes.instants_us.tolist(), boxes.sensor) == ([0, 9], (30, 40))
    assert boxes.rows[["instant", "id", "class_id", "left", "top", "counted"]].tolist() == [
        (0, 0, 1, 8.0, 17.0, True),
        (0, 1, 3, 8.0, 17.0, True),
        (1, 1, 3, 8.0, 17.0, False),
    ]
    assert boxes.class_names[ObjectClass.PERSON] == "person"


def box(number: int, left: float, top: float, width: float, height: float) -> NDArray[np.float64]:
    x = np.array([[left, left + width, left + width, left]])
    y = np.array([[top, top, top + height, top + height]])
    return quadrangles(number, x, y, 1.0)


def hidden(*shapes: NDArray[np.float64], sensor: tuple[int, int] = (100, 80)) -> list[float]:
    rows = np.concatenate(shapes)
    return [float(part) for part in hidden_parts(rows, np.unique(rows[:, 1]).astype(np.int64), *sensor)]


@pytest.mark.parametrize("x", np.arange(-25.0, 26.0, 2.5))
def test_two_boxes_that_cross(x: float) -> None:
    """The nearer, 12 by 30, passes before the farther, 20 by 20."""
    overlap = max(0.0, min(20.0, x + 12) - max(0.0, x))
    assert hidden(box(0, 30, 30, 20, 20), box(1, 30 + x, 25, 12, 30)) == [pytest.approx(overlap / 20, abs=1e-9), 0.0]


@pytest.mark.parametrize("y", np.arange(-25.0, 26.0, 1.7))
def test_two_boxes_that_cross_down_the_picture(y: float) -> None:
    overlap = max(0.0, min(20.0, y + 12) - max(0.0, y))
    parts = hidden(box(0, 30, 30, 20, 20), box(1, 25, 30 + y, 30, 12))
    assert parts == [pytest.approx(overlap / 20, abs=1 / 64), 0.0]


def test_the_order_says_who_is_nearer() -> None:
    assert hidden(box(1, 35, 30, 20, 20), box(0, 30, 30, 20, 20)) == [0.0, pytest.approx(0.75)]


def test_what_hides_twice_counts_once_and_an_object_does_not_hide_itself() -> None:
    parts = hidden(box(0, 30, 30, 20, 20), box(0, 35, 30, 25, 20), box(1, 30, 30, 10, 20), box(2, 35, 30, 10, 20))
    assert parts == [pytest.approx(0.5), pytest.approx(0.5), 0.0]


def test_what_lies_outside_the_sensor_is_hidden() -> None:
    assert hidden(box(0, -10.5, 30, 20, 20)) == [pytest.approx(0.5)]
    assert hidden(box(0, 94.5, 30, 20, 20)) == [pytest.approx(0.75)]
    assert hidden(box(0, 30, 69.5, 20, 20)) == [pytest.approx(0.5, abs=0.008)]
    assert hidden(box(0, 130, 30, 20, 20)) == [1.0]
    # A nearer one that is outside as well hides nothing more.
    assert hidden(box(0, -10.5, 30, 20, 20), box(1, -20.5, 30, 20, 20)) == [pytest.approx(0.5), 1.0]


def test_discs_hide_by_the_area_of_the_lens() -> None:
    radius = 12.0
    for distance in (0.0, 4.0, 12.0, 20.0, 24.0):
        lens = 2 * radius**2 * np.arccos(distance / (2 * radius)) - distance / 2 * np.sqrt(4 * radius**2 - distance**2)
        parts = hidden(discs([0, 1], [40.0, 40.0 + distance * 0.6], [40.0, 40.0 + distance * 0.8], radius, 1.0))
        assert parts == [pytest.approx(lens / (np.pi * radius**2), abs=0.01), 0.0]


def test_an_object_without_shapes_is_hidden() -> None:
    assert hidden_parts(box(0, 30, 30, 20, 20), np.array([0, 5]), 100, 80).tolist() == [0.0, 1.0]

# SPDX-License-Identifier: Apache-2.0
"""A box follows its waypoints."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from evcot.errors import RecordingError
from evcot.scenes.truth import TRUTH, Box, Truth, sample

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
    assert samples.dtype.names == ("t_us", "object_id", "x", "y", "width", "height", "vx", "vy", "visible", "occluded")


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
    assert path.read_text().splitlines()[0] == "t_us,object_id,left,top,width,height,vx,vy,visible,occluded"
    assert path.read_text().splitlines()[1] == "0,0,-5.0000,4.0000,4.0000,2.0000,0.000,0.000,0,1.0000"
    loaded = Truth.load(path).samples
    assert loaded.dtype == TRUTH
    for name in ("t_us", "object_id", "visible"):
        np.testing.assert_array_equal(loaded[name], samples[name])
    for name in ("x", "y", "width", "height", "vx", "vy", "occluded"):
        np.testing.assert_allclose(loaded[name], samples[name], atol=1e-3)
    assert [entry.name for entry in tmp_path.iterdir()] == ["story.truth.csv"]


def test_truth_without_objects_survives_a_file_too(tmp_path: Path) -> None:
    Truth(np.empty(0, TRUTH)).save(tmp_path / "t.csv")
    assert len(Truth.load(tmp_path / "t.csv").samples) == 0


HEADER = "t_us,object_id,left,top,width,height,vx,vy,visible,occluded\n"


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "line 1: '': must be t_us,object_id,left"),
        (b"a,b\n1,2\n", "line 1: 'a,b': must be t_us,object_id,left"),
        (HEADER.encode() + b"1,2,3\n", "line 2: 3 values: must be 10"),
        (HEADER.encode() + b"1,2,3,4,5,6,7,8,9,x\n", "could not convert string 'x' to float64"),
        (HEADER.encode() + b"1,0,3,4,5,6,7,8,1,0\n1,2\n", "the number of columns changed from 10 to 2"),
        (b"\xff\xfe\x00", "byte 0: must be UTF-8 text"),
    ],
)
def test_a_file_that_is_no_truth_is_refused(tmp_path: Path, content: bytes, message: str) -> None:
    path = tmp_path / "t.csv"
    path.write_bytes(content)
    with pytest.raises(RecordingError) as caught:
        Truth.load(path)
    assert str(caught.value).startswith(f"{path}: {message}")
    with pytest.raises(RecordingError, match=r"none\.csv: cannot be read: No such file"):
        Truth.load(tmp_path / "none.csv")

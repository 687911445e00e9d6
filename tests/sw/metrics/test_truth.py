# SPDX-License-Identifier: Apache-2.0
"""A ground truth is read according to its rule, or refused with line and field."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from evcot.errors import ConfigError, EvcotError, RecordingError
from evcot.metrics import Rule, load_rule, read_truth
from evcot.metrics.truth import rule_for
from evcot.scenes.registry import SCENES, scene_settings
from evcot.tracks.formats.base import FrameClock
from support.refusals import refused

HEADER = "t_begin_us,t_end_us,who,left,top,width,height"
RULE = Rule({"id": "who", **{name: name for name in ("t_begin_us", "t_end_us", "left", "top", "width", "height")}}, at_us=-10)


def written(folder: Path, *lines: str, header: str = HEADER) -> Path:
    path = folder / "truth.csv"
    path.write_text("\n".join((header, *lines)) + "\n")
    return path


def test_boxes_become_centres_at_instants(tmp_path: Path) -> None:
    path = written(tmp_path, "100,150,b,0,0,4,6", "50,99,a,10,20,2,2", "100,150,a,11,20,2,2")
    truth = read_truth(path, RULE)
    np.testing.assert_array_equal(truth.instants_us, [89, 140])
    assert truth.ids == ("b", "a")
    np.testing.assert_array_equal(truth.objects["frame"], [0, 1, 1])
    np.testing.assert_array_equal(truth.objects["object"], [1, 0, 1])
    np.testing.assert_array_equal(truth.objects["x"], [11, 2, 12])
    np.testing.assert_array_equal(truth.objects["y"], [21, 3, 21])
    assert np.isnan(truth.objects["vx"]).all()
    assert truth.objects["counted"].all()


def test_boxes_are_clipped_to_the_sensor_and_moved_to_the_camera_s_clock(tmp_path: Path) -> None:
    path = written(tmp_path, "0,100,a,-10,250,20,20", "0,100,b,400,0,5,5")
    rule = replace(RULE, clip=True, edge_px=0.0, sensor=(346, 260), origin_us=1_718_925_184_590_631)
    truth = read_truth(path, rule)
    assert truth.objects[["object", "x", "y", "width", "height"]].tolist() == [(0, 5.0, 255.0, 10.0, 10.0)]
    np.testing.assert_array_equal(truth.instants_us, [1_718_925_184_590_721])


def test_a_point_is_a_square_of_its_reach(tmp_path: Path) -> None:
    rule = Rule({"id": "id", "t_us": "t", "x": "u", "y": "v"}, reach_px=10.0)
    objects = read_truth(written(tmp_path, "5,7,1.5,2.5", header="t,id,u,v"), rule).objects
    assert (objects["x"][0], objects["y"][0]) == (1.5, 2.5)
    assert np.hypot(objects["width"][0], objects["height"][0]) / 2 == pytest.approx(10.0)


def test_what_does_not_count_is_marked_and_stays(tmp_path: Path) -> None:
    path = written(tmp_path, "0,9,a,0,0,1,1,0.5", "0,9,b,0,0,1,1,0.51", header=HEADER + ",hidden")
    objects = read_truth(path, replace(RULE, at_us=0, counted={"hidden": (0, 0.5)})).objects
    np.testing.assert_array_equal(objects["counted"], [True, False])


def test_a_scene_is_read_as_it_was_written(tmp_path: Path) -> None:
    scene = SCENES["boxes"].simulate(scene_settings("boxes", 1, {"duration_us": 50_000}))
    scene.truth.save(tmp_path / "truth.csv")
    truth, samples = read_truth(tmp_path / "truth.csv", load_rule("scene")), scene.truth.samples
    np.testing.assert_array_equal(truth.instants_us[truth.objects["frame"]], samples["t_us"])
    np.testing.assert_array_equal(np.array(truth.ids, int)[truth.objects["object"]], samples["object_id"])
    for name in ("x", "y", "width", "height", "vx", "vy"):
        np.testing.assert_allclose(truth.objects[name], samples[name], atol=2e-3)
    np.testing.assert_array_equal(truth.objects["counted"], samples["visible"] & (samples["occluded"] <= 0.5))


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ((), "has no line after the header: must have one line an object"),
        (("0,100,a,0,0,1",), "line 2: 6 values: must be 7, as the header"),
        (("0,100,a,0,0,1,1", "0,100,b,0,zero,1,1"), "line 3: top = 'zero': must be a number"),
        (("0,100,a,nan,0,1,1",), "line 2: left = 'nan': must be a number"),
        (("0,100,a,1e300,0,1,1",), "line 2: left = '1e300': must be a number"),
        (("0,1e2,a,0,0,1,1",), "line 2: t_end_us = '1e2': must be an integer, microseconds, of at most 2^60"),
        (("0,9999999999999999999,a,0,0,1,1",), "line 2: t_end_us = '9999999999999999999': must be an integer, "),
        (("95,100,a,0,0,1,1",), "line 2: t_begin_us = '95': must hold the instant, t_end_us - 10"),
        (('0,100,a,0,0,1,"1\n2"',), "line 3: height = '1\\n2': must be a number"),
        (("0,100,a,0,0,0,1",), "line 2: width = '0': must be at least 0.001"),
        (("0,100,a,0,0,1,1", "0,100,b,0,0,1,1", "0,100,a,5,5,1,1"), "line 4: who = 'a': must not occur twice at one time"),
    ],
)
def test_a_line_that_is_wrong_is_named(lines: tuple[str, ...], message: str, tmp_path: Path) -> None:
    path = written(tmp_path, *lines)
    with refused(RecordingError, start=f"{path}: {message}"):
        read_truth(path, RULE)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (None, "cannot be read: No such file or directory"),
        (b"", "has no header: must have one line an object"),
        (b"a,b\n\xff,1\n", "is no text, at byte 4: must be a truth as CSV, or a file of boxes"),
        (b'a,b\n"' + b"x" * 200_000 + b'",2\n', "line 2: is no CSV: "),
        (b"t_us,id\n1,2\n", "line 1: 't_us,id': must have one column 'left' (the rule's `columns`)"),
    ],
)
def test_a_file_that_is_no_truth_is_named(content: bytes | None, message: str, tmp_path: Path) -> None:
    path = tmp_path / "truth.csv"
    if content is not None:
        path.write_bytes(content)
    with refused(RecordingError, start=f"{path}: {message}"):
        read_truth(path, RULE)


MOT = ["1,1,1,1,10,20,1,1,1", "1,2,30,1,10,20,0,1,1", "3,1,5,1,10,20,1,1,0.2"]


def boxes_file(folder: Path, *lines: str) -> Path:
    path = folder / "gt.txt"
    path.write_text("".join(f"{line}\n" for line in lines))
    return path


def test_a_truth_of_boxes_has_every_frame_and_its_flags(tmp_path: Path) -> None:
    truth = read_truth(boxes_file(tmp_path, *MOT), load_rule("boxes"), clock=FrameClock(40_000, 500))
    assert truth.instants_us.tolist() == [500, 40_500, 80_500]
    assert truth.ids == ("1", "2")
    assert truth.objects[["frame", "object", "x", "y", "counted"]].tolist() == [
        (0, 0, 4.5, 9.5, True),
        (0, 1, 33.5, 9.5, False),
        (2, 0, 8.5, 9.5, True),
    ]
    assert np.isnan(truth.objects["vx"]).all()
    rule = replace(load_rule("boxes"), at_us=-100, origin_us=7, counted={"visibility": (0.5, 1)})
    later = read_truth(boxes_file(tmp_path, *MOT), rule, clock=FrameClock(40_000, 500))
    assert later.instants_us.tolist() == [407, 40_407, 80_407]
    assert later.objects["counted"].tolist() == [True, False, False]


def test_a_truth_of_boxes_that_says_nothing_is_refused(tmp_path: Path) -> None:
    rule, clock = load_rule("boxes"), FrameClock(40_000)
    far = "1,1,400,1,2,2,1,1,1"
    off = "line 2: x = 399.5, width = 2: must reach the sensor's 346x260 pixels"
    for message, lines, own in (
        ("no box counts: must have one at least that is to be found", (), rule),
        ("no box counts: must have one at least that is to be found", ("1,1,1,1,2,2,0,1,1",), rule),
        ("line 1: id = -1: must be an object's: detections are no truth", ("1,-1,1,1,2,2,1,1,1",), rule),
        (off, ("1,2,1,1,2,2,1,1,1", far), rule.on((346, 260))),
    ):
        path = boxes_file(tmp_path, *lines)
        with refused(EvcotError, f"{path}: {message}"):
            read_truth(path, own, clock=clock)
    clipped = read_truth(
        boxes_file(tmp_path, MOT[0], far.replace("1,1,", "1,3,", 1)), replace(rule, clip=True, sensor=(346, 260)), clock=clock
    )
    assert clipped.objects["object"].tolist() == [0]
    uncounted = boxes_file(tmp_path, MOT[0], "1,3,400,1,2,2,0,1,1")
    assert read_truth(uncounted, rule.on((346, 260)), clock=clock).objects["counted"].tolist() == [True, False]
    path = tmp_path / "boxes.csv"
    path.write_text("a\n1\n")
    with refused(ConfigError, f"{path}: the rule has no columns: must have those of a CSV file"):
        read_truth(path, rule)
    with refused(ConfigError, "counted.size: must be one of confidence, class, visibility with a file of boxes"):
        read_truth(boxes_file(tmp_path, *MOT), replace(rule, counted={"size": (0, 1)}), clock=clock)


def test_a_box_off_the_sensor_is_refused_in_csv_too(tmp_path: Path) -> None:
    path = written(tmp_path, "0,100,a,0,0,5,5", "0,100,b,400,0,5,5")
    with pytest.raises(RecordingError, match=r"line 3: x = 402\.5, width = 5: must reach the sensor's 346x260 pixels$"):
        read_truth(path, RULE.on((346, 260)))


def test_classes_are_those_of_the_column_or_unknown(tmp_path: Path) -> None:
    header = "t_us,object_id,left,top,width,height,vx,vy,visible,occluded"
    path = tmp_path / "truth.csv"
    for classes, wanted in ((("", ""), [-1, -1]), ((",2", ",7"), [2, 7])):
        name = ",class_id" if classes[0] else ""
        path.write_text(f"{header}{name}\n5,0,1,2,3,4,0,0,1,0{classes[0]}\n9,0,1,2,3,4,0,0,1,0{classes[1]}\n")
        rule = rule_for(path)
        assert rule == load_rule("scene")
        assert read_truth(path, rule).objects["class_id"].tolist() == wanted
    path.write_text(f"{header},class_id\n5,0,1,2,3,4,0,0,1,0,1.5\n")
    with pytest.raises(RecordingError, match=r"line 2: class_id = '1\.5': must be a class's number, an integer"):
        read_truth(path, load_rule("scene"))

# SPDX-License-Identifier: Apache-2.0
"""Rules are data: built-in ones load, others override them, and contradictions are refused by field name."""

from __future__ import annotations

from pathlib import Path

import pytest

from evcot.errors import ConfigError
from evcot.metrics import RULES, Rule, load_rule

BOXES = {"id": "id", "t_us": "t", "left": "l", "top": "t", "width": "w", "height": "h"}
POINTS = {"id": "id", "t_us": "t", "x": "x", "y": "y"}


def test_every_shipped_rule_loads_and_says_what_it_is_for() -> None:
    assert RULES == ("boxes", "scene", "traffic")
    assert all(load_rule(name).title for name in RULES)


def test_the_rule_of_the_traffic_recording() -> None:
    rule = load_rule("traffic")
    assert (rule.at_us, rule.max_age_us, rule.similarity, rule.threshold) == (-15_000, 60_000, "centre", 0.5)
    assert (rule.clip, rule.sensor, rule.edge_px) == (True, (346, 260), 0.0)
    assert rule.ignore == {"top": 28, "left": 10, "right": 10, "bottom": 10}


def test_a_file_overrides_a_shipped_rule(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text('base = "traffic"\nsimilarity = "iou"\nsensor = [640, 480]\n')
    rule = load_rule(path)
    assert (rule.similarity, rule.sensor, rule.at_us) == ("iou", (640, 480), -15_000)
    assert rule.on((10, 20)).size() == (10, 20)
    assert rule.on(None).size() == (640, 480)


def test_a_sensor_that_nobody_said_is_asked_for() -> None:
    with pytest.raises(ConfigError, match=r"^sensor: must be given \(--sensor WxH"):
        Rule(BOXES).size()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("threshold = ", "is not TOML: "),
        ("threshold = 0.5", "columns: must be given"),
        ('base = "drive"', "base = 'drive': must be one of boxes, scene, traffic"),
        ('base = ["scene"]', "base = ['scene']: must be one of boxes, scene, traffic"),
        ('base = "scene"\nmax_age = 1', "rule: unknown field 'max_age': must be one of columns, title, "),
        ('base = "scene"\nmax_age_us = -1', "max_age_us = -1: must be from 0 to 1000000000000 (age past which"),
        ('base = "scene"\nmax_age_us = 1.5', "max_age_us = 1.5: must be from 0 to "),
        ('base = "scene"\nat_us = true', "at_us = True: must be from "),
        ('base = "scene"\nthreshold = nan', "threshold = nan: must be from 0 to 1 "),
        ('base = "scene"\nthreshold = "1"', "threshold = '1': must be from 0 to 1 "),
        ('base = "scene"\nsimilarity = "giou"', "similarity = 'giou': must be one of centre, iou"),
        ('base = "scene"\nclip = 1', "clip = 1: must be true or false"),
        ('base = "scene"\ntitle = 1', "title = 1: must be text"),
        ('base = "scene"\nreach_px = 3.0', "reach_px = 3.0: must be given for points alone"),
        ('base = "scene"\nsensor = [346]', "sensor = [346]: must be [width, height], each from 1 to 65536"),
        ('base = "scene"\nsensor = [0, 5]', "sensor = [0, 5]: must be [width, height], each from 1 to 65536"),
        ('base = "scene"\nignore = 3', "ignore = 3: must be a table"),
        ('base = "scene"\n[ignore]\nnorth = 3', "ignore: unknown field 'north': must be one of left, top, right, bottom"),
        ('base = "scene"\n[ignore]\ntop = -3', "ignore.top = -3: must be from 0 to "),
        ('base = "scene"\n[counted]\noccluded = [1, 0]', "counted.occluded = [1, 0]: must be [lowest, highest]"),
        ('base = "scene"\n[columns]\nid = 3', "columns.id = 3: must be a column's name"),
        ('base = "scene"\n[columns]\nwho = "id"', "columns: unknown field 'who': must be one of id, "),
    ],
)
def test_a_file_that_is_no_rule_is_refused_by_name(text: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "rule.toml"
    path.write_text(text)
    with pytest.raises(ConfigError) as caught:
        load_rule(path)
    assert str(caught.value).startswith(f"{path}: {message}")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("columns", "rule"),
    [
        ({**BOXES, "x": "x", "y": "y"}, "left + top + width + height or x + y"),
        ({"id": "id", "t_us": "t", "left": "l"}, "left + top + width + height or x + y"),
        ({**BOXES, "t_end_us": "e"}, "t_us or t_begin_us + t_end_us"),
        ({name: column for name, column in BOXES.items() if name != "id"}, "id"),
    ],
)
def test_columns_say_one_thing(columns: dict[str, str], rule: str) -> None:
    with pytest.raises(ConfigError) as caught:
        Rule(columns)
    assert str(caught.value).endswith(f": must have {rule}")


def test_velocity_needs_both_axes() -> None:
    with pytest.raises(ConfigError, match=r"^columns vx, vy: must be given both, or neither$"):
        Rule({**BOXES, "vx": "vx"})


def test_points_need_a_reach_and_have_no_area() -> None:
    with pytest.raises(ConfigError, match=r"^reach_px = None: must be from 0.01 to 1e\+06 "):
        Rule(POINTS)
    with pytest.raises(ConfigError, match=r"^columns x, y: points must have similarity 'centre' and no clip$"):
        Rule(POINTS, reach_px=5.0, similarity="iou")


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("drive", "rule 'drive': must be one of boxes, scene, traffic, or a .toml file"),
        ("none.toml", "none.toml: cannot be read: No such file or directory"),
    ],
)
def test_a_rule_that_is_not_there_is_named(name: str, message: str) -> None:
    with pytest.raises(ConfigError) as caught:
        load_rule(name)
    assert str(caught.value) == message

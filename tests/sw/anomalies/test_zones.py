# SPDX-License-Identifier: Apache-2.0
"""Zones files."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from evcot.anomalies import Zones, load_zones
from evcot.anomalies.zones import Line, Zone, crossings, inside
from evcot.errors import ConfigError
from support.refusals import refused

SQUARE = [[2, 2], [6, 2], [6, 6], [2, 6]]
DART = [[0, 0], [8, 0], [4, 2], [8, 8]]  # not convex


def test_a_polygon_holds_its_inside_and_its_border_and_nothing_else() -> None:
    y, x = (axis.ravel() for axis in np.mgrid[0:9, 0:9])
    held = inside(SQUARE, x, y)
    np.testing.assert_array_equal(held, (x >= 2) & (x <= 6) & (y >= 2) & (y <= 6))
    np.testing.assert_array_equal(inside(SQUARE[::-1], x, y), held)  # either way round
    assert inside(DART, [4, 4, 5, 7, 6, 4, 8], [1, 2, 2, 1, 1, 3, 8]).tolist() == [True, True, False, False, True, True, True]
    # Points level with the left and right corners of a diamond: a ray through a corner counts once.
    diamond, wedge = [[4, 0], [8, 4], [4, 8], [0, 4]], [[0, 0], [8, 4], [0, 8]]
    assert inside(diamond, [-1, 0, 1, 4, 8, 9], [4] * 6).tolist() == [False, True, True, True, True, False]
    assert inside(wedge, [4, 4.5, 4], [2, 2, 1.5]).tolist() == [True, False, False], "half pixels next to a slanted border"
    assert inside(SQUARE, [], []).shape == (0,)


def test_polygons_against_a_count_of_windings() -> None:
    """Random triangles and points on a grid: inside where the point is on the same side of all edges, or on one."""
    random = np.random.default_rng(2)
    y, x = (axis.ravel() for axis in np.mgrid[0:12, 0:12])
    compared = 0
    for _ in range(200):
        corners = random.integers(0, 12, (3, 2)).astype(float)
        (ax, ay), (bx, by), (cx, cy) = corners
        sides = np.array(
            [(qx - px) * (y - py) - (qy - py) * (x - px) for px, py, qx, qy in
             ((ax, ay, bx, by), (bx, by, cx, cy), (cx, cy, ax, ay))]
        )  # fmt: skip
        if (bx - ax) * (cy - ay) == (by - ay) * (cx - ax):
            continue
        np.testing.assert_array_equal(inside(corners, x, y), (sides >= 0).all(axis=0) | (sides <= 0).all(axis=0))
        compared += 1
    assert compared > 150


def test_crossings_have_a_direction_and_the_line_itself_is_on_its_left() -> None:
    """A line that points to the right of the picture has the lower part of the picture on its right side."""
    for x, y, expected in (
        ([3, 3], [4, 6], [1]),
        ([3, 3], [6, 4], [-1]),
        ([3, 3], [4.98, 5.02], [1]),
        ([3, 3], [5.02, 4.98], [-1]),
        ([3, 3, 3], [4, 5, 6], [0, 1]),
        ([3, 3, 3], [6, 5, 4], [-1, 0]),
        ([3, 3, 3], [4, 5, 4], [0, 0]),
        ([12, 12], [4, 6], [0]),
        ([1, 8], [4, 4], [0]),
        ([], [], []),
    ):
        assert crossings([0, 5, 10, 5], x, y).tolist() == expected


def test_a_step_through_the_joint_of_two_lines_crosses_one_of_them() -> None:
    for joint in ([[0, 5, 4, 5], [4, 5, 9, 5]], [[0, 3, 4, 5], [4, 5, 9, 3]]):
        for x, y in (([4, 4], [0, 9]), ([2, 6], [0, 10]), ([6, 2], [0, 10])):
            assert sum(crossings(line, x, y)[0] for line in joint) == 1
            assert sum(crossings(line, x[::-1], y[::-1])[0] for line in joint) == -1


DOCS = Path(__file__).parents[3] / "docs" / "anomalies.md"


def example() -> str:
    found = re.search(r"```toml\n(.*?)```", DOCS.read_text(encoding="utf-8"), re.DOTALL)
    assert found
    return found[1]


def zones_of(folder: Path, text: str) -> Zones:
    path = folder / "zones.toml"
    path.write_text(text, encoding="utf-8")
    return load_zones(path)


def test_the_example_of_the_documentation(tmp_path: Path) -> None:
    zones = zones_of(tmp_path, example())
    assert zones == Zones(
        (
            Zone("shoulder", ((229.0, 20.0), (346.0, 150.0), (346.0, 100.0), (250.0, 20.0))),
            Zone("bay", ((0.0, 120.0), (30.0, 120.0), (30.0, 160.0), (0.0, 160.0)), 2_000_000),
        ),
        (Line("gate", (0.0, 130.0), (345.0, 130.0), -1),),
        (346, 260),
    )
    corners, starts = zones.corners()
    assert (corners.shape, starts.tolist()) == ((8, 2), [0, 4, 8])


ZONE = '[[zone]]\nname = "a"\nkind = "forbidden"\npolygon = [[0, 0], [9, 0], [0, 9]]\n'
LINE = '[[line]]\nname = "l"\nbegin = [0, 0]\nend = [9, 9]\n'


def test_what_is_not_said_is_the_usual(tmp_path: Path) -> None:
    assert zones_of(tmp_path, LINE) == Zones(lines=(Line("l", (0.0, 0.0), (9.0, 9.0), 0),))
    assert zones_of(tmp_path, ZONE).sensor is None


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "zone, line: must have one at least"),
        ("zone = 3", "zone: must be tables [[zone]]"),
        ("[[zone", "is not TOML: "),
        ("sensor = [346]\n" + ZONE, "sensor = [346]: must be [width, height], each from 1 to 65536"),
        ("area = 1\n" + ZONE, "zones: unknown field 'area': must be one of sensor, zone, line"),
        (ZONE + ZONE, "name = 'a': must be unique among zones and lines"),
        (ZONE + LINE.replace('"l"', '"a"'), "name = 'a': must be unique among zones and lines"),
        (ZONE.replace('"a"', '""'), "zone[0].name = '': must be a text of one line"),
        (ZONE.replace('"forbidden"', '"lawn"'), "zone[0].kind = 'lawn': must be one of forbidden, dwell"),
        (ZONE.replace('"forbidden"', '"dwell"'), "zone[0].dwell_us = None: must be an integer from 1 to"),
        (ZONE.replace('"forbidden"', '"dwell"') + "dwell_us = 0", "zone[0].dwell_us = 0: must be an integer from 1 to"),
        (ZONE + "dwell_us = 5", "zone[0]: unknown field 'dwell_us': must be one of name, kind, polygon"),
        (ZONE.replace(", [0, 9]]", "]"), "zone[0].polygon: must have from 3 to 10000 corners [x, y]"),
        (ZONE.replace("[0, 9]", "[0, inf]"), "zone[0].polygon[2] = [0, inf]: must be [x, y], each from -1e+06 to 1e+06"),
        (ZONE.replace("[0, 9]", "[true, 9]"), "zone[0].polygon[2] = [True, 9]: must be [x, y]"),
        (LINE.replace("[9, 9]", "[0, 0]"), "line[0].end = [0.0, 0.0]: must be another point than begin"),
        (LINE.replace("end = [9, 9]", ""), "line[0].end = None: must be [x, y]"),
        (LINE + 'allowed = "up"', "line[0].allowed = 'up': must be one of both, to_right, to_left"),
        (LINE + "allowed = [1]", "line[0].allowed = [1]: must be one of both, to_right, to_left"),
    ],
)
def test_what_makes_no_zone_is_named(tmp_path: Path, text: str, message: str) -> None:
    with refused(ConfigError, start=f"{tmp_path / 'zones.toml'}: {message}"):
        zones_of(tmp_path, text)


def test_a_file_that_cannot_be_read_is_named(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"none.toml: cannot be read: No such file"):
        load_zones(tmp_path / "none.toml")
    (tmp_path / "bytes.toml").write_bytes(b"\xff\xfe")
    with pytest.raises(ConfigError, match="is not TOML"):
        load_zones(tmp_path / "bytes.toml")

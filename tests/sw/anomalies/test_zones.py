# SPDX-License-Identifier: Apache-2.0
"""Zones files."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from evcot.anomalies import Zones, load_zones
from evcot.anomalies.zones import Line, Zone
from evcot.errors import ConfigError

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
    with pytest.raises(ConfigError) as caught:
        zones_of(tmp_path, text)
    assert str(caught.value).startswith(f"{tmp_path / 'zones.toml'}: {message}")
    assert "\n" not in str(caught.value)


def test_a_file_that_cannot_be_read_is_named(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"none.toml: cannot be read: No such file"):
        load_zones(tmp_path / "none.toml")
    (tmp_path / "bytes.toml").write_bytes(b"\xff\xfe")
    with pytest.raises(ConfigError, match="is not TOML"):
        load_zones(tmp_path / "bytes.toml")

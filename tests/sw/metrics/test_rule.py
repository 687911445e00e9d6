# SPDX-License-Identifier: Apache-2.0
"""Rules are data: built-in ones load, others override them, and contradictions are refused by field name."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from evcot.errors import ConfigError, TrackLogError
from evcot.metrics import RULES, Rule, load_rule
from evcot.metrics.sampling import checked, checked_runs, positions, positions_around
from evcot.tracks.log import Kind, TrackLog
from evcot.tracks.log_parts import sampled
from evcot.tracks.timeline import expiring, sample
from support.refusals import refused

from .test_evaluate import logged

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
    with refused(ConfigError, start=f"{path}: {message}"):
        load_rule(path)


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


def test_points_need_a_reach_and_have_no_area_and_velocity_needs_both_axes() -> None:
    with pytest.raises(ConfigError, match=r"^reach_px = None: must be from 0.01 to 1e\+06 "):
        Rule(POINTS)
    with refused(ConfigError, "columns x, y: points must have similarity 'centre' and no clip"):
        Rule(POINTS, reach_px=5.0, similarity="iou")
    with refused(ConfigError, "columns vx, vy: must be given both, or neither"):
        Rule({**BOXES, "vx": "vx"})


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("drive", "rule 'drive': must be one of boxes, scene, traffic, or a .toml file"),
        ("none.toml", "none.toml: cannot be read: No such file or directory"),
    ],
)
def test_a_rule_that_is_not_there_is_named(name: str, message: str) -> None:
    with refused(ConfigError, message):
        load_rule(name)


BORN, MOVED, MERGED, LOST = Kind


@pytest.fixture
def log() -> TrackLog:
    return logged(
        (100, 7, BORN, 1.0, 10.0),
        (120, 9, BORN, 5.0, 50.0),
        (130, 7, MOVED, 2.0, 20.0),
        (135, 9, MERGED, 5.0, 50.0),
        (190, 7, MOVED, 3.0, 30.0),
        (240, 7, LOST, 3.0, 30.0),
    )


def seen(log: TrackLog, *times_us: int) -> list[list[tuple[int, float]]]:
    rows = sample(log, np.array(times_us))
    return [rows[rows["sample"] == i][["track_id", "x"]].tolist() for i in range(len(times_us))]


def test_the_newest_state_holds_until_the_next_or_the_end(log: TrackLog) -> None:
    got = seen(expiring(log, 1_000), 99, 100, 134, 135, 189, 190, 239, 240)
    assert got == [[], [(7, 1.0)], [(7, 2.0), (9, 5.0)], [(7, 2.0)], [(7, 2.0)], [(7, 3.0)], [(7, 3.0)], []]


def test_a_state_may_be_just_so_old_and_the_track_comes_back_with_its_next(log: TrackLog) -> None:
    got = seen(expiring(log, 20), 120, 121, 150, 151, 189, 190, 210, 211)
    assert got == [[(7, 1.0), (9, 5.0)], [(9, 5.0)], [(7, 2.0)], [], [], [(7, 3.0)], [(7, 3.0)], []]


def test_a_state_that_follows_at_the_very_end_of_the_age_goes_on_and_the_last_gets_old_too(log: TrackLog) -> None:
    assert seen(expiring(log, 29), 129, 130) == [[(7, 1.0), (9, 5.0)], [(7, 2.0), (9, 5.0)]]
    assert seen(expiring(log, 30), 130, 131) == [[(7, 2.0), (9, 5.0)], [(7, 2.0), (9, 5.0)]]
    assert seen(expiring(logged((0, 1, BORN, 4.0, 4.0)), 60), 60, 61) == [[(1, 4.0)], []]


def test_places_of_tracks_at_any_times(log: TrackLog) -> None:
    ids, times_us = np.array([7, 9, 7, 8]), np.array([[99, 100], [119, 134], [239, 240], [100, 200]])
    x, y = positions(log, ids, times_us)
    np.testing.assert_array_equal(x, [[np.nan, 1.0], [np.nan, 5.0], [3.0, np.nan], [np.nan, np.nan]])
    np.testing.assert_array_equal(y, 10 * x)
    assert positions(log, ids[:0], times_us[:0])[0].shape == (0, 2)
    x, _ = positions(logged((5, 1, BORN, 4.0, 4.0)), np.array([1]), np.array([[4, 5, 10**9]]))
    np.testing.assert_array_equal(x, [[np.nan, 4.0, 4.0]])


def test_an_empty_log_has_no_outputs() -> None:
    assert seen(expiring(checked(TrackLog.empty("rct")), 60), 0, 1) == [[], []]
    assert np.isnan(positions(TrackLog.empty("rct"), np.array([1]), np.array([[0, 1]]))[0]).all()


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("t_us", 99, "record 1: t_us = 99: must not be before the record before it"),
        ("t_us", -(2**63), "record 1: t_us = -9223372036854775808: must be from -2^60 to 2^60"),
        ("kind", 4, "record 1: kind = 4: must be from 0 to 3"),
        ("x", np.nan, "record 1: x = nan: must be a number of at most 1e+09"),
        ("y", -1e300, "record 1: y = -1e+300: must be a number of at most 1e+09"),
        ("radius", np.inf, "record 1: radius = inf: must be a number of at most 1e+09"),
        ("vy", np.nan, "record 1: vy = nan: must be a number of at most 1e+09"),
        ("width", -0.5, "record 1: width = -0.5: must be a number from 0 to 1e+09"),
        ("height", np.nan, "record 1: height = nan: must be a number from 0 to 1e+09"),
        ("confidence", 1.01, "record 1: confidence = 1.01: must be a number from 0 to 1"),
    ],
)
def test_a_record_that_no_engine_writes_is_refused(log: TrackLog, field: str, value: float, message: str) -> None:
    log.records[field][1] = value
    with refused(TrackLogError, message):
        checked(log)


def busy(seed: int) -> TrackLog:
    """Few tracks, many records in the same microsecond, gaps longer than an age, ids that are born again."""
    rng = np.random.default_rng(seed)
    t_us = np.cumsum(rng.choice([0, 0, 1, 7, 60], 300)).tolist()
    ids, kinds = rng.integers(1, 5, 300).tolist(), rng.choice([BORN, MOVED, MOVED, MOVED, LOST, MERGED], 300).tolist()
    return logged(*((t, i, Kind(kind), float(n), 2.0 * n) for n, (t, i, kind) in enumerate(zip(t_us, ids, kinds, strict=True))))


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("run", [1, 3, 50, 400])
def test_a_log_in_runs_is_sampled_as_the_whole(seed: int, run: int, monkeypatch: pytest.MonkeyPatch) -> None:
    log, age_us = busy(seed), 40
    runs = [log.records[begin : begin + run] for begin in range(0, len(log.records), run)]
    times_us = np.arange(-5, log.records["t_us"][-1] + 100)
    whole = expiring(log, age_us)
    np.testing.assert_array_equal(sampled(runs, times_us, age_us), sample(whole, times_us))
    ids, offsets_us = np.arange(len(times_us)) % 6, np.array([3, -30, 0, 90])
    expected = positions(whole, ids, times_us[:, None] + offsets_us)
    for at_once in (1 << 16, 7):  # positions
        monkeypatch.setattr("evcot.metrics.sampling._AT_ONCE", at_once)
        found, known = np.full((2, *expected[0].shape), np.nan), np.zeros(expected[0].shape, int)
        for some in positions_around(runs, age_us, ids, times_us, offsets_us):
            known[some.rows] += some.there
            found[0, some.rows][some.there], found[1, some.rows][some.there] = some.x[some.there], some.y[some.there]
        assert known.max() == 1
        np.testing.assert_array_equal(found, expected)


def test_runs_are_checked_one_after_the_other(log: TrackLog) -> None:
    runs = [log.records[:2], log.records[2:2], log.records[2:]]
    assert sum(len(run) for run in checked_runs(runs)) == 6
    runs[2]["t_us"][0] = 119
    with pytest.raises(TrackLogError, match=r"^record 2: t_us = 119: must not be before the record before it$"):
        list(checked_runs(runs))

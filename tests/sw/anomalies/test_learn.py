# SPDX-License-Identifier: Apache-2.0
"""The field of normal motion: its values, its tolerance of outliers, and its files."""

from __future__ import annotations

import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.anomalies import ALARM, Anomaly, FieldConfig, NormalMotion, anomalies, learn
from evcot.anomalies.learn import smallest_sensor
from evcot.anomalies.score import score_alarms, truth_log
from evcot.errors import ConfigError, TrackLogError
from evcot.scenes import highway
from evcot.scenes.registry import scene_settings
from evcot.scenes.truth import TRUTH, Label, Truth, on_sensor
from evcot.tracks.log import Kind
from support.refusals import refused

from .roads import LANES_PX, SENSOR, away, log, still, straight, towards, track, traffic


def truth(*, labels: tuple[Label, ...] = ()) -> Truth:
    """Two boxes that stand for 10 s: 0 at (50, 50), 1 at (200, 100); 1 is hidden from 4 to 5 s."""
    samples = np.zeros((1000, 2), TRUTH)
    samples["t_us"] = np.arange(1000)[:, None] * 10_000
    samples["object_id"] = 0, 1
    samples["x"], samples["y"] = (50, 200), (50, 100)
    samples["width"], samples["height"], samples["visible"] = 20, 30, True
    samples["occluded"][400:500, 1] = 0.9
    return Truth(samples.ravel(), (), labels)


def alarm(t_us: int, kind: Anomaly, x: float, y: float) -> NDArray[np.void]:
    row = np.zeros(1, ALARM)
    row["t_us"], row["kind"], row["x"], row["y"] = t_us, kind, x, y
    return row


LABELS = (Label(0, "wrong_way", 2_000_000, 4_000_000), Label(1, "stopping", 6_000_000, 8_000_000))


def scored(*alarms: NDArray[np.void]) -> tuple[dict[str, int], dict[str, int], dict[str, list[float]]]:
    scores = score_alarms(np.concatenate(alarms), truth(labels=LABELS), 30_000_000)
    assert scores.minutes == 0.5
    assert sum(scores.found.values()) + len(scores.missed) == 2
    return scores.found, scores.false_alarms, scores.seconds_to_alarm


def test_an_alarm_of_the_kind_at_the_object_in_time_finds_it_and_of_another_is_not_false() -> None:
    found, false, seconds = scored(alarm(2_700_000, Anomaly.WRONG_WAY, 55, 60), alarm(3_000_000, Anomaly.WRONG_WAY, 55, 60))
    assert (found, false) == ({"stopping": 0, "wrong_way": 1}, {})
    assert seconds["wrong_way"] == [pytest.approx(0.7)]
    assert scored(alarm(2_700_000, Anomaly.PLACE, 55, 60))[:2] == ({"stopping": 0, "wrong_way": 0}, {})


@pytest.mark.parametrize(
    ("t_us", "x", "y"),
    [(1_900_000, 50, 50), (5_100_000, 50, 50), (2_500_000, 200, 100), (2_500_000, 75, 50), (2_500_000, 50, 78)],
)
def test_before_after_elsewhere_and_on_another_is_false(t_us: int, x: float, y: float) -> None:
    assert scored(alarm(t_us, Anomaly.WRONG_WAY, x, y))[:2] == ({"stopping": 0, "wrong_way": 0}, {"wrong_way": 1})


def test_shares_and_rates() -> None:
    scores = score_alarms(np.concatenate([alarm(100, Anomaly.FAST, 300, 200)] * 3), truth(labels=LABELS), 30_000_000)
    assert (scores.share_found, scores.false_per_minute, scores.false_rows) == (0.0, 6.0, [0, 1, 2])
    assert score_alarms(np.empty(0, ALARM), truth(), 1_000_000).share_found == 1.0


def test_the_truth_as_a_log_has_a_track_for_each_time_that_an_object_is_seen() -> None:
    records = truth_log(truth()).records
    born, lost = records[records["kind"] == Kind.BORN], records[records["kind"] == Kind.LOST]
    assert born["t_us"].tolist() == [0, 0, 5_000_000]
    assert sorted(lost["t_us"].tolist()) == [4_000_000, 10_000_000, 10_000_000]
    assert len(np.unique(records["track_id"])) == 3
    assert (np.diff(records["t_us"]) >= 0).all()
    assert set(records["radius"]) == {15.0}
    assert set(records[["width", "height"]].tolist()) == {(20.0, 30.0)}


def highway_truth(seed: int, seconds: int, **planted: int) -> Truth:
    """The truth of a highway without its picture, every 20 ms."""
    settings = scene_settings("highway", seed, {"duration_us": seconds * 10**6, "story": 0, "vehicles_per_s": 1.2, **planted})
    stage = highway._Stage(settings)
    moments = []
    for t_us in range(0, settings.duration_us, 20_000):
        objects = stage.objects(t_us)
        objects["t_us"] = t_us
        moments.append(objects)
    samples = np.concatenate(moments)
    samples["visible"] = on_sensor(samples, (settings.width, settings.height))
    return Truth(samples, (), stage.labels(samples))


def test_on_a_simulated_highway_all_planted_are_found_and_nothing_else() -> None:
    """The rules alone: the truth takes the tracker's place. Seeds 100, 101 and 103."""
    normal = learn([truth_log(highway_truth(100, 60))], (346, 260))
    kinds = dict.fromkeys(("wrong_way", "stopping", "crossing", "loitering", "speeding"), 2)
    for seed in (101, 103):
        planted = highway_truth(seed, 45, **kinds)
        alarms = anomalies(truth_log(planted), None, normal).alarms
        scores = score_alarms(alarms, planted, 45_000_000)
        assert scores.missed == []
        assert scores.false_alarms == {}
        assert scores.found == kinds
        assert max(scores.seconds_to_alarm["speeding"]) < 1.0
        assert max(scores.seconds_to_alarm["wrong_way"]) < 4.0
    ordinary = highway_truth(110, 30)
    assert len(anomalies(truth_log(ordinary), None, normal).alarms) == 0


COLUMN = int(LANES_PX[0] // 8)


def test_a_field_has_direction_speed_and_support_by_place() -> None:
    """Cars of the left lane at y px/s: the speed in a cell is its place."""
    field = learn([log(*traffic(30))], SENSOR).smoothed(0.5)
    for row in (5, 10, 20):
        at = row, COLUMN
        assert (field.x[at], field.y[at]) == (pytest.approx(0, abs=0.05), pytest.approx(-1, abs=0.01))
        assert field.concentration[at] > 0.98
        assert np.exp(field.log_speed[at]) == pytest.approx(8 * row + 3.5, rel=0.08)
        assert 0.1 <= field.deviation[at] < 0.15
        assert 3 < field.support[at] < 10  # of 10 tracks, shared with the cells beside
        assert field.near_speed[at] == pytest.approx(np.exp(field.log_speed[at]))
    nowhere = 20, (310 // 8)
    assert field.support[nowhere] == 0
    near, far = field.near_speed[20, (280 // 8)], field.near_speed[20, (340 // 8)]
    assert near == pytest.approx(164, rel=0.1)
    assert np.isnan(far)


def test_a_few_abnormal_tracks_do_not_change_what_is_normal() -> None:
    clean = learn([log(*traffic(30))], SENSOR).smoothed()
    wrong = [track(80 + i, 3_000_000 * i, 2_400_000, towards(LANES_PX[0])) for i in range(2)]
    fast = [track(90 + i, 3_000_000 * i, 1_000_000, away(LANES_PX[0], 2.2)) for i in range(2)]
    loiters = [track(95, 0, 20_000_000, still(100.0, 100.0), 0.5)]
    mixed = learn([log(*traffic(30), *wrong, *fast, *loiters)], SENSOR).smoothed()
    for row in (5, 10, 12, 20):
        at = row, COLUMN
        assert mixed.y[at] < -0.95
        assert mixed.concentration[at] > 0.95
        assert mixed.log_speed[at] == pytest.approx(clean.log_speed[at], abs=0.05)
        assert mixed.deviation[at] < 0.2


def test_where_both_ways_are_normal_there_is_no_direction() -> None:
    both = [track(50 + i, 900_000 * i, 2_400_000, (away, towards)[i % 2](LANES_PX[0])) for i in range(20)]
    assert learn([log(*both)], SENSOR).smoothed().concentration[10, COLUMN] < 0.3


def test_logs_add_up() -> None:
    first, second = log(*traffic(12)), log(*traffic(12))
    one, both = learn([first], SENSOR), learn([first, second], SENSOR)
    assert (one.tracks, both.tracks) == (12, 24)
    np.testing.assert_allclose(both.visits, 2 * one.visits)


def test_a_log_in_runs_teaches_what_the_whole_does(monkeypatch: pytest.MonkeyPatch) -> None:
    logs = [log(*traffic(12))]
    whole = learn(logs, SENSOR)
    monkeypatch.setattr("evcot.tracks.log._RUN", 37)
    monkeypatch.setattr(sys.modules[smallest_sensor.__module__], "_ROWS", 1)
    in_runs = learn(logs, SENSOR)
    assert in_runs.tracks == whole.tracks
    for name in ("visits", "ends", "turns"):
        np.testing.assert_array_equal(getattr(in_runs, name), getattr(whole, name))
    for name in ("x", "y", "log_speed", "log_speed_squared"):
        np.testing.assert_allclose(getattr(in_runs, name), getattr(whole, name), rtol=1e-12, atol=1e-12)


def test_the_smallest_sensor_is_taken_where_none_is_given() -> None:
    tracks = log(track(1, 0, 1_000_000, straight(10, 20, 40, 30)))
    assert smallest_sensor([tracks]) == (51, 51)
    normal = learn([tracks])
    assert normal.sensor == (51, 51)
    assert normal.visits.shape == (7, 7)


@pytest.mark.parametrize("tracks", [[], [track(1, 0, 100_000, still(50, 50))]])
def test_nothing_can_be_learned_of_nothing_or_of_what_no_engine_writes(tracks: list[np.ndarray]) -> None:
    with pytest.raises(ConfigError, match="learning: no track in the logs is long enough"):
        learn([log(*tracks)], SENSOR)
    bad = log(*traffic(3))
    bad.records["y"][7] = np.inf
    with pytest.raises(TrackLogError, match="record 7: y = inf"):
        learn([bad], SENSOR)


def test_a_field_comes_back_from_its_file_and_equal_fields_give_equal_bytes(tmp_path: Path) -> None:
    normal = learn([log(*traffic(9))], SENSOR, FieldConfig(10, 0.5))
    normal.save(tmp_path / "a.npz")
    back = NormalMotion.load(tmp_path / "a.npz")
    back.save(tmp_path / "b.npz")
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()
    assert (back.sensor, back.config, back.measured, back.tracks) == (SENSOR, FieldConfig(10, 0.5), normal.measured, 9)
    np.testing.assert_array_equal(back.visits, normal.visits)
    assert back.visits.shape == (26, 35)


def stored(path: Path) -> dict[str, np.ndarray]:
    with np.load(path) as content:
        return {name: content[name] for name in content.files}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"format": np.array(2)}, "format = [2]: must be from 1 to 1"),
        ({"sensor": np.array([0, 260])}, "sensor = [0, 260]: must be from 1 to 65536"),
        ({"sensor": np.array([346, 65536])}, "visits is float64 of shape (33, 44): must be float64 of shape (8192, 44)"),
        ({"tracks": np.array(1.5)}, "tracks is float64 of shape (): must be int64 of shape ()"),
        ({"cell_px": np.array(8.5)}, "cell_px = 8.5: must be an integer"),
        ({"cell_px": np.array(np.nan)}, "cell_px = nan: must be an integer"),
        ({"cell_px": np.array(0.0)}, "field.cell_px = 0: must be from 1 to 1024 (side of a cell)"),
        ({"smooth_cells": np.array(-1.0)}, "field.smooth_cells = -1.0: must be from 0 to 100"),
        ({"x": np.full((33, 44), np.nan)}, "x[0, 0] = nan: must be a number"),
        ({"visits": np.full((33, 44), -1.0)}, "visits[0, 0] = -1.0: must be a number"),
    ],
)
def test_files_that_hold_no_field_are_refused(tmp_path: Path, change: dict[str, np.ndarray], message: str) -> None:
    path = tmp_path / "normal.npz"
    learn([log(*traffic(3))], SENSOR).save(path)
    np.savez_compressed(path, **(stored(path) | change))
    with refused(ConfigError, start=f"{path}: {message}"):
        NormalMotion.load(path)


def test_files_that_are_missing_or_damaged_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "normal.npz"
    with pytest.raises(ConfigError, match="cannot be read: No such file or directory"):
        NormalMotion.load(path)
    path.write_bytes(b"motion")
    with pytest.raises(ConfigError, match="is not an npz file, or is cut off"):
        NormalMotion.load(path)
    np.savez(path, other=np.zeros(3))
    with pytest.raises(ConfigError, match="has no array format: must be a field of normal motion"):
        NormalMotion.load(path)
    learn([log(*traffic(3))], SENSOR).save(path, force=True)
    whole = path.read_bytes()
    with zipfile.ZipFile(path) as archive:
        place = archive.getinfo("visits.npy").header_offset + 60
    path.write_bytes(whole[:place] + bytes([whole[place] ^ 255]) + whole[place + 1 :])
    with pytest.raises(ConfigError, match="is damaged"):
        NormalMotion.load(path)
    for length in range(0, len(whole), 97):
        path.write_bytes(whole[:length])
        with pytest.raises(ConfigError):
            NormalMotion.load(path)

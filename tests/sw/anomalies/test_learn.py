# SPDX-License-Identifier: Apache-2.0
"""The field of normal motion: its values, its tolerance of outliers, and its files."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
import pytest

from evcot.anomalies import FieldConfig, NormalMotion, learn
from evcot.anomalies.learn import smallest_sensor
from evcot.errors import ConfigError, TrackLogError

from .roads import LANES_PX, SENSOR, away, log, still, straight, towards, track, traffic

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
    monkeypatch.setattr("evcot.anomalies.visits._ROWS", 1)
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
def test_nothing_can_be_learned_of_nothing(tracks: list[np.ndarray]) -> None:
    with pytest.raises(ConfigError, match="learning: no track in the logs is long enough"):
        learn([log(*tracks)], SENSOR)


def test_a_log_that_no_engine_writes_is_refused() -> None:
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
    with pytest.raises(ConfigError) as caught:
        NormalMotion.load(path)
    assert str(caught.value).startswith(f"{path}: {message}")


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

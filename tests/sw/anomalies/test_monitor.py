# SPDX-License-Identifier: Apache-2.0
"""Online alarms: each rule on a road on which everything else is normal."""

from __future__ import annotations

from dataclasses import asdict, replace

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.anomalies import Anomaly, AnomalyConfig, Monitor, NormalMotion, Zones, anomalies, learn
from evcot.anomalies.zones import Line, Zone
from evcot.errors import ConfigError, TrackLogError
from evcot.tracks.log import Kind
from support.refusals import refused

from .roads import LANES_PX, SENSOR, away, log, still, straight, towards, track, traffic

LEFT, MIDDLE, RIGHT = LANES_PX


@pytest.fixture(scope="module")
def normal() -> NormalMotion:
    return learn([log(*traffic())], SENSOR)


def alarms_of(*tracks: NDArray[np.void], normal: NormalMotion | None = None, zones: Zones | None = None) -> NDArray[np.void]:
    return anomalies(log(*tracks), None, normal, zones).alarms


def kinds(alarms: NDArray[np.void]) -> list[str]:
    return [Anomaly(int(kind)).name.lower() for kind in alarms["kind"]]


def test_ordinary_traffic_raises_no_alarm(normal: NormalMotion) -> None:
    other = [track(90 + i, i * 500_000, 2_400_000, away(LANES_PX[i % 3], 1.05 - 0.03 * (i % 4)), 1.0) for i in range(30)]
    assert kinds(alarms_of(*other, normal=normal)) == []


def test_a_wrong_way_driver_is_told_once_while_he_drives(normal: NormalMotion) -> None:
    alarms = alarms_of(*traffic(6), track(77, 2_000_000, 2_400_000, towards(LEFT), 0.5), normal=normal)
    assert kinds(alarms) == ["wrong_way"]
    (alarm,) = alarms
    assert alarm["track_id"] == 77
    assert (alarm["expected"], alarm["seen"]) == (pytest.approx(-90, abs=3), pytest.approx(90, abs=3))
    assert alarm["score"] == pytest.approx(180 / 120, abs=0.05)
    assert alarm["birth_us"] == 2_000_000
    assert 2_000_000 < alarm["begin_us"] < alarm["t_us"] < 3_500_000
    assert alarm["t_us"] - alarm["begin_us"] >= 500_000
    assert alarm["x"] == pytest.approx(LEFT, abs=2)


def test_speeds_are_those_of_the_place(normal: NormalMotion) -> None:
    """A car that is fast far away is slower, in pixels, than one that is normal nearby."""
    fast = track(77, 0, 1_200_000, away(MIDDLE, 2.0), 0.5)
    alarms = alarms_of(fast, normal=normal)
    assert kinds(alarms) == ["fast"]
    assert alarms["seen"][0] / alarms["expected"][0] == pytest.approx(2.0, abs=0.25)
    slow = alarms_of(track(77, 0, 5_000_000, away(MIDDLE, 0.4), 0.5, ends=None), normal=normal)
    assert kinds(slow) == ["slow"]
    assert slow["seen"][0] / slow["expected"][0] == pytest.approx(0.4, abs=0.08)


@pytest.mark.parametrize(("usual", "told"), [(40, ["fast"]), (20, [])])
def test_where_all_are_slow_a_jitter_would_be_fast(usual: int, told: list[str]) -> None:
    """They must be so fast that they come 16 px along in half a second."""
    cars = [track(i, i * 2_000_000, 5_000_000, straight(MIDDLE, 230, 0, -usual), 0.5) for i in range(10)]
    normal = learn([log(*cars)], SENSOR)
    assert kinds(alarms_of(track(77, 0, 2_000_000, straight(MIDDLE, 230, 0, -2 * usual), 0.5), normal=normal)) == told


def test_who_walks_across_the_lanes(normal: NormalMotion) -> None:
    alarms = alarms_of(track(77, 0, 4_000_000, straight(80, 120, 50, 0), 0.5), normal=normal)
    assert "crossing" in kinds(alarms)
    assert "wrong_way" not in kinds(alarms)
    (alarm,) = alarms[alarms["kind"] == Anomaly.CROSSING]
    assert (alarm["expected"], alarm["seen"]) == (pytest.approx(-90, abs=3), pytest.approx(0, abs=15))


def brakes(s: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Normal for 0.6 s, then slower and slower, and after another 1.6 s it stands."""
    lasts = np.clip(s - 0.6, 0, 1.6)
    return np.full(len(s), MIDDLE), 250 * np.exp(-np.minimum(s, 0.6) - (lasts - lasts**2 / 3.2))


def test_who_brakes_and_stands_has_stopped(normal: NormalMotion) -> None:
    alarms = alarms_of(track(77, 0, 4_000_000, brakes, 0.3), normal=normal)
    assert "stopping" in kinds(alarms)
    stopping = alarms[alarms["kind"] == Anomaly.STOPPING][0]
    assert 2_000_000 < stopping["t_us"] < 3_500_000
    assert stopping["seen"] < 0.25 * stopping["expected"]


def test_who_is_lost_while_slow_has_stopped(normal: NormalMotion) -> None:
    """Standing objects cause no events: the track ends before the car stands, but after it was slow for half a second."""
    lasts_us = 2_300_000
    alarms = alarms_of(track(77, 0, lasts_us, brakes, 0.3), normal=normal)
    (stopping,) = alarms[alarms["kind"] == Anomaly.STOPPING]
    assert stopping["begin_us"] < stopping["t_us"] - 500_000 == lasts_us - 500_000
    merged = alarms_of(track(77, 0, lasts_us, brakes, 0.3, ends=Kind.MERGED), normal=normal)
    assert "stopping" not in kinds(merged)
    assert kinds(alarms_of(track(77, 0, 700_000, away(MIDDLE), 0.3), normal=normal)) == []


def test_who_brakes_and_whose_track_goes_back_has_stopped(normal: NormalMotion) -> None:
    """The track switches to the next car, 60 px behind, before it is lost: the alarm is near where it braked."""

    def goes_back(s: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        x, y = brakes(s)
        return x, y + 200 * np.clip(s - 2.3, 0, 0.3)

    alarms = alarms_of(track(77, 0, 2_600_000, goes_back, 0.3), normal=normal)
    (stopping,) = alarms[alarms["kind"] == Anomaly.STOPPING]
    assert stopping["t_us"] < 2_600_000
    assert stopping["y"] == pytest.approx(float(brakes(np.array([2.3]))[1][0]), abs=15)


def test_who_stays_where_first_seen_and_drives_off_has_stood(normal: NormalMotion) -> None:
    def starts(s: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        return np.full(len(s), MIDDLE), 150 - 12 * s**2

    alarms = alarms_of(track(77, 0, 2_500_000, starts, 0.3), normal=normal)
    assert kinds(alarms).count("stopping") == 1
    at_the_edge = alarms_of(track(77, 0, 2_500_000, lambda s: (starts(s)[0], starts(s)[1] + 100), 0.3), normal=normal)
    assert "stopping" not in kinds(at_the_edge)

    def taken_along(s: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        return np.full(len(s), MIDDLE), 150 - 320 * np.maximum(s - 0.9, 0)

    assert "stopping" not in kinds(alarms_of(track(77, 0, 1_250_000, taken_along, 0.3), normal=normal))


def test_a_box_that_swells_has_no_velocity(normal: NormalMotion) -> None:
    steady = track(77, 0, 2_000_000, away(MIDDLE, 2.0), 0.3)
    assert "fast" in kinds(alarms_of(steady, normal=normal))
    swelling = steady.copy()
    swelling["height"] = np.where(np.arange(len(swelling)) % 10 < 5, 24.0, 48.0)
    assert kinds(alarms_of(swelling, normal=normal)) == []
    searching = steady.copy()
    searching["radius"] = np.where(np.arange(len(searching)) % 10 < 5, 12.0, 24.0)
    assert "fast" in kinds(alarms_of(searching, normal=normal)), "the search window is not the object"


def pacing(s: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    return 300 + 12 * np.sin(3 * s), np.full(len(s), 150.0)


def test_who_stays_within_a_radius_loiters() -> None:
    """Without any normal motion this rule alone is left."""
    alarms = alarms_of(track(77, 1_000_000, 8_000_000, pacing, 0.5))
    assert kinds(alarms) == ["loitering"]
    assert alarms["t_us"][0] == pytest.approx(7_000_000, abs=100_000)
    assert alarms["begin_us"][0] == pytest.approx(1_000_000, abs=50_000)
    assert kinds(alarms_of(track(77, 1_000_000, 5_800_000, pacing, 0.5))) == []
    assert kinds(alarms_of(track(77, 0, 8_000_000, straight(10, 10, 20, 0), 0.5))) == []


def test_a_stay_outlives_the_tracks_that_see_it() -> None:
    pieces = [track(70 + i, i * 2_500_000, 1_500_000, pacing) for i in range(4)]
    alarms = alarms_of(*pieces)
    assert kinds(alarms) == ["loitering"]
    assert alarms["begin_us"][0] < 100_000
    far_between = [track(70 + i, i * 6_000_000, 1_500_000, pacing) for i in range(4)]
    assert kinds(alarms_of(*far_between)) == []


def test_where_normal_motion_is_slow_a_stay_may_be_longer(normal: NormalMotion) -> None:
    """At y = 20 px cars make 20 px/s, and take 2 s through the radius."""
    creeping = track(77, 0, 12_000_000, straight(MIDDLE, 22, 0, -0.5), 0.2, ends=None)
    alarms = alarms_of(creeping, normal=normal)
    (alarm,) = alarms[alarms["kind"] == Anomaly.LOITERING]
    assert alarm["expected"] > 5.9


def test_a_place_where_nobody_ever_was(normal: NormalMotion) -> None:
    alarms = alarms_of(track(77, 0, 2_000_000, straight(20, 20, 10, 20), 0.3), normal=normal)
    assert kinds(alarms) == ["place"]
    assert kinds(alarms_of(track(77, 0, 2_000_000, straight(20, 20, 10, 20), 0.3))) == []  # nothing is known


def test_jitter_births_and_merges_raise_nothing(normal: NormalMotion) -> None:
    """A track that trembles by several pixels; short ones that point anywhere; one that jumps from a car to the next."""
    trembling = [track(70 + i, i * 1_000_000, 2_400_000, away(LEFT), 3.0) for i in range(5)]
    short = [track(80 + i, i * 900_000, 250_000, straight(MIDDLE, 100, 60 * (-1) ** i, 30)) for i in range(10)]

    def jumps(s: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        behind = np.where(s > 1.0, 0.5, 0.0) + np.clip(s - 1.0, 0, 0.2) * 0
        return np.full(len(s), RIGHT), 250 * np.exp(-(s - behind))

    def slides(s: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        return np.full(len(s), RIGHT), 250 * np.exp(-(s - 2.5 * np.clip(s - 1.0, 0, 0.25)))

    others = [track(95, 0, 2_000_000, jumps), track(96, 3_000_000, 2_000_000, slides)]
    assert kinds(alarms_of(*trembling, *short, *others, normal=normal)) == []


def test_a_track_that_goes_on_for_another_is_not_told_twice(normal: NormalMotion) -> None:
    whole = track(77, 0, 2_400_000, towards(LEFT))
    first, second = whole[:130].copy(), whole[135:].copy()
    first[-1]["kind"], second[0]["kind"] = Kind.LOST, Kind.BORN
    second["track_id"] = 78
    assert kinds(alarms_of(first, second, normal=normal)) == ["wrong_way"]
    away_from_it = second.copy()
    away_from_it["x"] = MIDDLE
    assert kinds(alarms_of(first, away_from_it, normal=normal)) == ["wrong_way", "wrong_way"]


FIELD = ((100.0, 100.0), (200.0, 100.0), (200.0, 200.0), (100.0, 200.0))


def test_zones_forbid_stays_and_long_stays() -> None:
    forbidden, dwell = Zones((Zone("lawn", FIELD),)), Zones((Zone("stop", FIELD, 1_500_000),))
    through = track(5, 0, 4_000_000, straight(50, 150, 50, 0))
    (alarm,) = alarms_of(through, zones=forbidden)
    assert (Anomaly(int(alarm["kind"])), alarm["zone"]) == (Anomaly.FORBIDDEN, 0)
    assert alarm["begin_us"] == pytest.approx(1_000_000, abs=50_000)
    assert alarm["t_us"] == pytest.approx(1_500_000, abs=50_000)
    (alarm,) = alarms_of(through, zones=dwell)
    assert Anomaly(int(alarm["kind"])) is Anomaly.DWELL
    assert alarm["t_us"] == pytest.approx(2_500_000, abs=80_000)
    assert alarm["expected"] == 1.5
    assert kinds(alarms_of(track(5, 0, 4_000_000, straight(50, 150, 80, 0)), zones=dwell)) == []
    assert kinds(alarms_of(track(5, 0, 4_000_000, straight(50, 90, 50, 0)), zones=forbidden)) == []


def test_lines_count_and_tell_the_wrong_direction() -> None:
    """A line that points to the right has the lower part of the picture on its right: down is to_right."""
    gate = Zones(lines=(Line("gate", (50.0, 130.0), (300.0, 130.0), -1),))
    tracks = [
        track(1, 0, 1_000_000, straight(100, 180, 0, -100)),
        track(2, 100_000, 1_000_000, straight(150, 180, 0, -100)),
        track(3, 200_000, 1_000_000, straight(200, 80, 0, 100)),
        track(4, 300_000, 1_000_000, straight(20, 80, 0, 100)),  # beside the line
        track(5, 400_000, 2_000_000, lambda s: (np.full(len(s), 250.0), 130 + 1.5 * np.sin(40 * s))),  # trembles on it
    ]
    verdict = anomalies(log(*tracks), None, None, gate)
    assert verdict.counts.tolist() == [[1, 2]]
    (alarm,) = verdict.alarms
    assert (Anomaly(int(alarm["kind"])), alarm["track_id"], alarm["seen"]) == (Anomaly.LINE, 3, 1)
    both = replace(gate, lines=(replace(gate.lines[0], allowed=0),))
    assert kinds(anomalies(log(*tracks), None, None, both).alarms) == []


@pytest.mark.parametrize("pieces", [1, 7, 100, 10**6])
def test_alarms_do_not_depend_on_where_runs_are_cut(normal: NormalMotion, pieces: int) -> None:
    zones = Zones((Zone("lawn", FIELD),), (Line("gate", (0.0, 130.0), (345.0, 130.0), 1),))
    records = log(
        *traffic(20), track(77, 0, 2_400_000, towards(LEFT)), track(78, 5_000_000, 8_000_000, pacing, 0.5),
        *(track(200 + i, 9_000_000 + 1000 * i, 500_000, still(3.0 * i, 250.0)) for i in range(90)),
    ).records  # fmt: skip
    whole = Monitor(None, normal, zones)
    alarms = whole.feed(records)
    assert len(alarms) > 20
    assert {"wrong_way", "loitering", "forbidden", "line"} <= set(kinds(alarms))
    cut = Monitor(None, normal, zones)
    size = max(1, len(records) // pieces) if pieces > 1 else len(records)
    parts = [cut.feed(records[i : i + size]) for i in range(0, len(records), size)]
    np.testing.assert_array_equal(np.concatenate(parts), alarms)
    np.testing.assert_array_equal(cut.counts, whole.counts)


def test_a_table_that_is_too_small_grows_and_memory_stays_with_the_living() -> None:
    crowd = log(*(track(i, 0, 300_000, still(3.0 * i, 20.0)) for i in range(100)))
    monitor = Monitor()
    monitor.feed(crowd.records)
    assert len(monitor._table) == 128
    one_by_one = log(*(track(i, 2_000_000 * i, 300_000, still(3.0 * i, 20.0)) for i in range(300)))
    monitor = Monitor()
    monitor.feed(one_by_one.records)
    assert len(monitor._table) == 32


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"x": np.nan}, "record 5: x = nan: must be a number of at most 1e+09"),
        ({"x": 400.0}, "record 5: x = 400: must lie on the 346x260 pixels of the normal motion or the zones"),
        ({"y": -20.0}, "record 5: y = -20: must lie on the 346x260 pixels"),
        ({"t_us": 10**6}, "record 6: t_us = 60000: must not be before the record before it"),
        ({"kind": 9}, "record 5: kind = 9: must be from 0 to 3"),
    ],
)
def test_logs_that_cannot_be_of_this_place_are_refused(normal: NormalMotion, change: dict[str, float], message: str) -> None:
    records = track(1, 0, 200_000, still(100, 100))
    for name, value in change.items():
        records[name][5] = value
    with refused(TrackLogError, start=message):
        Monitor(None, normal).feed(records)


def test_time_must_not_run_back_from_run_to_run() -> None:
    monitor = Monitor()
    assert len(anomalies(log()).alarms) == 0
    monitor.feed(track(1, 500_000, 200_000, still(100, 100)))
    with pytest.raises(TrackLogError, match="record 21: t_us = 0 follows 700000: time must not run back"):
        monitor.feed(track(2, 0, 200_000, still(100, 100)))


def test_settings_and_files_that_contradict_each_other(normal: NormalMotion) -> None:
    zones = Zones((Zone("lawn", FIELD),), sensor=(128, 128))
    with pytest.raises(ConfigError, match="zones of 128x128 and normal motion of 346x260 pixels: must be of one sensor"):
        Monitor(None, normal, zones)
    with pytest.raises(ConfigError, match=r"step_us = 20000, .*: must be as when normal motion was learned, step_us = 25000"):
        Monitor(AnomalyConfig(step_us=20_000), normal)
    with pytest.raises(ConfigError, match=r"anomalies.hold_us = -1: must be from 0 to 60000000 \(a rule must be broken"):
        AnomalyConfig(hold_us=-1)
    with pytest.raises(ConfigError, match=r"anomalies.window_us = 90000: must be from 4 to 31 times step_us = 25000"):
        AnomalyConfig(window_us=90_000)
    with pytest.raises(ConfigError, match=r"anomalies.wrong_way_deg = 40: must be at least crossing_deg = 50"):
        AnomalyConfig(wrong_way_deg=40.0)
    assert asdict(AnomalyConfig())["hold_us"] == 500_000

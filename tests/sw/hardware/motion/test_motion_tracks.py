# SPDX-License-Identifier: Apache-2.0
"""What the rules are for: boxes and velocities of known objects, objects that cross, one object of two edges, noise."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from numba import njit
from numpy.typing import NDArray

from evcot.hardware.config import MotionConfig
from evcot.hardware.contract import Shape
from evcot.hardware.motion import _state
from evcot.hardware.motion._gaps import clear_bins
from evcot.hardware.motion._velocity import follow_pace, gain_log2, over
from evcot.hardware.motion.contract import MotionRegisters
from evcot.hardware.motion.model import MotionModel
from evcot.ticks import TickedEvents
from evcot.tracks.log import Kind
from support.moving import PLAIN

DEFAULT = PLAIN
PX = 4096.0

Pair = tuple[float, float]
Columns = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]


def events(*columns: Columns) -> TickedEvents:
    """Several objects' (t_us, x, y), merged."""
    t, x, y = (np.concatenate(column) for column in zip(*columns, strict=True))
    order = np.argsort(t, kind="stable")
    place = np.clip(np.rint([x[order], y[order]]), 0, 255).astype(np.uint16)
    return TickedEvents(t[order].astype(np.int64), place[0], place[1], np.zeros(len(t), np.uint8))


def outline(
    seed: int,
    start: tuple[float, float],
    speed: tuple[float, float],
    half: tuple[float, float],
    hz: float,
    end_us: int = 1_000_000,
) -> Columns:
    """Events all round a box that moves straight on; speed in px/s."""
    random = np.random.default_rng(seed)
    n = round(hz * end_us * 1e-6)
    t = np.sort(random.uniform(0, end_us, n))
    x, y = random.uniform(-1, 1, (2, n))
    on_side, sign = random.random(n) < 0.5, random.choice((-1.0, 1.0), n)
    x, y = np.where(on_side, sign, x), np.where(on_side, y, sign)
    return t, start[0] + speed[0] * t * 1e-6 + half[0] * x, start[1] + speed[1] * t * 1e-6 + half[1] * y


def records(stream: TickedEvents, registers: MotionRegisters = DEFAULT, n_slots: int = 8) -> NDArray[np.void]:
    return MotionModel(MotionConfig(Shape(n_slots=n_slots, x_w=8, y_w=8), registers)).feed(stream).records


@njit(nogil=True)
def _gain_at(s: NDArray[np.int64], r: NDArray[np.int64], run: int, in_burst: bool) -> int:
    return gain_log2(s, r, 0, 63, run, in_burst)


@njit
def _follow_at(s: NDArray[np.int64]) -> None:
    follow_pace(s, 0)


def _gain_of(run: int, *, meets: int = 0, gain_fast: int = 0, in_burst: bool = False) -> int:
    s = np.zeros((1, _state.FIELD_COUNT), np.int64)
    s[0, _state.MEETS] = meets
    registers = replace(DEFAULT, gain_log2=5, gain_fast=gain_fast)
    return int(_gain_at(s, np.array(list(vars(registers).values()), np.int64), run, in_burst))


def born(found: NDArray[np.void]) -> int:
    return int(np.count_nonzero(found["kind"] == Kind.BORN))


@pytest.mark.parametrize("speed", [(120.0, 0.0), (0.0, -120.0), (100.0, 60.0), (-100.0, -60.0)])
def test_box_and_velocity_of_one_object(speed: tuple[float, float]) -> None:
    start = tuple(30.0 if way > 0 else 220.0 if way < 0 else 128.0 for way in speed)
    found = records(events(outline(1, (start[0], start[1]), speed, (14.0, 7.0), 20_000)))
    assert born(found) == 1
    late = found[found["time"] > 600_000]
    seconds = late["time"] * 1e-6
    assert np.abs(late["cm_x"] / PX - start[0] - speed[0] * seconds).max() < 2.0
    assert np.abs(late["cm_y"] / PX - start[1] - speed[1] * seconds).max() < 2.0
    assert np.median(late["width"]) / PX == pytest.approx(26.5, abs=2.0)
    assert np.median(late["height"]) / PX == pytest.approx(13.2, abs=1.5)
    per_s = 1e6 / 1024 / PX
    assert np.median(late["v_x"]) * per_s == pytest.approx(speed[0], abs=8.0)
    assert np.median(late["v_y"]) * per_s == pytest.approx(speed[1], abs=8.0)


def test_prediction_carries_an_object_over_silence() -> None:
    t, x, y = outline(2, (30.0, 60.0), (150.0, 0.0), (8.0, 8.0), 20_000)
    seen = (t < 500_000) | (t > 560_000)  # it goes on for 9 px behind something
    stream = events((t[seen], x[seen], y[seen]))
    registers = replace(DEFAULT, life_ticks=80_000)
    found = records(stream, registers)
    assert (born(found), np.count_nonzero(found["kind"] == Kind.LOST)) == (1, 0)
    hidden = found[(found["time"] > 505_000) & (found["time"] < 560_000)]
    assert len(hidden) >= 10
    assert np.abs(hidden["cm_x"] / PX - 30.0 - 150e-6 * hidden["time"]).max() < 3.0
    still = records(stream, replace(registers, speed_max=0))
    waits = still[(still["time"] > 505_000) & (still["time"] < 560_000)]
    assert np.ptp(waits["cm_x"]) == 0


def test_a_silent_velocity_dies_away() -> None:
    stream = events(outline(3, (30.0, 60.0), (150.0, 0.0), (8.0, 8.0), 20_000, 400_000))
    last = TickedEvents(np.array([590_000]), *(np.array([200], np.uint16),) * 2, np.zeros(1, np.uint8))
    both = [TickedEvents(*(np.concatenate(pair) for pair in zip(vars(stream).values(), vars(last).values(), strict=True)))]
    found = records(both[0], replace(DEFAULT, life_ticks=200_000, coast_ticks=200_000))
    silent = found[found["time"] > 450_000]["v_x"]
    assert 0.7 * silent[0] > silent[-1] > 0
    assert (np.diff(silent) <= 0).all()


def swing(seed: int, pauses: tuple[tuple[int, int], ...] = ()) -> tuple[TickedEvents, Columns]:
    """Events of a box that swings, and its way; it sends none during pauses."""
    t, x, y = outline(seed, (128.0, 60.0), (0.0, 0.0), (8.0, 8.0), 15_000, 2_000_000)
    way = 60.0 * np.sin(2 * np.pi * t * 1e-6)
    seen = np.ones(len(t), bool)
    for begin, end in pauses:
        seen &= (t < begin) | (t >= end)
    return events((t[seen], x[seen] + way[seen], y[seen])), (t, 128.0 + way, y)


def test_corrections_that_agree_are_followed_sooner() -> None:
    stream, _ = swing(4)
    off = {}
    for fast in (0, 2):
        registers = replace(DEFAULT, gain_log2=6, gain_slow=0, gain_fast=fast, life_ticks=100_000)
        model = MotionModel(MotionConfig(Shape(n_slots=1, x_w=8, y_w=8), registers))
        errors = []
        for begin in range(0, len(stream.ticks), 100):
            part = stream[begin : begin + 100]
            model.feed(part)
            speed = 2 * np.pi * 60.0 * np.cos(2 * np.pi * part.ticks[-1] * 1e-6)
            errors.append(abs(model._state[0, _state.V_X] * 1e6 / 1024 / PX - speed))
        off[fast] = np.mean(errors[len(errors) // 4 :])
    assert off[2] < 0.6 * off[0]


def followed(sides: tuple[int, int, int, int], was: Pair, pace: Pair, stated: Pair) -> list[int]:
    """`was`, `pace` and `stated` of both axes after a step."""
    s = np.zeros((1, _state.FIELD_COUNT), np.int64)
    s[0, [_state.LO_X, _state.HI_X, _state.LO_Y, _state.HI_Y]] = sides
    columns = [_state.WAS_X, _state.WAS_Y, _state.PACE_X, _state.PACE_Y, _state.STATED_X, _state.STATED_Y]
    s[0, columns] = *was, *pace, *stated
    _follow_at(s)
    return [int(value) for value in s[0, columns]]


def test_the_stated_velocity_is_the_displacement_averaged_twice() -> None:
    # 40,960 x 81,920; the middle has moved by 160 and by -160 half units
    assert followed((0, 40_960, 0, 81_920), (40_800, 82_080), (0, 0), (0, 0)) == [40_960, 81_920, 10, -10, 1, -1]
    # to nearest, halves upwards
    assert followed((0, 40_960, 0, 81_920), (40_952, 81_928), (0, 0), (0, 0)) == [40_960, 81_920, 1, 0, 0, 0]
    # 2,560 << 4 is the shorter side, one more is beyond; at most 65,535 count
    sides = (0, 40_960, 0, 81_920)
    assert followed(sides, (-100_000, 0), (0, 0), (2_560, 0))[2:] == [4_096, 4_096, 2_656, 256]
    assert followed(sides, (-100_000, 0), (0, 0), (2_561, 0))[2:] == [8_192, 8_192, 3_265, 1_024]
    # never faster than over two steps
    assert followed(sides, (40_960, 81_920), (0, 0), (0, -60_000)) == [40_960, 81_920, 0, 0, 0, -30_000]
    # sides that have passed each other have no length
    assert followed((8, 0, 0, 81_920), (8, 81_920), (2, 0), (4, 0))[2:] == [1, 0, 3, 0]


def test_the_stated_velocity_is_right_and_steady() -> None:
    stream = events(outline(5, (30.0, 60.0), (120.0, 60.0), (9.0, 9.0), 20_000))
    found = records(stream)
    settled = found[(found["time"] > 500_000) & (found["kind"] == Kind.MOVED)]
    speeds = np.array([settled["v_x"], settled["v_y"]]) * 1e6 / 1024 / PX
    assert np.abs(speeds.mean(axis=1) - [120.0, 60.0]).max() < 2.0
    assert speeds.std(axis=1).max() < 3.0


def test_the_gain_rises_after_two_that_agree_and_not_beside_another() -> None:
    runs = list(range(-7, 8))
    raised = [_gain_of(run, gain_fast=2) for run in runs]
    assert raised == [2, 2, 2, 3, 4, 5, 5, 5, 5, 5, 4, 3, 2, 2, 2]
    assert [_gain_of(run, gain_fast=4) for run in runs] == [max(gain, 4) for gain in raised]
    assert {_gain_of(run, gain_fast=0) for run in runs} == {_gain_of(run, gain_fast=9) for run in runs} == {5}
    assert {_gain_of(run, gain_fast=2, meets=1) for run in runs} == {6}


def test_the_gain_within_a_burst_does_not_depend_on_registers() -> None:
    for gain_fast in (0, 2, 9):
        assert [_gain_of(run, gain_fast=gain_fast, in_burst=True) for run in range(-4, 5)] == [0, 0, 1, 1, 1, 1, 1, 0, 0]
        assert {_gain_of(run, gain_fast=gain_fast, meets=1, in_burst=True) for run in range(-7, 8)} == {2}


def test_a_silent_box_goes_on_by_a_part_of_its_way() -> None:
    t, x, y = outline(2, (30.0, 60.0), (150.0, 0.0), (8.0, 8.0), 20_000)
    stream = events((t[t < 500_000], x[t < 500_000], y[t < 500_000]), (np.array([990_000.0]), *(np.array([250.0]),) * 2))
    went = []
    for slow in (0, 2):
        found = records(stream, replace(DEFAULT, coast_slow=slow, friction=0, life_ticks=90_000, coast_ticks=90_000))
        silent = found[(found["time"] > 520_000) & (found["kind"] == Kind.MOVED)]
        went.append(np.ptp(silent["cm_x"]) / PX)
    empty = 32 * 2**DEFAULT.step_log2  # ticks of motion steps without events, which do not count
    assert went[0] == pytest.approx(150e-6 * (70_000 + empty), abs=2.0)
    assert went[1] == pytest.approx(went[0] / 4, rel=0.1)


def test_what_was_lost_goes_on_under_its_id_if_it_returns_in_time_and_there() -> None:
    pause = (1_160_000, 1_400_000)  # about a turn
    stream, _ = swing(5, (pause,))
    for wait, tracks in ((0, 2), (100_000, 2), (400_000, 1)):
        found = records(stream, replace(DEFAULT, gain_fast=2, coast_slow=2, return_ticks=wait))
        assert born(found) == tracks == len(set(found["track_id"].tolist()))
        lost = found["time"][found["kind"] == Kind.LOST]
        assert len(lost) == 1
        assert pause[0] < lost[0] < pause[1]
    elsewhere = outline(6, (60.0, 200.0), (0.0, -120.0), (8.0, 8.0), 15_000, 900_000)
    late = events(
        (elsewhere[0] + 700_000, elsewhere[1], elsewhere[2]),
        outline(5, (30.0, 60.0), (150.0, 0.0), (8.0, 8.0), 15_000, 600_000),
    )
    assert born(records(late, replace(DEFAULT, return_ticks=2**24 - 1))) == 2


@pytest.mark.parametrize("seed", range(4))
def test_two_that_cross_keep_their_identities(seed: int) -> None:
    one = outline(seed, (40.0, 40.0), (140.0, 110.0), (9.0, 9.0), 15_000)
    other = outline(seed + 50, (180.0, 40.0), (-140.0, 110.0), (9.0, 9.0), 15_000)
    found = records(events(one, other))
    assert (born(found), np.count_nonzero(found["kind"] == Kind.MERGED)) == (2, 0)
    first, last = ({int(row["track_id"]): row["cm_x"] / PX for row in found[part]} for part in (found["time"] < 300_000, ...))
    for track, x in first.items():
        assert (last[track] > 110) == (x < 110), "each is on the other side in the end"


def test_two_edges_of_one_object_become_one_track() -> None:
    def bar(seed: int, y: float) -> Columns:
        return outline(seed, (80.0, y), (0.0, 120.0), (12.0, 1.0), 8_000)

    found = records(events(bar(1, 40.0), bar(2, 62.0)), replace(DEFAULT, birth_px=0))
    late = found[found["time"] > 900_000]
    assert len(set(late["track_id"].tolist())) == 1
    assert np.median(late["height"]) / PX == pytest.approx(23.0, abs=3.0)
    apart = records(events(bar(1, 40.0), bar(2, 62.0)), replace(DEFAULT, birth_px=0, join_steps=1023, ring_along=8, ring_any=8))
    assert len(set(apart[apart["time"] > 900_000]["track_id"].tolist())) == 2


@njit(nogil=True)
def _cleared(s: NDArray[np.int64]) -> None:
    clear_bins(s, 0)


@pytest.mark.parametrize("px", [8, 15, 16, 31, 32, 96, 127, 128, 511])
def test_a_box_of_any_size_has_eight_to_sixteen_bins(px: int) -> None:
    s = np.zeros((1, _state.FIELD_COUNT), np.int64)
    s[0, _state.HI_X], s[0, _state.HI_Y] = px * PX, 5 * PX
    _cleared(s)
    assert 8 <= px / (1 << int(s[0, _state.BIN_LOG2_X])) <= 16
    assert s[0, _state.BIN_LOG2_Y] == 0, "no bin is less than a pixel"


def test_two_abreast_are_cut_apart() -> None:
    """They appear as one, since they begin together and close by; the gap between them shows."""
    starts = (1, 100.0, -16.0), (2, 119.0, 16.0)
    stream = events(*(outline(seed, (x, 30.0), (way, 150.0), (8.0, 8.0), 12_000) for seed, x, way in starts))
    both = [records(stream, replace(DEFAULT, gap_corrections=n, ring_across=0, ring_any=0)) for n in (16, 0)]
    late = [found[found["time"] > 900_000] for found in both]
    assert max(late[0]["width"]) / PX < 25
    assert max(late[1]["width"]) / PX > 35


def test_of_two_that_merge_the_one_with_more_support_stays_or_the_older() -> None:
    def bar(seed: int, y: float, hz: float, begin_us: int) -> Columns:
        t, x, y_px = outline(seed, (80.0, y), (0.0, 120.0), (12.0, 1.0), hz)
        return t[t > begin_us], x[t > begin_us], y_px[t > begin_us]

    stream = events(bar(1, 62.0, 3_000, 0), bar(2, 40.0, 16_000, 100_000))
    apart = replace(DEFAULT, birth_px=0, join_steps=150, ring_along=8, ring_any=8)
    stays = {}
    for older in (0, 1):
        found = records(stream, replace(apart, keep_older=older))
        merged = found[found["kind"] == Kind.MERGED]
        assert len(merged) == 1
        stays[older] = int(merged["other_id"][0])
    assert stays == {0: 1, 1: 0}


def test_noise_and_a_hot_pixel_and_a_lamp_are_not_born() -> None:
    random = np.random.default_rng(7)
    n = 15_000
    noise = np.sort(random.uniform(0, 1e6, n)), random.uniform(0, 255, n), random.uniform(0, 255, n)
    hot = np.arange(0, 1e6, 200.0), np.full(5_000, 60.0), np.full(5_000, 60.0)
    lamp = np.sort(random.uniform(0, 1e6, n)), *random.uniform(120, 140, (2, n))
    assert born(records(events(hot))) == 0
    assert born(records(events(lamp))) == 0
    assert born(records(events(noise), n_slots=16)) == 0
    asked_less = replace(DEFAULT, birth_travel=8, birth_px=0)
    assert born(records(events(lamp), asked_less)) >= 1, "nothing but its rest keeps the lamp from being born"


@pytest.mark.parametrize("ticks", [1, 2, 3, 7, 8, 9, 15, 16, 100, 1_000, 123_456, 2**24])
def test_a_quotient_is_within_six_percent(ticks: int) -> None:
    for distance in (-(2**20), -(2**14), 2**14, 2**20):
        exact = distance * 2**20 / ticks
        assert over(distance, ticks, 20) == pytest.approx(exact, rel=0.065, abs=1.5)
    assert over(3 * 2**12, 2**10, 5) == math.floor(3 * 2**12 * round(1024 / 8.5) / 2**12)

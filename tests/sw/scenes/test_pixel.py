# SPDX-License-Identifier: Apache-2.0
"""The pixel model against results computed by hand: dI = pK, timing, mismatch, refractory time, noise."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.errors import ConfigError
from evcot.events import Events
from evcot.scenes._order import KEY_T_SHIFT, events_of
from evcot.scenes._pixel_kernel import levels_of
from evcot.scenes.pixel import PixelCamera, PixelModel
from support.refusals import refused

IDEAL = PixelModel(on_threshold=0.2, off_threshold=0.25)
SEED = 5


def watch(model: PixelModel, frames: Iterable[tuple[int, NDArray[np.float64]]], seed: int = SEED) -> tuple[Events, PixelCamera]:
    """All events of (time, frame) pairs."""
    camera, blocks = None, []
    for t_us, frame in frames:
        camera = camera or PixelCamera(model, frame.shape[1], frame.shape[0], seed)
        blocks.append(camera.step(frame, t_us))
    assert camera is not None
    return Events.joined(blocks), camera


def levels(*log_intensity: float, width: int = 1, height: int = 1, step_us: int = 1_000) -> list[tuple[int, Any]]:
    """The same light everywhere, a frame every step."""
    return [(i * step_us, np.full((height, width), level)) for i, level in enumerate(log_intensity)]


def content(events: Events) -> list[list[int]]:
    return [events.t_us.tolist(), events.x.tolist(), events.y.tolist(), events.p.tolist()]


def gaps(events: Events, width: int) -> NDArray[np.int64]:
    """Times between events of one pixel, all pixels together."""
    pixel = events.y.astype(np.int64) * width + events.x
    order = np.lexsort((events.t_us, pixel))
    return np.diff(events.t_us[order])[np.diff(pixel[order]) == 0]


def test_light_that_rises_in_a_line_makes_events_at_the_microsecond_of_each_threshold() -> None:
    events, _ = watch(IDEAL, levels(0.0, 1.0, step_us=1_000))
    assert content(events) == [[200, 400, 600, 800, 1_000], [0] * 5, [0] * 5, [1] * 5]


def test_on_and_off_have_their_own_thresholds_and_the_memory_is_where_the_last_event_was() -> None:
    """Up by 0.7: at 0.2, 0.4 and 0.6. Down to -0.2 from there: at 0.35, 0.1 and -0.15."""
    events, _ = watch(IDEAL, levels(0.0, 0.7, -0.2, step_us=900))
    assert events.p.tolist() == [1, 1, 1, 0, 0, 0]
    assert events.t_us.tolist() == [257, 514, 771, 900 + 350, 900 + 600, 900 + 850]


def test_a_threshold_that_is_not_reached_is_not_forgotten_either() -> None:
    events, _ = watch(IDEAL, levels(0.0, 0.15, 0.15, 0.25))
    assert content(events) == [[2_500], [0], [0], [1]]


@pytest.mark.parametrize("contrast", [0.1, 0.2, 0.8, 1.0, 1.1, 3.99])
@pytest.mark.parametrize("steps", [1, 7, 40])
def test_a_pixel_that_an_edge_crosses_makes_floor_of_contrast_over_threshold_events(contrast: float, steps: int) -> None:
    """A step edge of the given contrast in log intensity, moving over 8 columns, however finely the frames cut its way."""
    places = np.linspace(-1, 9, steps + 1)
    columns = np.arange(8)
    frames = [(1_000 * i, np.tile(contrast * np.clip(at - columns + 0.5, 0, 1), (2, 1))) for i, at in enumerate(places)]
    events, _ = watch(IDEAL, frames)
    assert (events.p == 1).all()
    counted = np.zeros((2, 8), int)
    np.add.at(counted, (events.y, events.x), 1)
    assert counted.tolist() == [[int(contrast / 0.2 + 1e-9)] * 8] * 2


def test_mismatch_spreads_the_thresholds_normally_and_never_to_zero() -> None:
    camera = PixelCamera(replace(IDEAL, mismatch=0.1), 300, 200, SEED)
    for thresholds, nominal in ((camera.on_threshold, 0.2), (camera.off_threshold, 0.25)):
        relative = thresholds / nominal
        assert relative.mean() == pytest.approx(1.0, abs=5 * 0.1 / np.sqrt(60_000))
        assert relative.std() == pytest.approx(0.1, rel=0.02)
        assert np.mean(abs(relative - 1) < 0.1) == pytest.approx(0.683, abs=0.01)
    assert abs(np.corrcoef(camera.on_threshold.ravel(), camera.off_threshold.ravel())[0, 1]) < 0.02
    wide = PixelCamera(replace(IDEAL, mismatch=0.5), 300, 200, SEED)
    assert wide.on_threshold.min() == pytest.approx(0.02)


def test_pixels_answer_to_their_own_threshold() -> None:
    model = replace(IDEAL, mismatch=0.2)
    events, camera = watch(model, levels(0.0, 2.0, width=40, height=30))
    counted = np.zeros((30, 40))
    np.add.at(counted, (events.y, events.x), 1)
    np.testing.assert_array_equal(counted, np.floor(2.0 / camera.on_threshold))


def test_after_the_refractory_time_the_memory_is_the_light_at_its_end() -> None:
    """Events at 200 us, and at 450 + 200 us: what changed between is lost. From 900 us on, 0.9 is remembered: OFF at 0.65."""
    events, _ = watch(replace(IDEAL, refractory_us=250), levels(0.0, 1.0, 1.0, 0.6, step_us=1_000))
    assert content(events) == [[200, 650, 2_875], [0] * 3, [0] * 3, [1, 1, 0]]


def test_the_refractory_time_reaches_across_frames() -> None:
    """An event at 200 us; until 1700 us the pixel is blind, and then remembers 0.5 + 0.7 * 0.4."""
    events, _ = watch(replace(IDEAL, refractory_us=1_500), levels(0.0, 1.0, 0.3, 0.3, 1.3, step_us=1_000))
    assert events.t_us.tolist() == [200, 3_000 + 410]
    assert events.p.tolist() == [1, 1]


def test_no_two_events_of_a_pixel_are_closer_than_the_refractory_time() -> None:
    random = np.random.default_rng(SEED)
    model = PixelModel(0.1, 0.1, 0.1, refractory_us=700, noise_hz=300.0, leak_hz=50.0, hot_pixels=3, hot_hz=5_000.0)
    frames = [(1_000 * i, random.normal(0, 0.5, (12, 16))) for i in range(60)]
    events, _ = watch(model, frames)
    assert len(events) > 5_000
    assert gaps(events, 16).min() == 700
    without, _ = watch(replace(model, refractory_us=0), frames)
    assert gaps(without, 16).min() < 10


@pytest.mark.parametrize(("noise_hz", "leak_hz", "on_share"), [(20.0, 0.0, 0.5), (0.0, 20.0, 1.0), (15.0, 5.0, 0.625)])
def test_noise_is_a_poisson_process_in_every_pixel(noise_hz: float, leak_hz: float, on_share: float) -> None:
    model = replace(IDEAL, noise_hz=noise_hz, leak_hz=leak_hz)
    events, _ = watch(model, levels(*[0.0] * 51, width=40, height=30, step_us=40_000))
    expected = 20.0 * 1_200 * 2.0
    assert abs(len(events) - expected) < 5 * np.sqrt(expected)
    assert events.p.mean() == pytest.approx(on_share, abs=0.01)
    counted = np.bincount(events.y.astype(int) * 40 + events.x, minlength=1_200)
    assert counted.var() / counted.mean() == pytest.approx(1.0, abs=0.2)
    between = gaps(events, 40)
    assert np.mean(between < 50_000 * np.log(2)) == pytest.approx(0.5, abs=0.02)


def test_hot_pixels_are_where_they_say_and_keep_time() -> None:
    model = replace(IDEAL, noise_hz=1.0, hot_pixels=4, hot_hz=1_000.0)
    events, camera = watch(model, levels(*[0.0] * 101, width=40, height=30, step_us=10_000))
    counted = np.bincount(events.y.astype(int) * 40 + events.x, minlength=1_200)
    found = np.flatnonzero(counted > 500)
    assert sorted(found.tolist()) == sorted((camera.hot[:, 1] * 40 + camera.hot[:, 0]).tolist())
    assert len(set(found)) == 4
    for x, y in camera.hot.tolist():
        mine = events.where((events.x == x) & (events.y == y))
        assert abs(len(mine) - 1_000) <= 5
        beats = np.diff(mine.t_us)
        assert np.median(beats) == 1_000
        assert np.mean(mine.p == np.median(mine.p)) > 0.99


def test_an_event_of_its_own_resets_a_pixel_to_the_light() -> None:
    """One pixel that fires every 100 us: light that rises by a threshold in 1 ms never gets there."""
    model = replace(IDEAL, hot_pixels=1, hot_hz=10_000.0)
    quiet, _ = watch(IDEAL, levels(0.0, 0.2, 0.4, 0.6))
    hot, _ = watch(model, levels(0.0, 0.2, 0.4, 0.6))
    assert len(quiet) == 3
    assert len(hot) == 30
    assert set(np.diff(hot.t_us).tolist()) <= {99, 100, 101}


@pytest.mark.parametrize("refractory_us", [0, 900])
def test_rectangles_of_change_give_the_same_events_as_full_frames(refractory_us: int) -> None:
    """A patch of random light that wanders; rectangles may overlap, and may be larger than what changed."""
    model = PixelModel(0.1, 0.1, 0.1, refractory_us, noise_hz=50.0, leak_hz=5.0, hot_pixels=2, hot_hz=500.0)
    random = np.random.default_rng(SEED)
    frame = random.normal(size=(30, 40))
    full, patched = (PixelCamera(model, 40, 30, SEED) for _ in range(2))
    full.step(frame.copy(), 0)
    patched.step(frame.copy(), 0)
    total = 0
    for i in range(1, 80):
        left, top = int(random.integers(0, 30)), int(random.integers(0, 20))
        frame[top : top + 8, left : left + 10] = random.normal(size=(8, 10))
        rectangles = np.array([[left, top, left + 7, top + 10], [left + 4, top, min(left + 12, 40), top + 9]])
        events = patched.step(frame, 500 * i, rectangles)
        assert content(events) == content(full.step(frame.copy(), 500 * i))
        total += len(events)
    assert total > 5_000


@pytest.mark.parametrize("refractory_us", [0, 900])
def test_linear_frames_give_the_same_events_as_their_logarithms(refractory_us: int) -> None:
    """Light that drifts slowly, so that many frames end near a threshold, and is sometimes exactly on one."""
    model = PixelModel(0.1, 0.15, 0.1, refractory_us, noise_hz=20.0, hot_pixels=2, hot_hz=500.0)
    random = np.random.default_rng(SEED)
    linear, logarithmic = PixelCamera(model, 40, 30, SEED, linear=True), PixelCamera(model, 40, 30, SEED)
    levels, total = np.zeros((30, 40)), 0
    for i in range(80):
        light = np.exp(levels)
        events = linear.step(light, 500 * i)
        assert content(events) == content(logarithmic.step(levels_of(light, True), 500 * i))
        levels += random.normal(0, 0.05, (30, 40))
        levels[:5] = linear.on_threshold[:5] * (i % 4)
        total += len(events)
    assert total > 5_000


def test_events_of_a_step_are_in_time_order_and_steps_follow_each_other() -> None:
    random = np.random.default_rng(SEED)
    model = PixelModel(0.1, 0.1, 0.1, 50, noise_hz=50.0, hot_pixels=2)
    events, _ = watch(model, [(137 * i, random.normal(size=(30, 40))) for i in range(30)])
    assert (np.diff(events.t_us) >= 0).all()
    assert events.t_us[0] >= 0
    assert events.t_us[-1] <= 29 * 137


def test_equal_seeds_give_equal_events_and_others_do_not() -> None:
    model = PixelModel(0.1, 0.1, 0.1, 50, noise_hz=50.0, leak_hz=1.0, hot_pixels=2)
    frames = [(1_000 * i, np.random.default_rng(i).normal(size=(12, 16))) for i in range(20)]
    once, again, other = (content(watch(model, frames, seed)[0]) for seed in (1, 1, 2))
    assert once == again
    assert once != other


def test_noise_does_not_depend_on_how_time_is_cut() -> None:
    model = replace(IDEAL, noise_hz=50.0, leak_hz=3.0, hot_pixels=2, hot_hz=700.0)
    coarse, _ = watch(model, levels(*[0.0] * 3, width=16, height=12, step_us=60_000))
    fine, _ = watch(model, levels(*[0.0] * 121, width=16, height=12, step_us=1_000))
    assert content(coarse) == content(fine)
    assert len(coarse) > 1_000


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"on_threshold": 0.0}, "pixel.on_threshold = 0.0: must be from 0.01 to 5 (rise of log intensity, to base e, that"),
        ({"mismatch": 0.6}, "pixel.mismatch = 0.6: must be from 0 to 0.5 (standard deviation of thresholds"),
        ({"refractory_us": 0.5}, "pixel.refractory_us = 0.5: must be from 0 to 1000000 (time after an event"),
        ({"noise_hz": float("nan")}, "pixel.noise_hz = nan: must be from 0 to 1000 (background activity"),
        ({"hot_pixels": True}, "pixel.hot_pixels = True: must be from 0 to 1000000 (how many pixels fire all the time)"),
    ],
)
def test_a_model_outside_its_range_is_refused(change: dict[str, Any], message: str) -> None:
    with refused(ConfigError, start=message):
        replace(IDEAL, **change)


def test_frames_and_times_that_make_no_sense_are_refused() -> None:
    camera, frame = PixelCamera(IDEAL, 4, 3, SEED), np.zeros((3, 4))
    camera.step(frame, 10)
    for message, wrong, t_us, changed in (
        ("frame: float64 (4, 3): must be float64 (3, 4)", np.zeros((4, 3)), 20, None),
        ("frame: float32 (3, 4): must be float64 (3, 4)", np.zeros((3, 4), np.float32), 20, None),
        ("t_us = 10: must be from 1 to 1073741824 us after the last frame's 10", frame, 10, None),
        ("changed: must lie within the sensor's 4x3 pixels", frame, 20, np.array([[0, 0, 5, 3]])),
    ):
        with refused(ConfigError, message):
            camera.step(wrong, t_us, changed)
    values: tuple[tuple[bool, float], ...] = (
        *((False, value) for value in (np.nan, np.inf, -np.inf, 101.0)),
        *((True, value) for value in (0.0, -1.0, np.nan, np.inf)),
    )  # fmt: skip
    for linear, value in values:
        broken = np.full((3, 4), float(linear))
        broken[2, 1] = value
        started = PixelCamera(IDEAL, 4, 3, SEED, linear=linear)
        told = rf"^frame: log intensity {'.*' if linear else f'{value:g}'} at \(1, 2\): must be from -100 to 100$"
        with pytest.raises(ConfigError, match=told):
            started.step(broken, 0)
        started.step(np.full((3, 4), float(linear)), 0)
        with pytest.raises(ConfigError, match=told):
            started.step(broken, 10)
    with pytest.raises(ConfigError, match="hot_pixels = 13: must be at most the sensor's 12 pixels"):
        PixelCamera(replace(IDEAL, hot_pixels=13), 4, 3, SEED)


def keys_of(count: int, span_us: int, side: int, seed: int) -> np.ndarray:
    random = np.random.default_rng(seed)
    t_us, x, y, p = (random.integers(0, high, count) for high in (span_us, side, side, 2))
    return 1_000 + t_us << KEY_T_SHIFT | x << 17 | y << 1 | p


@pytest.mark.parametrize("count", [0, 1, 2, 20_000])
@pytest.mark.parametrize("span_us", [1, 50, 3_000, 2**30 - 1_000])
@pytest.mark.parametrize("side", [2, 65_536])
def test_events_come_by_time_then_x_then_y_then_polarity(count: int, span_us: int, side: int) -> None:
    """Few or many, of one microsecond or of 18 minutes, with equals among them."""
    keys = keys_of(count, span_us, side, seed=count)
    given = keys.copy()
    events = events_of(keys, 2**30)
    ordered = np.sort(keys)
    np.testing.assert_array_equal(events.t_us, ordered >> KEY_T_SHIFT)
    np.testing.assert_array_equal(events.x, ordered >> 17 & 0xFFFF)
    np.testing.assert_array_equal(events.y, ordered >> 1 & 0xFFFF)
    np.testing.assert_array_equal(events.p, ordered & 1)
    np.testing.assert_array_equal(keys, given)


def test_events_at_the_end_or_later_are_left_out() -> None:
    keys = np.array([[t << KEY_T_SHIFT | x << 17 for x in range(300)] for t in (7, 9, 10, 11)]).ravel()
    assert np.unique(events_of(keys, 10).t_us).tolist() == [7, 9]

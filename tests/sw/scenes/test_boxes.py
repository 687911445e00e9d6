# SPDX-License-Identifier: Apache-2.0
"""The box experiment: its events, compared with the paths of the boxes in the truth."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.errors import ConfigError
from evcot.events import Events
from evcot.scenes import BoxExperiment, Scene, simulate
from evcot.scenes.truth import Box
from support.refusals import refused

DEFAULT = BoxExperiment()
NOISELESS = replace(DEFAULT, noise_hz_per_px=0.0, flicker_hz_per_px=0.0)
EXACT = replace(NOISELESS, jitter_us=0)
STEADY, SLOW_BRIGHT, SLOW_DARK, STOPPING, FAST_STEADY, FAST_BRIGHT, FAST_DARK, LEAVING, ENTERING = range(9)


@pytest.fixture(scope="module")
def default_scene() -> Scene:
    return simulate(DEFAULT)


@pytest.fixture(scope="module")
def noiseless_scene() -> Scene:
    return simulate(NOISELESS)


def depth(box: Box, events: Events) -> NDArray[np.float64]:
    """How deep inside a box's contour each event lies at its time, pixels; negative outside."""
    x, y = box.centre(events.t_us)
    return np.minimum(box.width / 2 - abs(events.x - x), box.height / 2 - abs(events.y - y))


def lane_of(events: Events, lane: int, config: BoxExperiment = DEFAULT) -> Events:
    low, high = (config.height * edge / 6 - 0.5 for edge in (lane, lane + 1))
    mask = (events.y >= low) & (events.y < high)
    return Events(events.t_us[mask], events.x[mask], events.y[mask], events.p[mask])


@pytest.mark.parametrize(
    "config", [DEFAULT, BoxExperiment(64, 64), BoxExperiment(640, 480), BoxExperiment(128, 256, speed="fast")]
)
def test_events_are_a_recording_in_time_order_on_the_sensor(config: BoxExperiment) -> None:
    recording = simulate(config).recording  # refuses an event outside the sensor or out of order
    events = recording.events
    assert (recording.width, recording.height) == (config.width, config.height)
    assert len(events) > 50_000
    assert events.t_us[0] >= 0
    assert events.t_us[-1] < config.duration_us
    assert [field.dtype for field in (events.t_us, events.x, events.y, events.p)] == [np.int64, np.uint16, np.uint16, np.uint8]


def test_another_seed_gives_other_events_of_the_same_truth(default_scene: Scene) -> None:
    events, other = default_scene.recording.events, simulate(replace(DEFAULT, seed=2))
    assert 400_000 < len(events) < 600_000
    assert 0.4 < events.p.mean() < 0.6
    assert not np.array_equal(events.t_us, other.recording.events.t_us)
    np.testing.assert_array_equal(other.truth.samples, default_scene.truth.samples)
    assert (default_scene.seed, other.seed) == (1, 2)


def test_every_event_free_of_noise_lies_within_a_pixel_of_a_contour(noiseless_scene: Scene) -> None:
    events = noiseless_scene.recording.events
    distance = np.min([abs(depth(box, events)) for box in noiseless_scene.truth.boxes], axis=0)
    assert distance.max() <= 1.0


def test_without_jitter_an_event_is_where_its_threshold_lies_to_a_microsecond() -> None:
    """Of 4 thresholds across an edge of one pixel, the levels lie at depths -3/8, -1/8, 1/8 and 3/8."""
    scene = simulate(EXACT)
    events = lane_of(scene.recording.events, 0)
    depths = depth(scene.truth.boxes[STEADY], events)
    level = (depths + 0.375) * 4
    per_us = 2 * EXACT.slow_px_s * 1e-6 * 4
    assert abs(level - np.rint(level)).max() <= per_us
    assert np.bincount(np.rint(level).astype(int)).min() > 0.2 * len(events)


@pytest.mark.parametrize(("lane", "number"), [(0, STEADY), (3, FAST_STEADY)])
def test_the_leading_edge_brings_what_the_box_is_and_the_trailing_edge_takes_it_away(
    noiseless_scene: Scene, lane: int, number: int
) -> None:
    box = noiseless_scene.truth.boxes[number]
    events = lane_of(noiseless_scene.recording.events, lane)
    x, y = box.centre(events.t_us)
    vx, _ = box.velocity(events.t_us)
    ahead = np.sign(events.x - x) == np.sign(vx)
    # Away from the corners, where a slanted path also covers and uncovers rows, and from the turns.
    sides = (abs(events.x - x) > box.width / 2 - 2) & (abs(events.y - y) < box.height / 2 - 2)
    steady = np.min([abs(events.t_us - turn) for turn in box.t_us[1:-1]] or [np.full(len(events), 10_000)], axis=0) > 5_000
    mask = sides & steady
    assert np.count_nonzero(mask) > 10_000
    np.testing.assert_array_equal(events.p[mask] == 1, (ahead == box.brighter)[mask])


def test_each_pixel_that_an_edge_crosses_sees_every_threshold_once() -> None:
    """A pixel that a box has passed over altogether is back where it was: as many ON as OFF events, one per threshold each."""
    scene = simulate(EXACT)
    box = scene.truth.boxes[STEADY]
    events = lane_of(scene.recording.events, 0)
    row = round(float(box.y.mean()))
    first, last = (float(x) for x in (box.x[0], box.x[-1]))
    for column in range(round(first + box.width / 2) + 2, round(last - box.width / 2) - 2, 7):
        at = (events.x == column) & (events.y == row)
        assert np.count_nonzero(at & (events.p == 1)) == EXACT.contrast_steps
        assert np.count_nonzero(at & (events.p == 0)) == EXACT.contrast_steps


@pytest.mark.parametrize("speed", ["slow", "fast", "both"])
def test_every_pixel_sees_what_a_slow_walk_through_the_pixel_model_sees(speed: Any) -> None:
    """Each box's log intensity looked at every 100 us, in every pixel: the same ON and OFF events, none more, none less."""
    config = replace(EXACT, width=64, height=64, duration_us=200_000, speed=speed, side_px=6.0)
    events = simulate(config).recording.events
    counted = np.zeros((2, 64, 64), int)
    np.add.at(counted, (events.p, events.y, events.x), 1)
    walked = np.zeros((2, 64, 64), int)
    grid_y, grid_x = np.mgrid[:64, :64]
    times = np.append(np.arange(0.0, config.duration_us, 100.0), config.duration_us - 0.5)
    for box in config.boxes:
        before = None
        for x, y in zip(*box.centre(times), strict=True):
            inside = np.minimum(box.width / 2 - abs(grid_x - x), box.height / 2 - abs(grid_y - y))
            level = np.rint(config.contrast_steps * np.clip(inside + 0.5, 0, 1)).astype(int) * (1 if box.brighter else -1)
            if before is not None:
                walked[1] += np.maximum(level - before, 0)
                walked[0] += np.maximum(before - level, 0)
            before = level
    assert walked.sum() > 5_000
    np.testing.assert_array_equal(counted, walked)


def test_contrast_sets_the_number_of_events(noiseless_scene: Scene) -> None:
    counts = {steps: len(simulate(replace(NOISELESS, contrast_steps=steps)).recording.events) for steps in (1, 2, 8)}
    for steps, count in counts.items():
        assert count / len(noiseless_scene.recording.events) == pytest.approx(steps / NOISELESS.contrast_steps, rel=0.03)


def test_noise_is_a_poisson_process_in_every_pixel() -> None:
    config = replace(DEFAULT, noise_hz_per_px=20.0)
    noisy, quiet = simulate(config), simulate(replace(config, noise_hz_per_px=0.0))
    expected = 20.0 * 346 * 260 * 2.5
    count = len(noisy.recording.events) - len(quiet.recording.events)
    assert abs(count - expected) < 5 * np.sqrt(expected)
    # Where no box ever comes: between the lanes' middles.
    events = noisy.recording.events
    row = round(260 / 6)
    band = events.y == row
    per_pixel = np.bincount(events.x[band], minlength=346)
    assert per_pixel.mean() == pytest.approx(50.0, rel=0.05)
    assert per_pixel.var() == pytest.approx(per_pixel.mean(), rel=0.4)
    assert events.p[band].mean() == pytest.approx(0.5, abs=0.03)
    assert np.histogram(events.t_us[band], 5, (0, 2_500_000))[0] / band.sum() == pytest.approx([0.2] * 5, abs=0.02)


def test_flicker_stays_on_the_contour_of_moving_boxes() -> None:
    config = replace(EXACT, flicker_hz_per_px=200.0)
    scene, plain = simulate(config), simulate(EXACT)
    events = scene.recording.events
    added = len(events) - len(plain.recording.events)
    side = scene.truth.boxes[0].width
    moving_s = sum(float(np.diff(box.t_us)[np.diff(box.x) != 0].sum()) * 1e-6 for box in scene.truth.boxes)
    assert 0.8 < added / (200.0 * 4 * side * moving_s) <= 1.01  # some of it off the sensor
    assert np.min([abs(depth(box, events)) for box in scene.truth.boxes], axis=0).max() <= 1.0
    stopped = (events.t_us > 0.36 * config.duration_us) & (events.t_us < 0.64 * config.duration_us)
    assert not np.count_nonzero(stopped & (abs(depth(scene.truth.boxes[STOPPING], events)) < 2))


def test_a_box_that_stops_is_silent_until_it_starts_again(noiseless_scene: Scene) -> None:
    events = lane_of(noiseless_scene.recording.events, 2)
    stop_us, go_us = 0.35 * DEFAULT.duration_us, 0.65 * DEFAULT.duration_us
    silent = (events.t_us > stop_us + DEFAULT.jitter_us) & (events.t_us < go_us)
    assert not silent.any()
    assert np.count_nonzero(events.t_us <= stop_us) > 5_000
    assert np.count_nonzero(events.t_us >= go_us) > 5_000
    samples = noiseless_scene.truth.samples
    samples = samples[(samples["object_id"] == STOPPING) & (samples["t_us"] > stop_us) & (samples["t_us"] < go_us)]
    assert not samples["vx"].any()
    assert samples["visible"].all()


@pytest.mark.parametrize(("left", "right"), [(SLOW_BRIGHT, SLOW_DARK), (FAST_BRIGHT, FAST_DARK)])
def test_two_boxes_meet_and_cross(noiseless_scene: Scene, left: int, right: int) -> None:
    samples = noiseless_scene.truth.samples
    gap = samples["x"][samples["object_id"] == right] - samples["x"][samples["object_id"] == left]
    side = noiseless_scene.truth.boxes[left].width
    assert gap[0] > 3 * side
    assert abs(gap).min() < 1.0
    assert gap.min() < -3 * side
    np.testing.assert_array_equal(noiseless_scene.truth.boxes[left].y, noiseless_scene.truth.boxes[left].y[0])
    assert noiseless_scene.truth.boxes[left].y[0] == noiseless_scene.truth.boxes[right].y[0]


def test_one_box_leaves_before_another_enters(noiseless_scene: Scene) -> None:
    samples = noiseless_scene.truth.samples
    leaving, entering = (samples[samples["object_id"] == number] for number in (LEAVING, ENTERING))
    assert leaving["visible"][0]
    assert not leaving["visible"][leaving["t_us"] > 0.4 * DEFAULT.duration_us].any()
    assert not entering["visible"][entering["t_us"] < 0.5 * DEFAULT.duration_us].any()
    assert entering["visible"][-1]
    events = lane_of(noiseless_scene.recording.events, 5)
    between = (events.t_us > 0.41 * DEFAULT.duration_us) & (events.t_us < 0.5 * DEFAULT.duration_us)
    assert not between.any()


@pytest.mark.parametrize("speed", ["slow", "fast", "both"])
def test_the_situation_sets_the_speed_of_each_lane(speed: Any) -> None:
    config = BoxExperiment(speed=speed)
    lanes = {"slow": [80.0] * 6, "fast": [400.0] * 6, "both": [80.0] * 3 + [400.0] * 3}[speed]
    assert list(config.speeds_px_s) == lanes
    for number, lane in enumerate((0, 1, 1, 2, 3, 4, 4, 5, 5)):
        box = config.boxes[number]
        speeds = {round(abs(v), 6) for v in box.velocity(np.linspace(0, config.duration_us - 1, 500))[0].tolist()}
        assert speeds - {0.0} == {lanes[lane]}


@pytest.mark.parametrize("speed", ["slow", "fast", "both"])
@pytest.mark.parametrize(("width", "height"), [(64, 64), (346, 260), (1280, 720)])
def test_in_every_situation_the_boxes_stay_where_they_should(width: int, height: int, speed: Any) -> None:
    config = BoxExperiment(width, height, speed=speed)
    times = np.linspace(0, config.duration_us, 5_000)
    for number, box in enumerate(config.boxes):
        x, y = box.centre(times)
        assert (y - box.height / 2 >= -0.5).all()
        assert (y + box.height / 2 <= height - 0.5).all()
        if number not in (LEAVING, ENTERING):
            assert (x - box.width / 2 >= -0.5 - 1e-9).all()
            assert (x + box.width / 2 <= width - 0.5 + 1e-9).all()


def test_truth_is_sampled_by_time_and_object(default_scene: Scene) -> None:
    samples = default_scene.truth.samples
    np.testing.assert_array_equal(samples["t_us"], np.repeat(np.arange(0, 2_500_000, 1_000), 9))
    np.testing.assert_array_equal(samples["object_id"], np.tile(np.arange(9), 2_500))
    for number, box in enumerate(default_scene.truth.boxes):
        mine = samples[samples["object_id"] == number]
        np.testing.assert_array_equal([mine["x"], mine["y"]], box.centre(mine["t_us"]))
        assert set(mine["width"]) == {box.width} == {12.0}
    assert {box.width for box in BoxExperiment(side_px=30.0).boxes} == {30.0}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"width": 63}, "width = 63: must be from 64 to 4096 (pixels of the sensor across)"),
        ({"height": 64.0}, "height = 64.0: must be from 64 to 4096 (pixels of the sensor down)"),
        ({"duration_us": 0}, "duration_us = 0: must be from 1000 to 1000000000 (length of the scene)"),
        ({"noise_hz_per_px": -0.1}, "noise_hz_per_px = -0.1: must be from 0 to 1000 (background events per pixel and second)"),
        ({"slow_px_s": float("nan")}, "slow_px_s = nan: must be from 1 to 10000 (speed of a slow box)"),
        ({"seed": True}, "seed = True: must be from 0 to 9223372036854775807 (seed of all noise)"),
        ({"speed": "warp"}, "speed = 'warp': must be one of slow, fast, both"),
        ({"side_px": 44.0}, "side_px = 44: must be 0, or from 1 to a lane's 43.3 pixels"),
        ({"side_px": 0.5}, "side_px = 0.5: must be 0, or from 1 to a lane's 43.3 pixels"),
    ],
)
def test_settings_outside_their_range_are_refused(change: dict[str, Any], message: str) -> None:
    with refused(ConfigError, f"boxes.{message}"):
        replace(DEFAULT, **change)

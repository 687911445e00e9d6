# SPDX-License-Identifier: Apache-2.0
"""Every filmed scene: shapes, motion and events agree with the truth."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.errors import ConfigError
from evcot.events import Events
from evcot.scenes import discs, highway, insects, pendulum, shake
from evcot.scenes._order import KEY_T_SHIFT
from evcot.scenes._pixel_kernel import exponential, levels_of
from evcot.scenes._render_kernel import bounds, displacement, draw
from evcot.scenes.pixel import PixelCamera, PixelModel
from evcot.scenes.registry import SCENES, scene_settings, simulate_scene
from evcot.scenes.shapes import OBJECT, X, Y, quadrangles
from evcot.scenes.shapes import discs as circles
from evcot.scenes.stage import _Canvas, _samples
from evcot.scenes.truth import Scene
from support.refusals import refused

FILMED = {"discs": discs, "highway": highway, "insects": insects, "pendulum": pendulum, "shake": shake}
QUIET = PixelModel(0.2, 0.2)
SHORT = {"duration_us": 300_000}


def content(scene: Scene) -> bytes:
    events = scene.recording.events
    return b"".join(part.tobytes() for part in (events.t_us, events.x, events.y, events.p, scene.truth.samples))


def stage_of(name: str, **overrides: Any) -> Any:
    return FILMED[name]._Stage(scene_settings(name, 3, overrides))


def truth_of(name: str, **overrides: Any) -> NDArray[np.void]:
    """The truth of 4 s, every 10 ms."""
    return _samples(stage_of(name, **overrides), range(0, 4_000_000, 10_000), (346, 260))


def drawn(shapes: NDArray[np.float64], width: int, height: int) -> NDArray[np.float64]:
    """Linear intensity of shapes before a background of 1."""
    background, picture = np.ones((height, width)), np.empty((height, width))
    draw(np.array([[0, 0, width, height]]), shapes, background, picture)
    return picture


@pytest.mark.parametrize("name", FILMED)
def test_a_frame_that_is_redrawn_where_something_moved_is_the_whole_frame_redrawn(name: str) -> None:
    stage, times_us = stage_of(name), range(0, 400_000, 3_001)
    canvas, whole = _Canvas(stage, 346, 260), np.empty((260, 346))
    picture = canvas.picture.copy()
    for t_us in times_us:
        canvas.look(t_us)
        for left, top, right, bottom in canvas.draw().tolist():
            picture[top:bottom, left:right] = canvas.picture[top:bottom, left:right]
        shapes = canvas.advance()
        draw(np.array([[0, 0, 346, 260]]), shapes, canvas.background, whole)
        assert np.array_equal(picture, whole)


@pytest.mark.parametrize(
    ("name", "overrides"),
    [
        ("discs", {}),
        ("highway", {}),
        ("insects", {"radius_px": 4.0, "speed_px_s": 900.0}),
        ("pendulum", {}),
        ("shake", {"shake_px": 0.0}),
    ],
)
@pytest.mark.parametrize("refractory_us", [0, 300, 4_000])
def test_a_batch_of_frames_gives_the_events_of_each_alone(name: str, overrides: dict[str, float], refractory_us: int) -> None:
    """With noise, hot pixels, and shapes that move by several pixels from frame to frame."""
    model = PixelModel(0.1, 0.15, mismatch=0.1, refractory_us=refractory_us, noise_hz=5.0, hot_pixels=3, hot_hz=2_000.0)
    canvas, alone, at_once = (
        _Canvas(stage_of(name, **overrides), 346, 260),
        *(PixelCamera(model, 346, 260, 1, linear=True) for _ in range(2)),
    )
    for camera in (alone, at_once):
        camera.step(canvas.picture, 0)
    batch, times_us, keys = [canvas.shapes], [0], [np.empty(0, np.int64)]
    compared = 0
    for t_us in range(2_000, 200_000, 2_000):
        canvas.look(t_us)
        alike, changed = canvas.is_alike, canvas.draw()
        if len(batch) > 1 and (not alike or len(batch) == 9):
            found = at_once.keys_of_shapes(np.stack(batch), np.array(times_us), canvas.background)
            expected = np.concatenate(keys)
            assert np.array_equal(found, expected)
            compared += len(found)
            batch, times_us, keys = batch[-1:], times_us[-1:], keys[:0]
        keys.append(alone.keys(canvas.picture, t_us, changed) + (times_us[-1] - times_us[0] << KEY_T_SHIFT))
        if not alike:
            at_once.keys(canvas.picture, t_us, changed)
            batch, times_us, keys = [], [], keys[:0]
        batch.append(canvas.advance())
        times_us.append(t_us)
    assert compared > 5_000


@pytest.mark.parametrize("name", ["discs", "insects", "pendulum", "shake"])
def test_many_times_at_once_give_what_each_gives_alone(name: str) -> None:
    stage, times_us = stage_of(name), np.arange(0, 900_000, 7_001)
    assert stage.shapes(times_us).tobytes() == b"".join(stage.shapes(int(t_us)).tobytes() for t_us in times_us)
    assert stage.objects(times_us).tobytes() == b"".join(stage.objects(int(t_us)).tobytes() for t_us in times_us)


def moved(before: NDArray[np.float64], after: NDArray[np.float64]) -> float:
    """The displacement of shapes on a sensor of 100x80."""
    return float(displacement(before, after, 100, 80)[0])


def rectangle(left: float, right: float, top: float = 20.0, bottom: float = 40.0) -> NDArray[np.float64]:
    return quadrangles(0, np.array([[left, right, right, left]]), np.array([[top, top, bottom, bottom]]), 2.0)


def test_displacement_is_that_of_contours_across_themselves_where_they_are_on_the_sensor() -> None:
    assert moved(rectangle(10, 30), rectangle(10.3, 30.2)) == pytest.approx(0.3)
    assert moved(rectangle(10, 1_000), rectangle(10.1, 1_050)) == pytest.approx(0.1)
    assert moved(rectangle(-50, 130, 20, 40), rectangle(-60, 190, 20, 40.2)) == pytest.approx(0.2)
    assert moved(rectangle(200, 300), rectangle(250, 350)) == 0
    turned = quadrangles(0, np.array([[0.0, 40, 40, 0]]), np.array([[0.0, 30, 60, 30]]), 2.0)
    along = turned.copy()
    along[:, X : X + 4] += 4  # its first and third edge go along themselves, 5 px, the others 0 and 4 px
    along[:, Y : Y + 4] += 3
    assert moved(turned, along) == pytest.approx(4.0)
    assert moved(circles(0, [10.0], 10, 3, 2), circles(0, [10.4], 10.1, 3.2, 2)) == pytest.approx(0.6)
    assert moved(circles(0, [110.0], 10, 3, 2), circles(0, [115.0], 10, 3, 2)) == 0


def test_vehicles_that_have_left_the_picture_do_not_make_steps_shorter() -> None:
    """Below the picture a car of 20 m/s moves by thousands of pixels per second; in it, by some hundreds."""
    canvas = _Canvas(stage_of("highway", duration_us=4_000_000), 346, 260)
    displacements = []
    for t_us in range(0, 4_000_000, 1_000):
        displacements.append(canvas.look(t_us))
        canvas.advance()
    assert max(displacements) < 1


def test_logarithms_are_right_to_an_ulp_and_exponentials_to_1e_8() -> None:
    uniform = np.random.default_rng(1).uniform(-1, 1, 9_000)
    values = np.exp(np.concatenate((80 * uniform, np.linspace(-1e-3, 1e-3, 1_001))))
    found = levels_of(values[None], True)[0]
    assert (abs(found - np.log(values)) <= np.spacing(abs(np.log(values)))).all()
    values = np.concatenate((200 * uniform, np.linspace(-1, 1, 1_001)))
    found = np.array([exponential.py_func(value) for value in values])
    assert (abs(found / np.exp(values) - 1) < 1e-8).all()


def of_object(samples: NDArray[np.void], number: int) -> NDArray[np.void]:
    return samples[samples["object_id"] == number]


@pytest.mark.parametrize("name", SCENES)
def test_equal_seeds_give_equal_bytes_and_other_seeds_other_events(name: str) -> None:
    once, again, other = (simulate_scene(name, seed, SHORT) for seed in (4, 4, 5))
    assert content(once) == content(again)
    assert content(once) != content(other)
    events = once.recording.events  # a Recording refuses events out of order or off the sensor
    assert len(events) > 5_000
    assert events.t_us[-1] < SHORT["duration_us"]
    assert 0.2 < events.p.mean() < 0.8
    assert once.seed == 4


@pytest.mark.parametrize("name", FILMED)
def test_velocities_are_the_derivatives_of_positions(name: str) -> None:
    """Central differences over 20 us, at moments all over the scene; only turns, where there is no derivative, may differ."""
    stage = stage_of(name, duration_us=4_000_000)
    wrong = compared = 0
    for t_us in np.linspace(1_000, 3_990_000, 150):
        before, now, after = (stage.objects(float(t)) for t in (t_us - 10, t_us, t_us + 10))
        kept = [set(each["object_id"]) for each in (before, now, after)]
        both = sorted(kept[0] & kept[1] & kept[2])
        before, now, after = (each[np.isin(each["object_id"], both)] for each in (before, now, after))
        for place, speed in (("x", "vx"), ("y", "vy")):
            found = (after[place] - before[place]) / 20e-6
            wrong += np.count_nonzero(abs(found - now[speed]) > 0.05 + 1e-3 * abs(now[speed]))
            compared += len(both)
    assert compared >= 300
    assert wrong <= 0.01 * compared


@pytest.mark.parametrize(
    ("name", "overrides", "number"),
    [
        ("discs", {"count": 1}, 0),
        ("insects", {"count": 1, "blades": 0, "glints": 0}, 0),
        ("pendulum", {"length_px": 120.0, "angle_deg": 20.0}, 0),
        ("pendulum", {"length_px": 120.0, "angle_deg": 20.0}, 1),
        ("shake", {"count": 1}, 0),
    ],
)
def test_what_is_drawn_has_its_centroid_and_its_box_where_the_truth_says(
    name: str, overrides: dict[str, Any], number: int
) -> None:
    stage = stage_of(name, **overrides)
    grid_y, grid_x = np.mgrid[:260, :346]
    compared = 0
    for t_us in range(0, 2_000_000, 37_003):
        truth = of_object(stage.objects(t_us), number)[0]
        half = truth["width"] / 2 + 2, truth["height"] / 2 + 2
        if not (half[0] < truth["x"] < 345 - half[0] and half[1] - 4 < truth["y"] < 259 - half[1]):
            continue
        shapes = stage.shapes(t_us)
        shapes = shapes[shapes[:, OBJECT] == number]
        part = abs(drawn(shapes, 346, 260) - 1)
        if part[0].any():
            part = part[1:]  # the rod hangs from the edge
            assert (part.sum(axis=1) > 0).sum() == pytest.approx(truth["height"], abs=2.0)
        else:
            assert (part * grid_x).sum() / part.sum() == pytest.approx(truth["x"], abs=0.1)
            assert (part * grid_y).sum() / part.sum() == pytest.approx(truth["y"], abs=0.1)
        sides = np.array([bounds(shape) for shape in shapes])
        assert sides[:, 2].max() - sides[:, 0].min() == pytest.approx(truth["width"], abs=1e-6)
        assert (sides[:, 2].max() + sides[:, 0].min()) / 2 == pytest.approx(truth["x"], abs=1e-6)
        assert (sides[:, 3].max() + sides[:, 1].min()) / 2 == pytest.approx(truth["y"], abs=1e-6)
        compared += 1
    assert compared > 20


def test_a_vehicle_is_drawn_within_its_box_and_fills_it() -> None:
    """All faces but the shadow; to half a pixel, where the contour's own pixel ends."""
    stage = stage_of("highway")
    compared = 0
    for t_us in range(0, 4_000_000, 250_000):
        for truth in stage.objects(t_us):
            left, top = truth["x"] - truth["width"] / 2, truth["y"] - truth["height"] / 2
            right, bottom = truth["x"] + truth["width"] / 2, truth["y"] + truth["height"] / 2
            if left < 2 or top < 2 or right > 343 or bottom > 257:
                continue
            shapes = stage.shapes(t_us)
            faces = shapes[shapes[:, OBJECT] == truth["object_id"]][1:]
            rows, columns = np.nonzero(drawn(faces, 346, 260) != 1)
            assert (columns.min(), rows.min()) == (pytest.approx(left, abs=1.0), pytest.approx(top, abs=1.0))
            assert (columns.max(), rows.max()) == (pytest.approx(right, abs=1.0), pytest.approx(bottom, abs=1.0))
            compared += 1
    assert compared > 30


def test_an_edge_that_passes_makes_floor_of_contrast_over_threshold_events_in_each_pixel() -> None:
    """A disc that crosses the sensor on a row of its own: ON and OFF, as many as thresholds fit into its contrast."""
    settings = discs.Discs(
        width=128, height=64, duration_us=400_000, count=1, radius_px=8.0, speed_px_s=150.0, speed_spread=0.0, contrast=0.9,
        ways="separate", pixel=QUIET, seed=2,
    )  # fmt: skip
    scene = discs.simulate(settings)
    events, samples = scene.recording.events, scene.truth.samples
    assert np.ptp(samples["x"]) > 40
    assert not np.diff(np.sign(samples["vx"])).any(), "it does not turn"
    row = round(float(samples["y"][0]))
    off, on = (np.bincount(events.x[(events.y == row) & (events.p == p)], minlength=128) for p in (0, 1))
    # Columns that the whole disc has passed, and whose texture is nearly that of the background.
    passed = np.arange(int(samples["x"].min() + 10) + 1, int(samples["x"].max() - 10))
    assert abs(np.median(off[passed]) - 4) <= 1
    assert (abs(off[passed] - on[passed]) <= 1).all()


@pytest.mark.parametrize("name", ["discs", "pendulum"])
def test_events_free_of_noise_lie_on_the_contours(name: str) -> None:
    """Within a pixel and a half of a disc's contour, or of the rod."""
    scene = FILMED[name].simulate(replace(scene_settings(name, 3, SHORT), pixel=QUIET))
    events, samples = scene.recording.events, scene.truth.samples
    step = events.t_us // 1_000
    nearest = np.full(len(events), np.inf)
    for number in np.unique(samples["object_id"]):
        if name == "pendulum" and number == pendulum.ROD:
            continue
        mine = of_object(samples, int(number))[step]
        ahead = (events.t_us - mine["t_us"]) * 1e-6
        distance = np.hypot(events.x - mine["x"] - mine["vx"] * ahead, events.y - mine["y"] - mine["vy"] * ahead)
        nearest = np.minimum(nearest, abs(distance - mine["width"] / 2))
    if name == "pendulum":
        bob = of_object(samples, pendulum.BOB)[step]
        middle = (346 - 1) / 2
        angle = np.arctan2(bob["x"] - middle, bob["y"] + 0.5)
        nearest = np.minimum(nearest, abs((events.x - middle) * np.cos(angle) - (events.y + 0.5) * np.sin(angle)))
        assert np.mean(nearest < 2.6) > 0.999
    else:
        assert np.mean(nearest < 1.5) > 0.999
    assert len(events) > 5_000


def test_the_highway_tells_its_story() -> None:
    """0 comes towards the camera and grows, 1 stands on the shoulder for a while, 2 passes the lorry; the rest drive away."""
    samples = truth_of("highway")
    wrong, stopping, overtaking, lorry = (of_object(samples, number) for number in range(4))
    assert (wrong["vy"] > 0).all()
    assert (np.diff(wrong["width"]) > 0).all()
    standing = stopping[(stopping["t_us"] > 1_600_000) & (stopping["t_us"] < 2_400_000)]
    assert not standing["vx"].any()
    assert not standing["vy"].any()
    assert standing["visible"].all()
    assert (stopping["vy"][stopping["t_us"] < 1_500_000] < 0).all()
    assert stopping["vy"][-1] < 0
    _, mine, other = np.intersect1d(overtaking["t_us"], lorry["t_us"], return_indices=True)
    behind = (overtaking["y"] + overtaking["height"] / 2)[mine] > (lorry["y"] + lorry["height"] / 2)[other]
    assert (behind[0], behind[-1]) == (True, False)
    assert (samples["vy"][samples["object_id"] > 3] < 0).all()
    assert len(np.unique(samples["object_id"])) > 6
    assert samples["occluded"].max() > 0.5


def test_no_two_vehicles_of_the_highway_ever_collide() -> None:
    stage = stage_of("highway", duration_us=30_000_000, vehicles_per_s=3.0)
    traffic = stage._traffic
    assert len(traffic.class_id) > 30
    for t_s in np.arange(0, 30, 0.25):
        now = traffic.at(float(t_s))
        gap_x = abs(now.across_m[:, None] - now.across_m) - (traffic.width_m[:, None] + traffic.width_m) / 2
        rear, front = now.along_m, now.along_m + traffic.length_m
        beside = (gap_x < 0) & ~np.eye(len(rear), dtype=bool)
        overlap = np.minimum(front[:, None], front) - np.maximum(rear[:, None], rear)
        in_sight = (rear[:, None] > 15) & (rear[:, None] < 145)
        assert not (beside & in_sight & (overlap > 0)).any()


@pytest.mark.parametrize("ways", ["separate", "crossing"])
def test_separate_discs_keep_to_their_lanes_and_all_discs_to_the_sensor(ways: str) -> None:
    samples = truth_of("discs", ways=ways, count=12)
    assert samples["visible"].all()
    assert 8.5 - 1e-9 <= samples["x"].min() <= samples["x"].max() <= 345.5 - 9 + 1e-9
    assert samples["vy"].any() == (ways == "crossing")
    assert samples["occluded"].max() > 0.3 if ways == "crossing" else samples["occluded"].max() == 0


def test_a_shaken_picture_moves_as_one() -> None:
    stage = stage_of("shake", shake_px=5.0)
    for t_us in (0, 123_456, 1_000_000):
        objects = stage.objects(t_us)
        np.testing.assert_allclose(objects["y"] - stage.shift(t_us)[1], (objects["object_id"] % 4 + 0.5) * 65 - 0.5)
        assert sorted(objects["object_id"] % 4) == [0, 1, 2, 3]
    shifts = np.array([stage.shift(t) for t in range(0, 2_000_000, 1_000)])
    assert 2.0 < abs(shifts).max() <= 5.0


def test_a_box_that_enters_is_not_the_one_that_has_left() -> None:
    """No box jumps: it goes as far as its speed says, and the next in its lane, another, is that far from the edge at most."""
    stage = stage_of("shake", speed_px_s=300.0, shake_px=0.0)
    numbers = set()
    for t_us in range(0, 4_000_000, 10_000):
        before, after = stage.objects(t_us), stage.objects(t_us + 10_000)
        assert (np.diff(after["object_id"]) > 0).all()
        assert set(stage.shapes(t_us)[:, OBJECT]) == set(before["object_id"])
        _, was, now = np.intersect1d(before["object_id"], after["object_id"], return_indices=True)
        np.testing.assert_allclose(after["x"][now] - before["x"][was], before["vx"][was] * 0.01)
        for new in after[np.isin(after["object_id"], before["object_id"], invert=True)]:
            edge = -12.5 if new["vx"] > 0 else 357.5
            assert 0 <= (new["x"] - edge) / new["vx"] <= 0.01
            assert new["object_id"] - 4 in before["object_id"]
        numbers |= set(after["object_id"].tolist())
    assert len(numbers) > 12


@pytest.mark.parametrize(
    ("name", "overrides", "message"),
    [
        ("nothing", {}, "scene 'nothing': must be one of boxes, discs, highway, insects, pendulum, shake"),
        ("discs", {"wings": 2}, "discs.wings: no such setting: must be one of width, height, duration_us, seed, truth_step_us"),
        ("discs", {"count": "many"}, "discs.count = 'many': must be a whole number"),
        ("discs", {"contrast": "much"}, "discs.contrast = 'much': must be a number"),
        ("discs", {"count": 0}, "discs.count = 0: must be from 1 to 256 (how many discs)"),
        ("discs", {"ways": "lost"}, "discs.ways = 'lost': must be one of crossing, separate"),
        ("discs", {"radius_px": 140.0}, "discs.radius_px = 140: must be at most 130, so that a disc has room"),
        ("discs", {"noise_hz": "-1"}, "pixel.noise_hz = -1.0: must be from 0 to 1000 (background activity"),
        ("pendulum", {"length_px": 250.0},
         "pendulum.length_px = 250: with the bob's 16 must be at most the sensor's 260 pixels"),
        ("shake", {"shake_px": 15.0}, "shake.shake_px = 15.0: must be from 0 to 14 (farthest that the picture moves)"),
        ("shake", {"side_px": 70.0}, "shake.side_px = 70: must be at most a lane's 65 pixels"),
        ("highway", {"duration_us": 1}, "highway.duration_us = 1: must be from 1000 to 1000000000 (length of the scene)"),
        ("highway", {"wrong_way": -1}, "highway.wrong_way = -1: must be from 0 to 1000 (how many come the wrong way besides)"),
        ("highway", {"story": 2}, "highway.story = 2: must be from 0 to 1"),
        ("highway", {"loitering": 1}, "highway.loitering = 1: no room for so many in 4 s"),
        ("insects", {"seed": -1}, "insects.seed = -1: must be from 0 to"),
    ],
)  # fmt: skip
def test_settings_that_make_no_scene_are_refused(name: str, overrides: dict[str, Any], message: str) -> None:
    with refused(ConfigError, start=message):
        simulate_scene(name, 1, overrides)


def test_text_is_read_as_the_settings_kind_of_value() -> None:
    settings = scene_settings("discs", 7, {"count": "3", "contrast": "1", "ways": "separate", "noise_hz": "2.5"})
    values = settings.count, settings.contrast, settings.ways, settings.pixel.noise_hz, settings.seed
    assert values == (3, 1.0, "separate", 2.5, 7)


def test_a_scene_may_be_empty() -> None:
    assert not len(simulate_scene("shake", 1, {"count": 0, "duration_us": 5_000}).truth.samples)
    assert not len(simulate_scene("highway", 1, {"vehicles_per_s": 0.0, "story": 0, "duration_us": 5_000}).truth.samples)
    assert isinstance(simulate_scene("pendulum", 1, {"duration_us": 1_000, "noise_hz": 0.0}).recording.events, Events)

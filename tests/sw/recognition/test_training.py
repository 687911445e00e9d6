# SPDX-License-Identifier: Apache-2.0
"""Training: labels of windows, and a network that tells bars from crosses, on the tracker's own windows.

Size and speed behind the verdict: the inputs by hand, what is learned, and how it changes the class of a track.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import log

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.errors import ConfigError
from evcot.events import Events
from evcot.hardware.classifier import CELLS, HIDDEN, NONE, RAW_VERDICT, RecognitionRegisters
from evcot.hardware.config import MotionConfig
from evcot.recognition import training
from evcot.recognition.model import Network
from evcot.recognition.tracker import ClassifyingTracker, TrackWindows
from evcot.recognition.training import (
    UNLABELLED,
    LabelledWindows,
    fitted_size_speed,
    label_windows,
    registers_for,
    train,
    verdicts_of,
    windows_of,
)
from evcot.recognition.weights import MOTION_INPUTS, Weights, class_indices, inputs_of
from evcot.tracks.formats.base import BOX, Boxes
from evcot.tracks.log import TRACK, Kind
from evcot.tracks.tracking import log_of

SENSOR = 200, 100
CONFIG = MotionConfig()


def moving(shape: int, seed: int, duration_us: int = 400_000, seen: bool = True) -> tuple[Events, Boxes]:
    """An object that moves to the right at 200 px/s: the outline of a square (0) or a cross (1); and its labelled boxes."""
    random = np.random.default_rng(seed)
    count = duration_us // 12
    t_us = np.sort(random.integers(0, duration_us, count))
    along, across, side = random.uniform(-10, 10, count), random.integers(-1, 2, count), random.integers(0, 4, count)
    edge = np.where(side < 2, 10.0, -10.0) if shape == 0 else across
    dx, dy = np.where(side % 2, along, edge), np.where(side % 2, edge, along)
    x, y = 30 + t_us * 200e-6 + dx, 50 + dy + seed % 5
    p = random.integers(0, 2, count)
    instants_us = np.arange(0, duration_us, 10_000)
    rows = np.zeros(len(instants_us), BOX)
    rows["instant"], rows["id"], rows["class_id"] = np.arange(len(rows)), 1, 5 + shape
    rows["left"], rows["top"] = 20 + instants_us * 200e-6 + (0 if seen else 70), 40 + seed % 5
    rows["width"] = rows["height"] = 20
    return Events(t_us, np.rint(x).astype(np.uint16), np.rint(y).astype(np.uint16), p.astype(np.uint8)), Boxes(
        instants_us, rows
    )


def in_blocks(events: Events) -> Iterator[Events]:
    for begin in range(0, len(events), 5_000):
        yield events[begin : begin + 5_000]


def labelled(seeds: range, registers: RecognitionRegisters) -> LabelledWindows:
    parts = []
    for seed in seeds:
        events, boxes = moving(seed % 2, seed)
        parts.append(label_windows(windows_of(in_blocks(events), CONFIG, registers), boxes))
    return LabelledWindows.of(parts)


REGISTERS = replace(registers_for([moving(0, 0)[1]]), window_log2=8)


def test_a_trained_classifier_names_objects_it_has_not_seen() -> None:
    weights = train(labelled(range(12), REGISTERS), REGISTERS, "cot_motion")
    assert weights.class_ids == (5, 6)
    assert weights.registers.window_log2 == 8
    for seed in (20, 21, 22, 23):
        events, _ = moving(seed % 2, seed)
        tracker = ClassifyingTracker(CONFIG, weights)
        log = log_of("cot_motion", tracker, in_blocks(events))
        assert len(log.of_kind(Kind.BORN)) == 1
        assert len(log.verdicts) > 10
        assert log.verdicts["class_id"][-1] == 5 + seed % 2
        assert set(log.verdicts["track_id"]) == set(log.records["track_id"])
        assert np.array_equal(log.verdicts["t_us"], events.t_us[log.verdicts["event_index"]])
        assert (log.owner[log.verdicts["event_index"]] == log.verdicts["slot"]).all()
        whole = log_of("cot_motion", ClassifyingTracker(CONFIG, weights), [events])
        assert np.array_equal(whole.verdicts, log.verdicts)


def test_the_same_seed_gives_the_same_weights() -> None:
    windows = labelled(range(4), REGISTERS)
    first, again, other = (train(windows, REGISTERS, "cot_motion", seed).checksum for seed in (1, 1, 2))
    assert first == again != other


def deviations(monkeypatch: pytest.MonkeyPatch, affine: float, bend: float, shift: float) -> None:
    for name, deviation in (("_AFFINE", affine), ("_BEND", bend), ("_SHIFT", shift)):
        monkeypatch.setattr(training, name, deviation)


def test_distortions_of_no_size_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    deviations(monkeypatch, 0, 0, 0)
    images = np.random.default_rng(1).random((20, CELLS**2), np.float32)
    assert np.allclose(training._distorted(images, np.random.default_rng(2)), images, atol=1e-5)


def test_each_kind_of_distortion_changes_what_it_names(monkeypatch: pytest.MonkeyPatch) -> None:
    # An image whose value is the row: a shift adds the same to all cells, an affine change a multiple of the
    # place, a bend a curve. Cells near the edge have neighbours beyond it.
    rows = np.repeat(np.arange(CELLS, dtype=np.float32), CELLS)
    inner = np.zeros((CELLS, CELLS), np.bool_)
    inner[3:-3, 3:-3] = True
    v, u = (axis[inner] - (CELLS - 1) / 2 for axis in np.indices((CELLS, CELLS)))
    one = np.ones_like(v)
    for affine, bend, shift, terms in ((0, 0, 0.3, [one]), (0.05, 0, 0, [v, u]), (0, 0.05, 0, [one, v * v, u * v, u * u])):
        deviations(monkeypatch, affine, bend, shift)
        distorted = training._distorted(np.tile(rows, (16, 1)), np.random.default_rng(3))
        moved = (distorted - rows)[:, inner.ravel()]
        fit, *_ = np.linalg.lstsq(np.stack(terms, axis=1), moved.T, rcond=None)
        assert np.allclose(np.stack(terms, axis=1) @ fit, moved.T, atol=1e-4)
        assert np.abs(moved).max(axis=1).min() > 0.01
        assert np.allclose(moved[::2], moved[1::2])  # two images in each of eight parts
        assert len(np.unique(moved[:, 0].round(5))) == 8


def test_a_class_with_too_few_windows_is_refused() -> None:
    images = np.zeros((120, CELLS**2), np.uint8)
    class_id = np.r_[np.full(49, 1), np.full(71, 2)]
    with pytest.raises(ConfigError, match=r"class 1 has 49 windows: must be at least 50"):
        train(LabelledWindows(images, class_id, class_id), REGISTERS, "cot_motion")
    with pytest.raises(ConfigError, match=r"number of labelled classes in the tracks found is 1: must be 2 to 10"):
        train(LabelledWindows(images[:99], np.full(99, 2), class_id), REGISTERS, "cot_motion")
    with pytest.raises(ConfigError, match=r"number of labelled classes in the tracks found is 0: must be 2 to 10"):
        train(LabelledWindows(images, np.full(120, UNLABELLED), class_id), REGISTERS, "cot_motion")


def test_weights_of_another_tracker_are_refused() -> None:
    weights = replace(train(labelled(range(4), REGISTERS), REGISTERS, "cot_motion"), tracker="cot_array")
    with pytest.raises(ConfigError, match=r"engine cot_motion: must be cot_array, the tracker of the weights"):
        ClassifyingTracker(CONFIG, weights)


def windows_at(*places: tuple[int, float, float]) -> TrackWindows:
    states = np.zeros(len(places), TRACK)
    states["track_id"] = np.arange(len(places))
    for row, (_, x, y) in enumerate(places):
        states["x"][row], states["y"][row] = x, y
    t_us = np.array([place[0] for place in places], np.int64)
    return TrackWindows(t_us, states, np.zeros((len(places), CELLS**2), np.uint8))


def test_a_window_has_the_class_of_the_nearest_box_around_its_track() -> None:
    rows = np.zeros(3, BOX)
    rows["instant"], rows["id"], rows["class_id"] = (0, 0, 1), (0, 1, 0), (3, 4, 6)
    rows["left"], rows["top"], rows["width"], rows["height"] = (0, 8, 100), 0, 10, 10
    labels = Boxes(np.array([1_000, 2_000]), rows)
    places = ((900, 5, 5), (1_500, 9.1, 5), (1_501, 9.1, 5), (1_400, 8.9, 5), (1_400, 15, 11), (9_999, 105, 0))
    assert label_windows(windows_at(*places), labels).class_id.tolist() == [3, 4, UNLABELLED, 3, UNLABELLED, 6]


def test_the_start_scale_fits_labelled_objects() -> None:
    # A side of 20 px is 40 half pixels, shown on 9.6 of the 12 cells: 9.6 * 4096 / 40.
    assert registers_for([moving(0, 0)[1]]).scale_start == 983


def states_of(*sizes_and_speeds: tuple[float, float, float, float]) -> NDArray[np.void]:
    states = np.zeros(len(sizes_and_speeds), TRACK)
    for name, column in zip(("width", "height", "vx", "vy"), np.array(sizes_and_speeds).T, strict=True):
        states[name] = column
    return states


def raw_of(*verdicts: tuple[int, int, int]) -> NDArray[np.void]:
    raw = np.zeros(len(verdicts), RAW_VERDICT)
    for name, column in zip(("class", "margin", "windows"), np.array(verdicts).T, strict=True):
        raw[name] = column
    return raw


def test_inputs_are_evidence_of_the_winner_size_and_speed() -> None:
    inputs = inputs_of(np.array([2]), np.array([3 * 51]), np.array([3]), states_of((20.0, 0.5, -30.0, 40.0)), 3)
    np.testing.assert_allclose(inputs, [[0, 0, 2 * 0.2, log(20), 0.0, log(70), 1.0]])  # log2(1 + 3) = 2, 51 / 255 = 0.2


def test_the_largest_sum_wins_and_none_of_the_classes_stays() -> None:
    size_speed = np.zeros((2 + MOTION_INPUTS, 2))
    size_speed[:2] = np.eye(2)
    size_speed[2, 1], size_speed[-1, 1] = 1.0, -log(50)  # wider than 50 px: class 1, unless the image is sure
    raw = raw_of((0, 25, 1), (0, 25, 1), (0, 255, 1), (NONE, 5, 1))
    states = states_of(*((width, 9.0, 0.0, 0.0) for width in (40.0, 60.0, 60.0, 60.0)))
    assert class_indices(size_speed, raw, states).tolist() == [0, 1, 0, NONE]


def network() -> Weights:
    """Two classes: more counts in the left half of the image, or in the right half."""
    w1, w2 = np.zeros((CELLS**2, HIDDEN), np.int8), np.zeros((HIDDEN, 2), np.int8)
    left = np.arange(CELLS**2) % CELLS < CELLS // 2
    w1[left, 0] = w1[~left, 1] = w2[0, 0] = w2[1, 1] = 1
    return Weights(Network(w1, w2), RecognitionRegisters(shift_1=0, shift_2=0, classes=2), (7, 9))


def windows_with(track_id: list[int], left: list[int], class_id: list[int]) -> LabelledWindows:
    """Windows with so many counts in the left half, and 10 in the right."""
    images = np.zeros((len(left), CELLS**2), np.uint8)
    images[:, 0], images[:, CELLS - 1] = left, 10
    return LabelledWindows(images, np.array(class_id), np.array(track_id))


def test_verdicts_of_windows_are_votes_of_each_track() -> None:
    found = verdicts_of(network(), windows_with([5, 8, 5, 5, 8], [12, 3, 6, 10, 9], [7] * 5))
    # Track 5: +2, then -4, then 0 for the left half. Track 8: -7, then -1.
    assert [column.tolist() for column in found] == [[0, 1, 1, 1, 1], [2, 7, 2, 2, 8], [1, 1, 2, 3, 2]]


def test_size_decides_where_the_image_does_not() -> None:
    random = np.random.default_rng(1)
    track_id = np.repeat(np.arange(200), 3)
    class_id = np.where(track_id % 2, 9, 7)
    side_px = np.exp(random.normal(np.where(class_id == 9, 4.0, 3.0), 0.2))
    windows = windows_with(track_id.tolist(), random.integers(8, 13, 600).tolist(), class_id.tolist())
    states = states_of(*((side, side, 0.0, 0.0) for side in side_px))
    weights = network()
    size_speed = fitted_size_speed(weights, windows, states)
    inputs = inputs_of(*verdicts_of(weights, windows), states, 2)
    right = np.array(weights.class_ids)[np.argmax(inputs @ size_speed, axis=1)] == class_id
    assert right.mean() > 0.97
    # The sum of both classes' weights is free: the ridge makes it 0.
    np.testing.assert_allclose(size_speed.sum(axis=1), 0, atol=1e-9)


def test_every_track_counts_once_and_unlabelled_ones_never() -> None:
    # One long track and two short ones look alike: the short ones outvote it.
    windows = windows_with([1] * 50 + [2, 3] + [4] * 30, [10] * 82, [7] * 50 + [9, 9] + [UNLABELLED] * 30)
    states = states_of(*[(20.0, 20.0, 0.0, 0.0)] * 82)
    size_speed = fitted_size_speed(network(), windows, states)
    inputs = inputs_of(np.array([0]), np.array([0]), np.array([1]), states[:1], 2)
    assert np.argmax(inputs @ size_speed) == 1


@pytest.mark.parametrize(
    ("table", "message"),
    [
        (np.zeros((5, 2)), r"size_speed is \(5, 2\) float64: must be \(6, 2\) or \(0, 0\) float64"),
        (np.zeros((6, 2), np.float32), r"size_speed is \(6, 2\) float32: must be \(6, 2\) or \(0, 0\) float64"),
        (np.full((6, 2), np.nan), r"size_speed: must be finite numbers"),
    ],
)
def test_another_table_is_refused(table: NDArray[np.float64], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        replace(network(), size_speed=table)

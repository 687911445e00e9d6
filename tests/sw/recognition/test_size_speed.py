# SPDX-License-Identifier: Apache-2.0
"""Size and speed behind the verdict: the inputs by hand, what is learned, and how it changes the class of a track."""

from __future__ import annotations

from dataclasses import replace
from math import log

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.errors import ConfigError
from evcot.hardware.classifier import CELLS, HIDDEN, NONE, RAW_VERDICT, RecognitionRegisters
from evcot.recognition.model import Network
from evcot.recognition.size_speed import MOTION_INPUTS, class_indices, inputs_of
from evcot.recognition.training import UNLABELLED, LabelledWindows, fitted_size_speed, verdicts_of
from evcot.recognition.weights import Weights
from evcot.tracks.record import TRACK


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


def windows_of(track_id: list[int], left: list[int], class_id: list[int]) -> LabelledWindows:
    """Windows with so many counts in the left half, and 10 in the right."""
    images = np.zeros((len(left), CELLS**2), np.uint8)
    images[:, 0], images[:, CELLS - 1] = left, 10
    return LabelledWindows(images, np.array(class_id), np.array(track_id))


def test_verdicts_of_windows_are_votes_of_each_track() -> None:
    found = verdicts_of(network(), windows_of([5, 8, 5, 5, 8], [12, 3, 6, 10, 9], [7] * 5))
    # Track 5: +2, then -4, then 0 for the left half. Track 8: -7, then -1.
    assert [column.tolist() for column in found] == [[0, 1, 1, 1, 1], [2, 7, 2, 2, 8], [1, 1, 2, 3, 2]]


def test_size_decides_where_the_image_does_not() -> None:
    random = np.random.default_rng(1)
    track_id = np.repeat(np.arange(200), 3)
    class_id = np.where(track_id % 2, 9, 7)
    side_px = np.exp(random.normal(np.where(class_id == 9, 4.0, 3.0), 0.2))
    windows = windows_of(track_id.tolist(), random.integers(8, 13, 600).tolist(), class_id.tolist())
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
    windows = windows_of([1] * 50 + [2, 3] + [4] * 30, [10] * 82, [7] * 50 + [9, 9] + [UNLABELLED] * 30)
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

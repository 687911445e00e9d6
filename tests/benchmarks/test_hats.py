# SPDX-License-Identifier: Apache-2.0
"""The baseline HATS: time surfaces by hand, the events of a window, and the linear classifier."""

from __future__ import annotations

from math import exp

import numpy as np

from evcot.events import Events
from evcot.hardware.classifier import RecognitionRegisters
from evcot.hardware.config import MotionConfig
from evcot.recognition.tracker import WindowTracker
from hats import CELL_PX, CELLS, DECAY_US, FEATURES, REACH, SPAN_US, HatsTracker, hats, linear

SIDE = 2 * REACH + 1


def features_of(*events: tuple[int, int, int, int]) -> np.ndarray:
    t_us, x, y, p = np.array(events, np.int64).T
    return hats(t_us, x, y, p.astype(np.uint8)).reshape(CELLS, CELLS, 2, SIDE, SIDE)


def test_surfaces_are_averaged_over_the_events_of_cell_and_polarity() -> None:
    near, far, edge = 1_000, SPAN_US + 2_000, CELLS * CELL_PX // 2
    found = features_of(
        (0, 1, 1, 1), (near, 2, 0, 1), (near, 2, 0, 0), (near, 1 + REACH + 1, 1, 1), (far, 1, 1, 1), (far, edge, 0, 1)
    )
    cell = CELLS // 2
    expected = np.zeros((2, SIDE, SIDE))
    # Of the four ON events of the cell, the second sees the first one down and left, the third sees the second.
    expected[1, REACH + 1, REACH - 1] = exp(-near / DECAY_US) / 4
    expected[1, REACH - 1, REACH - 2] = 1 / 4
    np.testing.assert_allclose(found[cell, cell], expected, rtol=1e-6)
    assert np.count_nonzero(found) == 2


def square(seed: int) -> Events:
    random = np.random.default_rng(seed)
    count = 20_000
    t_us = np.sort(random.integers(0, 400_000, count))
    along, side = random.uniform(-10, 10, count), random.integers(0, 4, count)
    edge = np.where(side < 2, 10.0, -10.0)
    x, y = 30 + t_us * 200e-6 + np.where(side % 2, along, edge), 50 + np.where(side % 2, edge, along)
    p = random.integers(0, 2, count).astype(np.uint8)
    return Events(t_us, np.rint(x).astype(np.uint16), np.rint(y).astype(np.uint16), p)


def test_the_windows_are_those_of_the_classifier_around_the_middle_of_the_box() -> None:
    registers = RecognitionRegisters(window_log2=8)
    windows = HatsTracker(MotionConfig(), registers).windows(square(1))
    reference = WindowTracker(MotionConfig(), registers).windows(square(1))
    assert len(reference.t_us) > 10
    assert np.array_equal(windows.t_us, reference.t_us)
    assert np.array_equal(windows.states, reference.states)
    assert windows.images.shape == (len(reference.t_us), FEATURES)
    # The outline of a square of 20 px: of 4 x 4 cells of 8 px the middle four are empty but for noise.
    weight = windows.images.reshape(-1, CELLS, CELLS, 2 * SIDE**2).sum(axis=(0, 3))
    assert weight[1:3, 1:3].sum() < 0.5 * weight[0, 1:3].sum() + 0.5 * weight[3, 1:3].sum()


def test_the_linear_classifier_tells_classes_apart() -> None:
    random = np.random.default_rng(1)
    target = random.integers(0, 3, 300)
    features = random.uniform(0, 1, (300, 6)).astype(np.float32)
    features[np.arange(300), target] += 2
    weights, offset = linear(features, target, 3)
    assert (np.argmax(np.sqrt(features) @ weights + offset, axis=1) == target).mean() > 0.99

# SPDX-License-Identifier: Apache-2.0
"""The benchmark's own network and scores are those of the golden model."""

from __future__ import annotations

import numpy as np

import recognition
from evcot.hardware.classifier import CELLS, HIDDEN, RecognitionRegisters
from evcot.recognition.model import Network
from evcot.recognition.training import LabelledWindows
from evcot.recognition.weights import Weights
from support.slow_classifier import OwnedEvent, Slot, SlowClassifier


def test_losses_are_those_of_the_rules() -> None:
    random = np.random.default_rng(1)
    network = Network(*(random.integers(-99, 99, shape).astype(np.int8) for shape in ((CELLS**2, HIDDEN), (HIDDEN, 3))))
    weights = Weights(network, RecognitionRegisters(shift_1=4, shift_2=6, classes=3), (0, 1, 2))
    images = random.integers(0, 16, (20, CELLS**2)).astype(np.uint8)
    slow = SlowClassifier(weights.registers, network, 1)
    expected = []
    for image in images:
        slot = Slot(stage=1, cell=image.reshape(CELLS, CELLS).tolist())
        slow.verdict(slot, OwnedEvent(0, 0, 0, 0, True))
        expected.append(slot.vote)
    assert recognition.losses(weights, images).tolist() == expected


def test_a_track_is_right_by_all_its_windows_together() -> None:
    # Track 1 is a 0: two weak losses against one strong one. Track 2 is a 1, called 0. Track 3 is in no box.
    loss = np.array([[0, 9.0], [0, 9.0], [5.0, 0], [0, 1.0], [0, 1.0]])
    windows = LabelledWindows(np.zeros((5, 1), np.uint8), np.array([0, 0, 0, 1, -1]), np.array([1, 1, 1, 2, 3]))
    found = recognition.score(loss, np.arange(2), windows)
    assert found.windows == 0.5
    assert found.tracks == 0.5
    assert found.by_track.tolist() == [[0, 0, 13 / 3, 3], [1, 0, 1, 1], [-1, 0, 1, 1]]

# SPDX-License-Identifier: Apache-2.0
"""Baseline: histograms of averaged time surfaces (HATS, Sironi et al. 2018) of a track's windows, for a linear classifier.

Each event has a time surface: the events of its polarity within `REACH` px and the `SPAN_US` before, each with the weight
exp(-age / `DECAY_US`). Surfaces are averaged in square cells around the middle of the tracker's box. The window's events are
those of the classifier.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from evcot.events import Events
from evcot.hardware.classifier import RecognitionRegisters
from evcot.hardware.config import MotionConfig
from evcot.recognition.model import OwnedEvents
from evcot.recognition.tracker import TrackWindows, WindowTracker
from evcot.tracks.record import TRACK

__all__ = ["FEATURES", "HatsTracker", "hats", "linear"]

CELLS, CELL_PX = 4, 8  # along each axis
REACH = 2
SPAN_US, DECAY_US = 100_000, 50_000.0
_SIDE = 2 * REACH + 1
FEATURES = CELLS**2 * 2 * _SIDE**2
_RIDGE = 1e-3  # of the mean square of all features


@njit(cache=True)
def hats(t_us: NDArray[Any], x: NDArray[Any], y: NDArray[Any], p: NDArray[Any]) -> NDArray[np.float32]:
    """Features of one window, (FEATURES,): of (n,) events in chronological order, x and y in px from the middle of the box."""
    surfaces = np.zeros((CELLS, CELLS, 2, _SIDE, _SIDE))
    counts = np.zeros((CELLS, CELLS, 2))
    half = CELLS * CELL_PX // 2
    for i in range(len(t_us)):
        row, column = (y[i] + half) // CELL_PX, (x[i] + half) // CELL_PX
        if not (0 <= row < CELLS and 0 <= column < CELLS):
            continue
        counts[row, column, p[i]] += 1
        for j in range(i - 1, -1, -1):
            age_us = t_us[i] - t_us[j]
            if age_us > SPAN_US:
                break
            down, right = y[j] - y[i] + REACH, x[j] - x[i] + REACH
            if p[j] == p[i] and 0 <= down < _SIDE and 0 <= right < _SIDE:
                surfaces[row, column, p[i], down, right] += np.exp(-age_us / DECAY_US)
    return (surfaces / np.maximum(counts, 1.0).reshape(CELLS, CELLS, 2, 1, 1)).ravel().astype(np.float32)


class HatsTracker(WindowTracker):
    """The tracker's windows with these features for images, (n, FEATURES) float32; `windows` takes a whole recording."""

    def __init__(self, config: MotionConfig, registers: RecognitionRegisters) -> None:
        super().__init__(config, registers)
        self._events, self._rel_w = 1 << registers.window_log2, config.shape.rel_w

    def windows(self, events: Events) -> TrackWindows:
        """See `WindowTracker`."""
        records, decided = self.decide(events)
        owned = OwnedEvents(*decided[1:], self._model.visible)
        # Signed half pixels to pixels.
        bits = 16 - self._rel_w
        x, y = ((rel << bits).astype(np.int16) >> (bits + 1) for rel in (owned.rel_x, owned.rel_y))
        of_slot = [np.flatnonzero((owned.owner == slot) & owned.visible) for slot in range(owned.owner.max(initial=-1) + 1)]
        rows, states, features = [], [], []
        for closed in self._windows.feed(owned):
            kept = closed.stage > 0
            event, slot = closed.event[kept], closed.slot[kept]
            rows.append(event.copy())
            states.append(self._newest.at(event, slot, records))
            for last, own in zip(event.tolist(), slot.tolist(), strict=True):
                end = np.searchsorted(of_slot[own], last) + 1
                some = of_slot[own][end - self._events : end]
                features.append(hats(events.t_us[some], x[some].astype(np.int64), y[some].astype(np.int64), events.p[some]))
        self._newest.fed(records)
        if not features:
            return TrackWindows(np.zeros(0, np.int64), np.zeros(0, TRACK), np.zeros((0, FEATURES), np.float32))
        return TrackWindows(events.t_us[np.concatenate(rows)], np.concatenate(states), np.stack(features))


def linear(
    features: NDArray[np.float32], target: NDArray[np.int64], classes: int
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Least squares with a ridge, on square roots of the features: (FEATURES, classes) and (classes,)."""
    inputs = np.sqrt(features)
    middle = inputs.mean(axis=0)
    inputs = inputs - middle
    wanted = np.eye(classes, dtype=np.float32)[target]
    square = inputs.T @ inputs
    square[np.diag_indices(len(square))] += _RIDGE * len(inputs) * float(np.mean(inputs**2)) + 1e-6
    weights = np.linalg.solve(square, inputs.T @ (wanted - wanted.mean(axis=0)))
    return weights, wanted.mean(axis=0) - middle @ weights

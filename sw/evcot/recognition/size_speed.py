# SPDX-License-Identifier: Apache-2.0
"""Size and speed of a track, with the hardware's verdict, to its class: rules S of docs/recognition.md, in software."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..hardware.classifier import LOSS_MAX

__all__ = ["MOTION_INPUTS", "SPEED_FLOOR_PX_S", "class_indices", "inputs_of"]

MOTION_INPUTS = 4  # of rule S2 besides those of the classes: width, height, speed, 1
SPEED_FLOOR_PX_S = 20.0  # added to a speed before its logarithm: slower objects stand still (tuned on the validation set)


def inputs_of(
    winner: NDArray[np.int64], margin: NDArray[np.int64], windows: NDArray[np.int64], states: NDArray[np.void], classes: int
) -> NDArray[np.float64]:
    """Rule S2: (n, classes + MOTION_INPUTS), from verdicts of the network's classes and the newest records of their tracks."""
    inputs = np.zeros((len(winner), classes + MOTION_INPUTS))
    inputs[np.arange(len(winner)), winner] = np.log2(1 + windows) * margin / (LOSS_MAX * windows)
    speed = np.hypot(states["vx"], states["vy"])
    motion = np.maximum(states["width"], 1.0), np.maximum(states["height"], 1.0), speed + SPEED_FLOOR_PX_S
    inputs[:, classes:-1] = np.log(np.stack(motion, axis=1))
    inputs[:, -1] = 1.0
    return inputs


def class_indices(size_speed: NDArray[np.float64], raw: NDArray[np.void], states: NDArray[np.void]) -> NDArray[np.int64]:
    """Rules S1 and S3: the class of each verdict, (n,) int64; classes that the network does not have stay.

    Args:
        size_speed: (classes + MOTION_INPUTS, classes), of `Weights`.
        raw: of dtype `RAW_VERDICT`.
        states: of dtype `TRACK`, the newest record of each verdict's track.
    """
    winner, margin, windows = (raw[name].astype(np.int64) for name in ("class", "margin", "windows"))
    known = winner < size_speed.shape[1]
    inputs = inputs_of(winner[known], margin[known], windows[known], states[known], size_speed.shape[1])
    winner[known] = np.argmax(inputs @ size_speed, axis=1)
    return winner

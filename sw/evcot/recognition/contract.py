# SPDX-License-Identifier: Apache-2.0
"""The contract of RTL and golden model of the classifier: sizes, registers, the verdict. docs/recognition.md has the rules."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..ranges import check_ranges, setting

__all__ = [
    "CELLS",
    "CLASSES_MAX",
    "COUNT_MAX",
    "HIDDEN",
    "HIDDEN_MAX",
    "LOSS_MAX",
    "NONE",
    "RAW_VERDICT",
    "SERVICE_EVENTS",
    "VOTED_MAX",
    "RecognitionRegisters",
]

CELLS = 12  # of an image, along each axis
COUNT_MAX = 15  # of a cell
HIDDEN = 32  # units of the hidden layer
HIDDEN_MAX = 255  # value of a unit
CLASSES_MAX = 10
LOSS_MAX = 255  # of a class in one window
VOTED_MAX = 128  # windows in a vote; then votes and their number are halved
NONE = 15  # class of a verdict with too small a margin
SERVICE_EVENTS = 768  # owned events, of all slots, after which a window counts as evaluated


@dataclass(frozen=True)
class RecognitionRegisters:
    """The registers of the classifier, with their limits and meanings (docs/recognition.md).

    Raises:
        ConfigError: a value outside its range.
    """

    window_log2: int = setting(10, 8, 12, "a window has 2^window_log2 counted events")
    scale_start: int = setting(984, 16, 4095, "scale of both axes in a track's first window, in 2^-12 cells per half pixel")
    shift_1: int = setting(8, 0, 15, "a hidden unit is 2^-shift_1 of its weighted sum")
    shift_2: int = setting(8, 0, 15, "the loss of a class is 2^-shift_2 of its distance from the best")
    classes: int = setting(CLASSES_MAX, 2, CLASSES_MAX, "number of classes")
    margin_min: int = setting(0, 0, LOSS_MAX, "a mean margin per window below this gives class 15, none of these")

    def __post_init__(self) -> None:
        check_ranges("recognition", self)


RAW_VERDICT = np.dtype(
    [
        ("seq", "<u8"),
        ("slot", "u1"),
        ("class", "u1"),
        ("margin", "<u2"),
        ("windows", "u1"),
    ]
)
"""A verdict as the hardware sends it: number of the event that closed the window, slot, class, margin of the vote, windows in
the vote."""

# SPDX-License-Identifier: Apache-2.0
"""The contract of RTL and golden model of the classifier: sizes, registers, the verdict. docs/recognition.md has the rules."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from ..ranges import check_ranges, ranges_of, setting
from .motion.contract import MOTION_RECORD, MotionRegister

__all__ = [
    "CELLS",
    "CLASSES_MAX",
    "CLASSIFIER_REGISTERS",
    "COUNT_MAX",
    "HIDDEN",
    "HIDDEN_MAX",
    "LOSS_MAX",
    "NONE",
    "RAW_VERDICT",
    "SERVICE_EVENTS",
    "VERDICT_KIND",
    "VERDICT_RECORD",
    "VERDICT_RECORD_MEANINGS",
    "VERSION",
    "VOTED_MAX",
    "WEIGHT_BANKS",
    "WEIGHT_ROWS",
    "RecognitionRegisters",
]

VERSION = 1  # of this contract: what weights are for, and what hardware computes
CELLS = 12  # of an image, along each axis
COUNT_MAX = 15  # of a cell
HIDDEN = 32  # units of the hidden layer
HIDDEN_MAX = 255  # value of a unit
CLASSES_MAX = 10
LOSS_MAX = 255  # of a class in one window
VOTED_MAX = 128  # windows in a vote; then votes and their number are halved
NONE = 15  # class of a verdict with too small a margin
WEIGHT_BANKS = 4  # words of a row of weights
# Of five moments and the hidden units, with eight cells in a row; then those with the last unit's weights of the second layer.
WEIGHT_ROWS = (5 + HIDDEN) * CELLS**2 // 8 + 8 + CLASSES_MAX
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


def _bank() -> Mapping[str, MotionRegister]:
    # Word 0 is free: on the bus, a bank's word 0 is `mode` of a slot (axi_lite_regs.v).
    start = RecognitionRegisters()
    found = {"enable": MotionRegister(1, 0, 1, 0, "1: events count; 0: they do not, and weights can be written")}
    for address, (name, (low, high, meaning)) in enumerate(ranges_of(RecognitionRegisters).items(), 2):
        found[name] = MotionRegister(address, int(low), int(high), getattr(start, name), meaning)
    return MappingProxyType(found)


CLASSIFIER_REGISTERS: Mapping[str, MotionRegister] = _bank()
"""The bank of the classifier on the bus: its registers by name. Their order is that of the register port of classifier.v."""

VERDICT_KIND = 4
"""Kind of the record of a verdict; those of the tracker are `tracks.log.Kind`."""

VERDICT_RECORD = np.dtype(
    [
        ("seq", "<u8"),
        ("_pad", "<u8"),
        ("track_id", "<u4"),
        ("margin", "<u2"),
        ("windows", "u1"),
        ("class_index", "u1"),
        ("_pad2", "<u8"),
        ("_pad3", "<u8"),
        ("_pad4", "<u8"),
        ("_pad5", "<u2"),
        ("slot", "u1"),
        ("kind", "u1"),
        ("_pad6", "<u4"),
    ]
)
"""A verdict in the stream of records: as long as a record of cot_motion, with seq, track_id, slot and kind in its places."""
assert VERDICT_RECORD.itemsize == MOTION_RECORD.itemsize

VERDICT_RECORD_MEANINGS: MappingProxyType[str, str] = MappingProxyType(
    {
        "seq": "number of the event that closed the window",
        "track_id": "the track",
        "margin": "margin of the vote",
        "windows": "windows in the vote",
        "class_index": f"the class, in the order of the weights; {NONE}: none of these",
        "slot": "the slot of the track",
        "kind": str(VERDICT_KIND),
    }
)
"""Field of `VERDICT_RECORD` -> its meaning."""

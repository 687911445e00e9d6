# SPDX-License-Identifier: Apache-2.0
"""The extended contract: registers of the whole array, their ranges, and the record. docs/motion.md states the rules."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from ...errors import ConfigError
from ...ranges import Range, check_integer, ranges_of, setting
from ..contract import RECORD_MEANINGS, Shape

__all__ = [
    "MOTION_BANKS",
    "MOTION_RANGES",
    "MOTION_RECORD",
    "MOTION_RECORD_MEANINGS",
    "MOTION_RULES",
    "SUB",
    "MotionRegister",
    "MotionRegisters",
    "Rule",
]

SUB = 12  # fractional bits of a side, and of a velocity in pixels per motion step


class Rule(NamedTuple):
    """Two registers of a bank that must not contradict each other: `times` * less must be at most more."""

    less: str
    more: str
    times: int = 1


MOTION_RULES = (
    Rule("nev_low", "nev_high"),
    Rule("ring_px", "ring_max"),
    Rule("seed_px", "side_max", 2),
    Rule("life_ticks", "coast_ticks"),
)
"""The model's configuration and a commit on the bus are refused where one is broken."""


@dataclass(frozen=True)
class MotionRegisters:
    """The registers of `cot_motion`.

    The defaults were found by a search over many kinds of scenes (docs/defaults.md); the hardware has them after reset.

    Raises:
        ConfigError: a value outside its range, or values that contradict each other.
    """

    step_log2: int = setting(12, 0, 20, "a motion step of each slot every 2^step_log2 ticks")
    side_step: int = setting(1024, 1, 65535, "way of a side for an event beyond and one within it, in 2^-12 px")
    side_share: int = setting(4, 1, 8, "2^-side_share of a slot's events lie beyond each side")
    side_shrink: int = setting(
        4, 0, 8, "a side without an event beyond it moves inwards by 2^-side_shrink of the box; 0: never"
    )
    side_max: int = setting(160, 1, 4095, "longest side, px")
    gain_log2: int = setting(4, 1, 12, "gain of a velocity's correction is 2^-gain_log2 in the end")
    gain_slow: int = setting(0, 0, 6, "2^gain_slow corrections until a gain is halved")
    gain_fast: int = setting(2, 0, 12, "it is doubled while corrections agree in direction, up to 2^-gain_fast; 0: it is not")
    settle: int = setting(8, 0, 63, "corrections during which a velocity follows the slower of two sides")
    speed_max: int = setting(
        32767, 0, 32767, "limit of a velocity on each axis, in 2^-12 px per step; 0: nothing moves between events"
    )
    friction: int = setting(5, 0, 15, "a silent slot loses 2^-friction of its velocity a step; 0: nothing")
    coast_slow: int = setting(2, 0, 3, "a silent slot moves by 2^-coast_slow of its velocity")
    nev_low: int = setting(8, 1, 1023, "fewest events of a correction")
    nev_high: int = setting(325, 1, 1023, "most events of a correction")
    seed_px: int = setting(4, 1, 255, "half the side of a new candidate's box")
    ring_px: int = setting(2, 0, 255, "least distance of a window from its box")
    ring_max: int = setting(21, 0, 255, "largest distance of a window from its box")
    ring_across: int = setting(1, 0, 8, "distance across the motion is 2^-ring_across of the box's side there")
    ring_along: int = setting(1, 0, 8, "distance along the motion is 2^-ring_along of the side across it")
    ring_any: int = setting(2, 0, 8, "distance, where there is no one direction, is 2^-ring_any of the side")
    elongation: int = setting(3, 1, 15, "a box this many times as long as it is wide reaches along its motion as across it")
    detect_ticks: int = setting(7_521, 1, 2**24 - 1, "ticks within which a candidate must have its first correction")
    life_log2: int = setting(2, 0, 8, "a life ends after 2^life_log2 times the usual time between corrections without one")
    life_ticks: int = setting(40_000, 1, 2**24 - 1, "but not before this time")
    coast_ticks: int = setting(93_951, 1, 2**24 - 1, "nor after this time")
    return_ticks: int = setting(
        500_000, 0, 2**24 - 1, "ticks after its end in which a track goes on in what becomes visible there; 0: never"
    )
    birth_support: int = setting(260, 1, 65535, "events that a candidate needs to become visible")
    birth_px: int = setting(2, 0, 255, "sides that it needs")
    birth_ticks: int = setting(12_000, 0, 2**24 - 1, "time that it needs")
    birth_travel: int = setting(
        2, 0, 8, "since the 4th correction its middle has moved 1 px and 2^-birth_travel of a half side"
    )
    gap_corrections: int = setting(15, 0, 255, "corrections after which a box is looked through for a gap; 0: never")
    gap_share: int = setting(9, 1, 15, "a bin with at most 2^-gap_share of the events is empty")
    gap_px: int = setting(3, 1, 255, "narrowest gap")
    join_steps: int = setting(2, 1, 1023, "steps for which two slots must move together before they merge")
    join_life: int = setting(3, 0, 15, "and 2^-join_life of the younger's life")
    join_speed: int = setting(1, 0, 8, "together: velocities differ by at most 2^-join_speed of the larger")
    join_reach: int = setting(0, 0, 8, "one object: a gap along the motion of at most 2^-join_reach of the width, and join_px")
    join_px: int = setting(3, 0, 255, "one object: a gap of at most so many px")
    keep_older: int = setting(0, 0, 1, "of two that merge stays 0: the one with more support; 1: the one that was seeded first")
    report_steps: int = setting(1, 1, 1023, "steps after which a slot without a correction is reported")

    def __post_init__(self) -> None:
        for field in fields(self):
            low, high, meaning = MOTION_RANGES[field.name]
            check_integer(f"motion.{field.name}", getattr(self, field.name), int(low), int(high), meaning)
        for less, more, times in MOTION_RULES:
            low, high = getattr(self, less), getattr(self, more)
            if times * low > high:
                raise ConfigError(f"motion.{less} = {low}: must be at most {'half of ' * (times == 2)}{more} = {high}")


MOTION_RANGES: MappingProxyType[str, Range] = MappingProxyType(ranges_of(MotionRegisters))


@dataclass(frozen=True)
class MotionRegister:
    """A register of the whole array, in one of its two banks on the bus.

    Attributes:
        address: its word in the bank.
        low, high: smallest and largest legal value.
        start: its value after reset.
        meaning: a one-line description.
    """

    address: int
    low: int
    high: int
    start: int
    meaning: str

    def limits(self, _: Shape) -> tuple[int, int]:
        """Smallest and largest legal value, the same in every shape."""
        return self.low, self.high


def _bank(names: list[str]) -> Mapping[str, MotionRegister]:
    # Word 0 is free: on the register port of cot_motion.v it is `mode` of a slot.
    start = MotionRegisters()
    return MappingProxyType(
        {
            name: MotionRegister(
                address, int(MOTION_RANGES[name][0]), int(MOTION_RANGES[name][1]), getattr(start, name), MOTION_RANGES[name][2]
            )
            for address, name in enumerate(names, 1)
        }
    )


_ORDER = list(MOTION_RANGES)
_LIVES = _ORDER.index("detect_ticks")
MOTION_BANKS: Mapping[str, Mapping[str, MotionRegister]] = MappingProxyType(
    {"motion": _bank(_ORDER[:_LIVES]), "tracks": _bank(_ORDER[_LIVES:])}
)
"""The banks on the bus, and their registers by name: boxes, windows and velocities; lives, births, gaps, merging, reports."""


# What the extended contract puts out: like contract.RECORD, with a box and a velocity in place of the radius.
MOTION_RECORD = np.dtype(
    [
        ("seq", "<u8"),
        ("time", "<u8"),
        ("track_id", "<u4"),
        ("other_id", "<u4"),
        ("cm_x", "<i4"),
        ("cm_y", "<i4"),
        ("width", "<u4"),
        ("height", "<u4"),
        ("v_x", "<i2"),
        ("v_y", "<i2"),
        ("support", "<u4"),
        ("n_ev", "<u2"),
        ("slot", "u1"),
        ("kind", "u1"),
        ("_pad", "<u4"),
    ]
)

MOTION_RECORD_MEANINGS: MappingProxyType[str, str] = MappingProxyType(
    {
        **{name: meaning for name, meaning in RECORD_MEANINGS.items() if name != "radius"},
        "seq": "number of the event that caused it; of the record of a motion step, of the next event",
        "cm_x": f"column of the middle of the box, in pixels with {SUB} fractional bits; it may lie off the sensor",
        "width": f"width of the box, in pixels with {SUB} fractional bits",
        "height": "height of the box, likewise",
        "v_x": f"velocity to the right, in 2^-{SUB} pixels per motion step",
        "v_y": "velocity downwards, likewise",
        "n_ev": "N_ev, the events until the next correction",
    }
)
"""Field of `MOTION_RECORD` -> its meaning."""

# SPDX-License-Identifier: Apache-2.0
"""The registers of cot_motion as its parts take them: in one word."""

from __future__ import annotations

from evcot.hardware.motion.contract import MOTION_RANGES, MotionRegisters
from evcot.hardware.registers import motion_addresses

__all__ = ["registers_word"]


def registers_word(registers: MotionRegisters) -> int:
    """All registers, the first one in the lowest bits."""
    word = at = 0
    for name in motion_addresses():
        if name != "mode":
            word |= getattr(registers, name) << at
            at += int(MOTION_RANGES[name][1]).bit_length()
    return word

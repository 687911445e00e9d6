# SPDX-License-Identifier: Apache-2.0
"""Tables of the extended contract's kernels: a slot's fields, the registers, and what is common to all slots."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

from numpy.typing import NDArray

from .contract import SUB, MotionRegisters

Table = NDArray[Any]

# A slot's fields. Sides and velocities have SUB fractional bits, bounds are pixels, times are ticks.
(STATE, LO_X, HI_X, LO_Y, HI_Y, V_X, V_Y, OFF_LO_X, OFF_HI_X, OFF_LO_Y, OFF_HI_Y, BEYOND, HIDDEN, MEETS,
 BOX_LO_X, BOX_HI_X, BOX_LO_Y, BOX_HI_Y, WIN_LO_X, WIN_HI_X, WIN_LO_Y, WIN_HI_Y,
 COUNT, N_EV, SUPPORT, CORRECTIONS, LAST, USUAL, DEADLINE, SEEDED, FROM_X, FROM_Y, PARTNER, TOGETHER, ID, REPORTED,
 BIN_LOG2_X, BIN_LOG2_Y, LOOKED, WAITS, NEXT_BOX_LO_X, NEXT_BOX_HI_X, NEXT_BOX_LO_Y, NEXT_BOX_HI_Y,
 NEXT_WIN_LO_X, NEXT_WIN_HI_X, NEXT_WIN_LO_Y, NEXT_WIN_HI_Y, RUN_X, RUN_Y,
 HELD_BOX_LO_X, HELD_BOX_HI_X, HELD_BOX_LO_Y, HELD_BOX_HI_Y, HELD_WIN_LO_X, HELD_WIN_HI_X, HELD_WIN_LO_Y, HELD_WIN_HI_Y,
) = range(58)  # fmt: skip
BINS_LOG2 = 4
BINS = 1 << BINS_LOG2  # of each axis
BINS_X, BINS_Y = 58, 58 + BINS
FIELD_COUNT = 58 + 2 * BINS

FREE, CANDIDATE, VISIBLE, LEFT = range(4)  # STATE
AT_LO_X, AT_HI_X, AT_LO_Y, AT_HI_Y = 1, 2, 4, 8  # bits of BEYOND and HIDDEN

_NAMES = [field.name for field in fields(MotionRegisters)]
(
    STEP_LOG2, SIDE_STEP, SIDE_SHARE, SIDE_SHRINK, SIDE_MAX, GAIN_LOG2, GAIN_SLOW, GAIN_FAST, SETTLE, SPEED_MAX, FRICTION,
    COAST_SLOW, NEV_LOW, NEV_HIGH, SEED_PX, RING_PX, RING_MAX, RING_ACROSS, RING_ALONG, RING_ANY, ELONGATION, DETECT_TICKS,
    LIFE_LOG2, LIFE_TICKS, COAST_TICKS, RETURN_TICKS, BIRTH_SUPPORT, BIRTH_PX, BIRTH_TICKS, BIRTH_TRAVEL, GAP_CORRECTIONS,
    GAP_SHARE, GAP_PX, JOIN_STEPS, JOIN_LIFE, JOIN_SPEED, JOIN_REACH, JOIN_PX, KEEP_OLDER, REPORT_STEPS,
) = (
    _NAMES.index(name)
    for name in (
        "step_log2", "side_step", "side_share", "side_shrink", "side_max", "gain_log2", "gain_slow", "gain_fast", "settle",
        "speed_max", "friction", "coast_slow", "nev_low", "nev_high", "seed_px", "ring_px", "ring_max", "ring_across",
        "ring_along", "ring_any", "elongation", "detect_ticks", "life_log2", "life_ticks", "coast_ticks", "return_ticks",
        "birth_support", "birth_px", "birth_ticks", "birth_travel", "gap_corrections", "gap_share", "gap_px", "join_steps",
        "join_life", "join_speed", "join_reach", "join_px", "keep_older", "report_steps",
    )
)  # fmt: skip

# Common to all slots. The next step is that of NEXT_SLOT at tick NEXT_STEP, in the period that begins at tick PERIOD.
NOW, SEQ, BIRTHS, PERIOD, NEXT_SLOT, NEXT_STEP, IN_FORCE, SEEDING, EMPTY, BUSY, PAUSED = range(11)
GLOBAL_COUNT = 11

ID_MASK, SUPPORT_MAX, REL_MASK, REACH, SLOTS_LOG2 = range(5)  # follow from the hardware's widths and number of slots
LIMIT_COUNT = 5

ONE = 1 << SUB
NEVER = 1 << 62
CORRECTIONS_MAX = 63  # the count saturates
RUN_MAX = 7  # corrections in one direction, saturating
RUN_FROM = 2  # from which on one more doubles the gain
TICKS_MAX = (1 << 24) - 1  # ticks between two corrections, saturating
TOGETHER_MAX = (1 << 16) - 1  # steps together after which two merge in any case
MOVES_FROM = 4  # corrections from which on a candidate's velocity counts
IN_FORCE_AFTER = 64  # events after which a correction, or a candidate, is in force
EMPTY_MAX = 32  # periods in a row without an event that do not bring a deadline nearer
LOOKS_FROM = 8  # corrections from which on a gap counts

# SPDX-License-Identifier: Apache-2.0
"""Tables of the extended contract's kernels: a slot's fields, the registers, and what is common to all slots."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

from numpy.typing import NDArray

from .contract import SUB, MotionRegisters

Table = NDArray[Any]

# A slot's fields. Sides and velocities have SUB fractional bits, bounds are pixels, times are ticks. First what jobs compute:
(STATE, LO_X, HI_X, LO_Y, HI_Y, BOX_LO_X, BOX_HI_X, BOX_LO_Y, BOX_HI_Y, WIN_LO_X, WIN_HI_X, WIN_LO_Y, WIN_HI_Y, HIDDEN, BEYOND,
 OFF_LO_X, OFF_HI_X, OFF_LO_Y, OFF_HI_Y, V_X, V_Y, RUN_X, RUN_Y, MEETS, SUPPORT, N_EV, CORRECTIONS, LAST, USUAL, DEADLINE,
 SEEDED, FROM_X, FROM_Y, PARTNER, TOGETHER, ID, REPORTED, BIN_LOG2_X, BIN_LOG2_Y, LOOKED,
 WAS_X, WAS_Y, PACE_X, PACE_Y, STATED_X, STATED_Y,
) = range(46)  # fmt: skip
# Then what is in effect, which events see and change: of the first fields in the same order, and the events that the slot
# owned since its last job, and counted since its last correction.
IN_EFFECT = 46
(EV_STATE, EV_LO_X, EV_HI_X, EV_LO_Y, EV_HI_Y, EV_BOX_LO_X, EV_BOX_HI_X, EV_BOX_LO_Y, EV_BOX_HI_Y,
 EV_WIN_LO_X, EV_WIN_HI_X, EV_WIN_LO_Y, EV_WIN_HI_Y, EV_HIDDEN, EV_BEYOND, EV_OWNED, EV_COUNT,
) = range(IN_EFFECT, IN_EFFECT + 17)  # fmt: skip
# What is computed and not in effect yet: the event and the tick before which it takes effect, or else 0; the state, and how far
# each side moves then; whether a correction or a new candidate is not in effect; whether anything was computed. Another slot's
# step may also end the slot, as that one takes effect: its number and one, or else 0.
(WAITS, WAITS_TICK, NEXT_STATE, MOVES_LO_X, MOVES_HI_X, MOVES_LO_Y, MOVES_HI_Y, CORRECTS, COMPUTED, ENDS_WITH) = range(63, 73)
# The bounds that the sets of _places.py have.
(HELD_BOX_LO_X, HELD_BOX_HI_X, HELD_BOX_LO_Y, HELD_BOX_HI_Y, HELD_WIN_LO_X, HELD_WIN_HI_X, HELD_WIN_LO_Y, HELD_WIN_HI_Y,
) = range(73, 81)  # fmt: skip
BINS_LOG2 = 4
BINS = 1 << BINS_LOG2  # of each axis
BINS_X, BINS_Y = 81, 81 + BINS
FIELD_COUNT = 81 + 2 * BINS

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
# SAME_TICK kept events have come at TICK.
NOW, SEQ, BIRTHS, PERIOD, NEXT_SLOT, NEXT_STEP, DUE, SEEDING, EMPTY, BUSY, PAUSED, DUE_TICK, TICK, SAME_TICK = range(14)
GLOBAL_COUNT = 14

ID_MASK, SUPPORT_MAX, REL_MASK, REACH, SLOTS_LOG2 = range(5)  # follow from the hardware's widths and number of slots
LIMIT_COUNT = 5

ONE = 1 << SUB
NEVER = 1 << 62
CORRECTIONS_MAX = 63  # the count saturates
RUN_MAX = 7  # corrections in one direction, saturating
RUN_FROM = 2  # from which on one more doubles the gain
PACE_MAX = (1 << 16) - 1  # displacement of a slot's middle per step, in half units, saturating
WAY_MAX = (1 << 19) - 1  # the same, modulo twice as much
PACE_SLOW = 4  # log2 of the steps over which either of its means is taken, at most
TICKS_MAX = (1 << 24) - 1  # ticks between two corrections, saturating
TOGETHER_MAX = (1 << 16) - 1  # steps together after which two merge in any case
MOVES_FROM = 4  # corrections from which on a candidate's velocity counts
EFFECT_EVENTS = 64  # events after which what was computed takes effect
EFFECT_TICKS = 256  # or ticks
EMPTY_MAX = 32  # periods in a row without an event that do not bring a deadline nearer
BURST_FROM = 16  # kept events at one tick after which another one is within a burst
BURST_LOG2 = 2  # a side moves by 2^BURST_LOG2 times as much for an event of a burst beyond it
LOOKS_FROM = 8  # corrections from which on a gap counts

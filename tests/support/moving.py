# SPDX-License-Identifier: Apache-2.0
"""Streams in which objects meet, and registers under which much happens on them: for model and RTL of cot_motion."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evcot.hardware.contract import Shape
from evcot.hardware.motion.contract import MOTION_RANGES, MotionRegisters
from evcot.hardware.registers import motion_addresses
from evcot.ticks import TickedEvents

__all__ = ["LEAVES", "PLAIN", "QUICK", "SHAPE", "VARIANTS", "leaves", "registers_word", "scene"]

SHAPE = Shape(n_slots=5, x_w=7, y_w=6, sup_w=9, id_w=3, radix_w=5)
PLAIN = MotionRegisters(
    step_log2=10, side_shrink=5, gain_slow=2, gain_fast=0, friction=7, coast_slow=0, nev_high=256, ring_max=24, ring_any=1,
    elongation=2, detect_ticks=10_000, life_log2=3, life_ticks=20_000, coast_ticks=100_000, return_ticks=0, birth_support=200,
    birth_px=4, birth_ticks=10_000, birth_travel=1, gap_corrections=16, gap_share=7, gap_px=2, join_steps=10, join_px=2,
    report_steps=4,
)  # fmt: skip
"""Registers whose rules are easy to follow in a story: no returns, no quick turns."""
QUICK = replace(
    PLAIN,
    step_log2=5, side_step=900, detect_ticks=300, life_ticks=400, coast_ticks=2_000, birth_support=30, birth_px=2,
    birth_ticks=100, birth_travel=3, nev_low=4, nev_high=40, side_max=40, seed_px=3, gap_corrections=4, join_steps=3,
    report_steps=2, ring_max=10,
)  # fmt: skip
VARIANTS = {
    "quick": {},
    "no prediction": {"speed_max": 0},
    "slow limit": {"speed_max": 300, "friction": 2},
    "no friction": {"friction": 0, "life_log2": 6},
    "no gaps": {"gap_corrections": 0},
    "gaps at once": {"gap_corrections": 1, "gap_share": 3, "gap_px": 1},
    "no shrinking": {"side_shrink": 0, "side_share": 2},
    "older stays": {"keep_older": 1, "join_steps": 1, "join_life": 15, "join_speed": 0},
    "never together": {"join_steps": 1023},
    "slow to merge": {"join_life": 0, "join_speed": 0, "join_reach": 1, "join_px": 6},
    "wide rings": {"ring_across": 0, "ring_along": 0, "ring_any": 0, "ring_max": 255, "elongation": 1},
    "narrow rings": {"ring_px": 0, "ring_across": 4, "ring_along": 3, "ring_any": 3, "elongation": 6},
    "large sides": {"side_step": 60_000, "side_max": 60, "speed_max": 32_767},
    "fine steps": {"step_log2": 0, "report_steps": 20, "gain_log2": 9, "gain_slow": 0, "settle": 0},
    "coarse steps": {"step_log2": 9, "settle": 63, "gain_log2": 1, "join_steps": 1},
    "quick turns": {"gain_log2": 6, "gain_slow": 0, "gain_fast": 2, "coast_slow": 3, "friction": 2},
    "tracks return": {"return_ticks": 3_000, "coast_ticks": 500, "birth_support": 8, "birth_px": 1, "coast_slow": 1},
    "everything returns": {"return_ticks": 2**24 - 1, "birth_support": 1, "birth_px": 0, "birth_ticks": 0, "birth_travel": 8},
    "everything is born": {"birth_support": 1, "birth_px": 0, "birth_ticks": 0, "birth_travel": 8},
}


def scene(seed: int, n: int = 6_000, period: int = 1) -> TickedEvents:
    """Outlines of some boxes that bounce, of every size and speed, with noise, pauses and a hot pixel.

    Args:
        period: ticks whose events all come at one tick.
    """
    random = np.random.default_rng(seed)
    ticks = np.cumsum(random.integers(0, 5, n) + np.where(random.random(n) < 0.002, 1_500, 0))
    count = 4
    which, side = random.integers(0, count, n), random.integers(0, 4, n)
    half = random.uniform(2, 9, (2, count))[:, which]
    room = np.array([[127.0], [63.0]]) - 2 * half
    way = random.uniform(0, 60, (2, count))[:, which] + random.normal(0, 0.012, (2, count))[:, which] * ticks
    middle = half + np.abs((way + room) % (2 * room) - room)
    along = random.uniform(-1, 1, n) * half
    sign = np.where(side % 2, 1, -1)
    place = middle + np.where(side < 2, np.stack((sign * half[0], along[1])), np.stack((along[0], sign * half[1])))
    noise = random.random(n) < 0.06
    place[:, noise] = random.uniform(0, 1, (2, np.count_nonzero(noise))) * [[127], [63]]
    place[:, random.random(n) < 0.02] = [[100], [10]]
    x, y = np.clip(np.rint(place), 0, [[127], [63]]).astype(np.uint16)
    return TickedEvents((ticks // period * period).astype(np.int64), x, y, np.zeros(n, np.uint8))


LEAVES = replace(QUICK, ring_max=60, return_ticks=100_000, detect_ticks=600)


def leaves(lost_tick: int) -> TickedEvents:
    """A box moves, and is silent until it has left at this tick. Events where it was come at once, another box later, near."""
    random = np.random.default_rng(7)

    def moving(begin: int, ticks: int, x: float) -> tuple[NDArray[Any], ...]:
        t = np.arange(begin, begin + ticks, 2)
        side, along = random.integers(0, 4, len(t)), random.uniform(-5, 5, len(t))
        edge = np.where(side % 2, 5, -5)
        place_x = x + 0.01 * (t - begin) + np.where(side < 2, edge, along)
        return t, place_x, 30 + np.where(side < 2, along, edge)

    t = lost_tick + np.arange(1, 42)
    still = t, np.full(len(t), 70.0), np.full(len(t), 30.0)
    columns = zip(moving(0, 2_000, 30.0), still, moving(lost_tick + 1_000, 2_000, 90.0), strict=True)
    ticks, x, y = (np.rint(np.concatenate(column)).astype(np.int64) for column in columns)
    return TickedEvents(ticks, x.astype(np.uint16), y.astype(np.uint16), np.zeros(len(ticks), np.uint8))


def registers_word(registers: MotionRegisters) -> int:
    """All registers, the first one in the lowest bits."""
    word = at = 0
    for name in motion_addresses():
        if name != "mode":
            word |= getattr(registers, name) << at
            at += int(MOTION_RANGES[name][1]).bit_length()
    return word

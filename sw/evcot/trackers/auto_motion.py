# SPDX-License-Identifier: Apache-2.0
"""Registers and filters of the array with motion, from estimates about the scene.

Its rules follow size and speed of every object by themselves, so few registers depend on the scene: the filter against noise,
the length of a motion step, and the number of slots. docs/auto.md explains them, "Registers of the hardware".
"""

from __future__ import annotations

import math
from dataclasses import replace

from ..filters.config import FilterConfig
from ..hardware.config import CotConfig
from ..hardware.contract import SLOTS_MAX, Shape
from ..hardware.motion.contract import MotionRegisters
from .auto.estimates import Estimates, Objects
from .config import RunConfig
from .presets import PRESETS, fit

__all__ = ["motion_config"]

_STEP_PX = 1.25  # of travel in a motion step, of a fast object
_STEP_LOG2 = (8, 13)
_SPARE_SLOTS = 4
_FEWEST_SLOTS = 8
_NEIGHBOURS = 4.0  # events of an object in the eight pixels around one, in the time of the activity filter
_NEIGHBOUR_US = (1_000, 50_000)
_NEIGHBOUR_UNKNOWN_US = 10_000  # where no object was seen
_WINDOW = 9.0  # area of a window, by half side squared
_NOISE_SHARE = 0.01  # of an object's events, from which on noise is filtered
_MOST_NEIGHBOURS = 6


def motion_config(seen: Estimates, name: str, base: RunConfig = PRESETS["motion"]) -> RunConfig:
    """The configuration for a scene, of that name, with the automatic software tracker beside it.

    Where no object was seen, motion steps are those of `base`.

    Args:
        base: has the registers that do not depend on the scene.
    """
    motion = base.cot.motion
    if seen.objects is not None:
        motion = _in_steps_of(_step_log2(seen.objects), motion)
    cot = CotConfig(Shape(n_slots=_slots(seen.alive_most)), motion=motion)
    filters = _against_noise(seen, replace(base.filters, hot_pixels=seen.hot_pixels, activity_us=0))
    return fit(replace(base, name=name, cot=cot, filters=filters), *seen.sensor)


def _slots(alive_most: int) -> int:
    """A power of two, so that few different designs are compiled."""
    return min(max(_FEWEST_SLOTS, 1 << (alive_most + _SPARE_SLOTS - 1).bit_length()), SLOTS_MAX)


def _step_log2(objects: Objects) -> int:
    step_us = 1e6 * _STEP_PX / objects.speed_px_s.high
    return min(max(math.floor(math.log2(step_us)), _STEP_LOG2[0]), _STEP_LOG2[1])


def _in_steps_of(step_log2: int, motion: MotionRegisters) -> MotionRegisters:
    """The same times, in motion steps of 2^step_log2 ticks."""
    longer = step_log2 - motion.step_log2

    def steps(count: int) -> int:
        return max(1, round(count * 2.0**-longer))

    return replace(
        motion,
        step_log2=step_log2,
        friction=max(1, motion.friction - longer),
        join_steps=steps(motion.join_steps),
        report_steps=steps(motion.report_steps),
    )


def _against_noise(seen: Estimates, filters: FilterConfig) -> FilterConfig:
    """With the activity filter, if noise would be more than a small share of an object's events."""
    noise_per_us = 1e-6 * (seen.noise_hz or 0.0)
    if seen.objects is None:
        within_us, share = _NEIGHBOUR_UNKNOWN_US, float(noise_per_us > 0)
    else:
        half_px = seen.objects.half_px.median
        events_per_us = 1e-6 * seen.objects.pixels_per_px.median * seen.objects.speed_px_s.median
        per_px = events_per_us / (2 * half_px) ** 2
        within_us = round(min(max(_NEIGHBOURS / (8 * per_px), _NEIGHBOUR_US[0]), _NEIGHBOUR_US[1]))
        share = noise_per_us * _WINDOW * half_px**2 / events_per_us
    by_chance = 8 * noise_per_us * within_us
    support = next((n for n in range(_MOST_NEIGHBOURS) if share * _at_least(n, by_chance) <= _NOISE_SHARE), _MOST_NEIGHBOURS)
    return replace(filters, activity_us=within_us, activity_support=support) if support else filters


def _at_least(count: int, mean: float) -> float:
    """The probability of at least so many events, of a Poisson distribution with that mean."""
    return 1.0 - sum(math.exp(-mean) * mean**number / math.factorial(number) for number in range(count))

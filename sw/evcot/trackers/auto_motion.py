# SPDX-License-Identifier: Apache-2.0
"""Filters and number of slots of the array with motion, from estimates about the scene.

Its rules follow size and speed of every object by themselves, so its registers are those of a preset, on any recording. What
depends on the scene is the filter against noise. docs/auto.md explains it, "Registers of the hardware".
"""

from __future__ import annotations

from dataclasses import replace

from ..filters.config import FilterConfig
from ..filters.noise import support_against
from ..hardware.config import CotConfig
from ..hardware.contract import SLOTS_MAX, Shape
from .auto.estimates import Estimates
from .config import RunConfig
from .presets import FOLLOWING, PRESETS, fit

__all__ = ["motion_config"]

_SPARE_SLOTS = 4
_FEWEST_SLOTS = 8


def motion_config(seen: Estimates, name: str, base: RunConfig = PRESETS["motion"]) -> RunConfig:
    """The configuration for a scene, of that name, with the automatic software tracker beside it.

    Its filters are those of `FOLLOWING` as they are at the noise that was seen, and they hold.

    Args:
        base: has the registers.
    """
    cot = CotConfig(Shape(n_slots=_slots(seen.alive_most)), motion=base.cot.motion)
    return fit(replace(base, name=name, cot=cot, filters=_against_noise(seen)), *seen.sensor)


def _slots(alive_most: int) -> int:
    """A power of two, so that few different designs are compiled."""
    return min(max(_FEWEST_SLOTS, 1 << (alive_most + _SPARE_SLOTS - 1).bit_length()), SLOTS_MAX)


def _against_noise(seen: Estimates) -> FilterConfig:
    follow = FOLLOWING.filters
    held = replace(follow, activity_noise_hz=0.0, hot_pixels=seen.hot_pixels)
    support = support_against(seen.noise_hz or 0.0, follow.activity_us, follow.activity_noise_hz)
    return replace(held, activity_support=support) if support else replace(held, activity_us=0)

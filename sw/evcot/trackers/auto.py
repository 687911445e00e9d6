# SPDX-License-Identifier: Apache-2.0
"""The preset `auto`: the configuration of a run from estimates about the scene.

The rules of cot_motion follow size and speed of every object, so its registers are the same on any recording. What depends on
the scene is the noise filter and the number of slots. docs/auto.md explains both, "Settings of the hardware".
"""

from __future__ import annotations

from dataclasses import replace

from ..filters.config import FilterConfig
from ..filters.noise import support_against
from ..hardware.config import MotionConfig
from ..hardware.contract import SLOTS_MAX, Shape
from .adaptive.estimates import Estimates
from .config import RunConfig
from .presets import AUTO, FOLLOWING, MOTION, fit

__all__ = ["auto_config", "summary_line"]

_SPARE_SLOTS = 4
_FEWEST_SLOTS = 8


def auto_config(seen: Estimates, base: RunConfig = MOTION) -> RunConfig:
    """The configuration for a scene, with the adaptive software tracker beside the hardware.

    Its filters are those of `FOLLOWING` at the noise of the scene, and do not change during the run.

    Args:
        base: has the registers.
    """
    assert isinstance(base.hardware, MotionConfig)
    hardware = MotionConfig(Shape(n_slots=_slots(seen.alive_most)), base.hardware.registers)
    return fit(replace(base, name=AUTO, hardware=hardware, filters=_against_noise(seen)), *seen.sensor)


def summary_line(seen: Estimates, config: RunConfig) -> str:
    """A line on what was estimated, and on the configuration that follows from it."""
    chosen = [f"{config.hardware.module} with {config.hardware.shape.n_slots} slots"]
    chosen += [f"{which.name.lower()} filter" for which in config.filters.filters]
    return f"{seen} -> {', '.join(chosen)}"


def _slots(alive_most: int) -> int:
    """A power of two, so that few different designs are compiled."""
    return min(max(_FEWEST_SLOTS, 1 << (alive_most + _SPARE_SLOTS - 1).bit_length()), SLOTS_MAX)


def _against_noise(seen: Estimates) -> FilterConfig:
    follow = FOLLOWING.filters
    held = replace(follow, activity_noise_hz=0.0, hot_pixels=seen.hot_pixels)
    support = support_against(seen.noise_hz or 0.0, follow.activity_us, follow.activity_noise_hz)
    return replace(held, activity_support=support) if support else replace(held, activity_us=0)

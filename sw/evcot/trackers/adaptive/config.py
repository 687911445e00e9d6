# SPDX-License-Identifier: Apache-2.0
"""Settings of the adaptive tracker: none has a unit of length or time."""

from __future__ import annotations

from dataclasses import dataclass

from ...ranges import Range, check_ranges, ranges_of, setting

__all__ = ["ADAPTIVE_RANGES", "PRESETS", "AdaptiveConfig"]


@dataclass(frozen=True)
class AdaptiveConfig:
    """Settings of the adaptive tracker.

    Raises:
        ConfigError: a value outside its range.
    """

    max_objects: int = setting(64, 1, 256, "objects alive at once, visible or not")
    memory: float = setting(0.4, 0.01, 10.0, "half sides of travel that a look at an object takes in")
    fill: float = setting(4.0, 0.01, 1000.0, "pixels that a look wants to see, for each pixel of an object's sides")
    blur: float = setting(
        0.15, 0.01, 10.0, "half sides by which its pixels may be misplaced in a look, for its velocity is not known"
    )
    pause: float = setting(0.03, 0.01, 10.0, "half sides of travel between two looks")
    quantile: float = setting(0.015, 0.0, 0.4, "share of an object's pixels that lie beyond each of its sides")
    precision: float = setting(0.12, 0.001, 4.0, "standard deviation of a side in a look, half sides")
    gate: float = setting(0.35, 0.01, 4.0, "how far outside a box events still belong to it, half sides")
    dense: float = setting(
        0.4, 0.0, 1.0, "density that belongs to an object, as a part of that where its pixels lie on average"
    )
    agility: float = setting(
        0.4, 0.001, 100.0, "change of velocity while an object travels its half side, as a part of its speed"
    )
    growth_agility: float = setting(0.3, 0.0001, 100.0, "the same for the growth of its half sides")
    meeting_agility: float = setting(0.1, 0.0, 1.0, "factor of both while a box touches another")
    birth_pixels: int = setting(12, 2, 100_000, "different pixels above the noise that make an object")
    birth_speed: float = setting(
        0.08, 0.001, 100.0, "half sides that a new object is expected to travel while it collects them"
    )
    visible_travel: float = setting(0.25, 0.0, 100.0, "half sides that an object must have moved to be reported")
    coast: float = setting(1.0, 0.0, 1000.0, "half sides that an object would travel without support before it is lost")
    full: float = setting(
        0.6, 0.0, 10.0, "pixels that an object sends at least, for each pixel that it travels and each of its sides"
    )
    elongation: float = setting(2.2, 1.0, 100.0, "length by width from which on an object has no gap")
    gap: float = setting(0.9, 0.0, 4.0, "gap in an object, as a part of the length by which it is shorter than that")
    merge_velocity: float = setting(
        0.5, 0.0, 2.0, "difference of velocities, as a part of the greater, up to which motion is one"
    )
    step: float = setting(0.03, 0.0001, 1.0, "half sides that the fastest object travels in a packet")

    def __post_init__(self) -> None:
        check_ranges("adaptive", self)


ADAPTIVE_RANGES: dict[str, Range] = ranges_of(AdaptiveConfig)


PRESETS: dict[str, AdaptiveConfig] = {"auto": AdaptiveConfig()}

# SPDX-License-Identifier: Apache-2.0
"""Settings of the adaptive tracker: none has a unit of length or time."""

from __future__ import annotations

from dataclasses import dataclass

from ...ranges import Range, check_ranges

__all__ = ["ADAPTIVE_RANGES", "PRESETS", "AdaptiveConfig"]

# field -> (lowest, highest, meaning)
ADAPTIVE_RANGES: dict[str, Range] = {
    "max_objects": (1, 256, "objects alive at once, visible or not"),
    "memory": (0.01, 10.0, "half sides of travel that a look at an object takes in"),
    "fill": (0.01, 1000.0, "pixels that a look wants to see, for each pixel of an object's sides"),
    "blur": (0.01, 10.0, "half sides by which its pixels may be misplaced in a look, for its velocity is not known"),
    "pause": (0.01, 10.0, "half sides of travel between two looks"),
    "quantile": (0.0, 0.4, "share of an object's pixels that lie beyond each of its sides"),
    "precision": (0.001, 4.0, "standard deviation of a side in a look, half sides"),
    "gate": (0.01, 4.0, "how far outside a box events still belong to it, half sides"),
    "dense": (0.0, 1.0, "density that belongs to an object, as a part of that where its pixels lie on average"),
    "agility": (0.001, 100.0, "change of velocity while an object travels its half side, as a part of its speed"),
    "growth_agility": (0.0001, 100.0, "the same for the growth of its half sides"),
    "meeting_agility": (0.0, 1.0, "factor of both while a box touches another"),
    "birth_pixels": (2, 100_000, "different pixels above the noise that make an object"),
    "birth_speed": (0.001, 100.0, "half sides that a new object is expected to travel while it collects them"),
    "visible_travel": (0.0, 100.0, "half sides that an object must have moved to be reported"),
    "coast": (0.0, 1000.0, "half sides that an object would travel without support before it is lost"),
    "full": (0.0, 10.0, "pixels that an object sends at least, for each pixel that it travels and each of its sides"),
    "elongation": (1.0, 100.0, "length by width from which on an object has no gap"),
    "gap": (0.0, 4.0, "gap in an object, as a part of the length by which it is shorter than that"),
    "merge_velocity": (0.0, 2.0, "difference of velocities, as a part of the greater, up to which motion is one"),
    "step": (0.0001, 1.0, "half sides that the fastest object travels in a packet"),
}


@dataclass(frozen=True)
class AdaptiveConfig:
    """Settings of the adaptive tracker; limits in `ADAPTIVE_RANGES`.

    Raises:
        ConfigError: a value outside its range.
    """

    max_objects: int = 64
    memory: float = 0.4
    fill: float = 4.0
    blur: float = 0.15
    pause: float = 0.03
    quantile: float = 0.015
    precision: float = 0.12
    gate: float = 0.35
    dense: float = 0.4
    agility: float = 0.4
    growth_agility: float = 0.3
    meeting_agility: float = 0.1
    birth_pixels: int = 12
    birth_speed: float = 0.08
    visible_travel: float = 0.25
    coast: float = 1.0
    full: float = 0.6
    elongation: float = 2.2
    gap: float = 0.9
    merge_velocity: float = 0.5
    step: float = 0.03

    def __post_init__(self) -> None:
        check_ranges("adaptive", self, ADAPTIVE_RANGES)


PRESETS: dict[str, AdaptiveConfig] = {"auto": AdaptiveConfig()}

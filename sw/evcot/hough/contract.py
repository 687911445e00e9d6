# SPDX-License-Identifier: Apache-2.0
"""The contract of the line transform in RTL and in its model: shape, registers, and the table of cosines.

The hardware side is generated from it: see `hardware.generate`.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, pi

from ..errors import ConfigError
from ..ranges import check_ranges, setting

__all__ = ["ANGLES", "COSINES", "STAMP_W", "THRESHOLD", "HoughConfig"]

ANGLES = (16, 32)
"""Legal numbers of angles in half a turn."""

COSINES = tuple(round(256 * cos(pi * j / 32)) for j in range(17))
"""256 cos(j pi / 32), rounded, for a quarter turn; 16 angles take every second value."""

STAMP_W = 9
"""Bits of a period in a cell's word."""

THRESHOLD = 8
"""Hits at which a cell fires."""


@dataclass(frozen=True)
class HoughConfig:
    """Shape and register of the line transform; the RTL checks sensor and angles at elaboration.

    Raises:
        ConfigError: a value outside its range.
    """

    width: int = setting(346, 1, 2048, "pixels of the sensor across")
    height: int = setting(260, 1, 2048, "pixels of the sensor down")
    angles: int = setting(16, 16, 32, "angles in half a turn, 16 or 32")
    leak_log2: int = setting(5, 2, 9, "log2 of the events in which each cell loses one hit")

    def __post_init__(self) -> None:
        check_ranges("hough", self)
        if self.angles not in ANGLES:
            raise ConfigError(f"hough.angles = {self.angles}: must be 16 or 32")

    @property
    def rho_w(self) -> int:
        """Bits of a cell's index along rho: 2^rho_w cells of 1 px cover the diagonal of the sensor."""
        squared = (self.width + 8) ** 2 + (self.height + 8) ** 2
        return ((squared - 1).bit_length() + 1) // 2

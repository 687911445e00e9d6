# SPDX-License-Identifier: Apache-2.0
"""Settings of the frame pipeline."""

from __future__ import annotations

from dataclasses import dataclass

from ...errors import ConfigError
from ...ranges import Range, check_ranges
from ..detections.identity import IDENTITY_RANGES, IdentityConfig

__all__ = ["FRAME_RANGES", "PRESETS", "FrameConfig"]

# field -> (lowest, highest, meaning)
FRAME_RANGES: dict[str, Range] = {
    **IDENTITY_RANGES,
    "frame_us": (1, 10**9, "length of a frame"),
    "median_px": (1, 15, "side of the median filter's square, odd; 1 for none"),
    "link_px": (0, 255, "widest gap, in pixels without an event, across which components still belong together"),
    "area_min_px": (1, 2**31, "fewest pixels of an object"),
}


@dataclass(frozen=True)
class FrameConfig(IdentityConfig):
    """Settings of the frame pipeline; limits in `FRAME_RANGES`.

    Raises:
        ConfigError: a value outside its range, or a median filter of even side.
    """

    frame_us: int = 20_000
    median_px: int = 3
    link_px: int = 4
    area_min_px: int = 12

    def __post_init__(self) -> None:
        check_ranges("frames", self, FRAME_RANGES)
        if self.median_px % 2 == 0:
            raise ConfigError(f"frames.median_px = {self.median_px}: must be odd, so that the square has a middle")


PRESETS: dict[str, FrameConfig] = {
    # Contours are one or two pixels wide, which a median filter would remove.
    "discs": FrameConfig(visible_hits=4, frame_us=5_000, median_px=1, link_px=6, area_min_px=12),
    "traffic": FrameConfig(gate_px=30.0, smoothing_us=30_000, frame_us=20_000, median_px=3, link_px=18, area_min_px=20),
}

# SPDX-License-Identifier: Apache-2.0
"""Settings of the frame pipeline, and of the track management that it shares with mean shift clustering."""

from __future__ import annotations

from dataclasses import dataclass

from ...errors import ConfigError
from ...ranges import Range, check_ranges

__all__ = ["FRAME_RANGES", "IDENTITY_RANGES", "FrameConfig", "IdentityConfig"]

# field -> (lowest, highest, meaning)
IDENTITY_RANGES: dict[str, Range] = {
    "max_tracks": (1, 1024, "tracks alive at once, visible or not"),
    "gate_px": (0.1, 10_000.0, "farthest a detection may lie from where its track is expected"),
    "smoothing_us": (0, 10**9, "time constant with which a track takes over what is measured; 0 takes it as it is"),
    "visible_hits": (1, 1_000_000, "detections after which a track becomes visible"),
    "candidate_us": (1, 10**12, "silence after which a track that is not yet visible is dropped"),
    "lifetime_us": (1, 10**12, "silence after which a visible track is lost"),
}

FRAME_RANGES: dict[str, Range] = {
    **IDENTITY_RANGES,
    "frame_us": (1, 10**9, "length of a frame"),
    "median_px": (1, 15, "side of the median filter's square, odd; 1 for none"),
    "link_px": (0, 255, "widest gap, in pixels without an event, across which components still belong together"),
    "area_min_px": (1, 2**31, "fewest pixels of an object"),
    "area_max_px": (1, 2**31, "most pixels of an object"),
}


@dataclass(frozen=True)
class IdentityConfig:
    """Settings of track management: from detections to tracks; limits in `IDENTITY_RANGES`."""

    max_tracks: int = 64
    gate_px: float = 20.0
    smoothing_us: int = 10_000
    visible_hits: int = 3
    candidate_us: int = 20_000
    lifetime_us: int = 100_000


@dataclass(frozen=True)
class FrameConfig(IdentityConfig):
    """Settings of the frame pipeline; limits in `FRAME_RANGES`.

    Raises:
        ConfigError: a value outside its range, a median filter of even side, or a smallest area above the largest.
    """

    frame_us: int = 20_000
    median_px: int = 3
    link_px: int = 4
    area_min_px: int = 12
    area_max_px: int = 2**31

    def __post_init__(self) -> None:
        check_ranges("frames", self, FRAME_RANGES)
        if self.median_px % 2 == 0:
            raise ConfigError(f"frames.median_px = {self.median_px}: must be odd, so that the square has a middle")
        if self.area_min_px > self.area_max_px:
            raise ConfigError(f"frames.area_min_px = {self.area_min_px}: must be at most area_max_px = {self.area_max_px}")

# SPDX-License-Identifier: Apache-2.0
"""Named settings of the frame pipeline."""

from __future__ import annotations

from .config import FrameConfig

__all__ = ["PRESETS"]

PRESETS: dict[str, FrameConfig] = {
    # Contours are one or two pixels wide, which a median filter would remove.
    "discs": FrameConfig(
        frame_us=5_000,
        median_px=1,
        link_px=6,
        area_min_px=12,
        gate_px=20.0,
        smoothing_us=10_000,
        visible_hits=4,
        candidate_us=20_000,
        lifetime_us=150_000,
    ),
    "traffic": FrameConfig(
        frame_us=20_000,
        median_px=3,
        link_px=18,
        area_min_px=20,
        gate_px=30.0,
        smoothing_us=30_000,
        visible_hits=3,
        candidate_us=45_000,
        lifetime_us=150_000,
    ),
}

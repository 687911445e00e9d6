# SPDX-License-Identifier: Apache-2.0
"""Named settings of mean shift: two situations, each clustered in packets of events and in frames."""

from __future__ import annotations

from dataclasses import replace

from .config import MeanShiftConfig

__all__ = ["PRESETS"]

# A contour of about 20 px: from a bandwidth of 0.7 of its radius on, its centre is a single mode.
_DISCS = MeanShiftConfig(
    bandwidth_px=8.0,
    fold_px=2.0,
    fuse_px=8.0,
    tolerance_px=0.2,
    points_min=8,
    packet_events=300,
    gate_px=20.0,
    smoothing_us=10_000,
    visible_hits=5,
    candidate_us=20_000,
    lifetime_us=150_000,
)

# Vehicles of 25 to 90 px: the smallest must not be fused, the largest not split.
_TRAFFIC = MeanShiftConfig(
    bandwidth_px=18.0,
    fold_px=6.0,
    fuse_px=18.0,
    tolerance_px=0.4,
    points_min=15,
    packet_events=500,
    gate_px=25.0,
    smoothing_us=30_000,
    visible_hits=10,
    candidate_us=20_000,
    lifetime_us=150_000,
)

PRESETS: dict[str, MeanShiftConfig] = {
    "discs": _DISCS,
    "discs-frames": replace(_DISCS, source="frames", frame_us=5_000, visible_hits=5),
    "traffic": _TRAFFIC,
    "traffic-frames": replace(_TRAFFIC, source="frames", frame_us=20_000, points_min=40, visible_hits=3, candidate_us=50_000),
}

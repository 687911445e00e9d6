# SPDX-License-Identifier: Apache-2.0
"""Named settings of the Rectangular Cluster Tracker: the paper's, and one per kind of scene; and their filters."""

from __future__ import annotations

from ...filters.config import FilterConfig
from .config import RctConfig

__all__ = ["FILTERS", "PRESETS"]

PRESETS: dict[str, RctConfig] = {
    "plain": RctConfig(),
    # A road that leads away from the camera, 346x260: cars shrink towards a row above the image. docs/evaluation.md has the
    # results, and the data used for tuning.
    "traffic": RctConfig(
        radius_px=44.0,
        aspect=1.3,
        vanishing_y_px=-60.0,
        reference_y_px=200.0,
        surround=2.5,
        packet_us=2_000,
        box_quantile=0.045,
        path_points=26,
        predict=0.7,
        visible_rate_hz=450.0,
        birth_spread_px=3.0,
        lifetime_us=20_000,
        coast_us=50_000,
        merge_overlap=0.45,
    ),
    # Round objects of one size, about 20 px wide, with events on the whole contour. Where two cross, the older takes all events
    # within its reach, and the younger coasts with its last velocity.
    "discs": RctConfig(
        radius_px=11.5,
        assign="first",
        surround=3.0,
        box_quantile=0.05,
        path_points=120,
        predict=1.0,
        visible_rate_hz=3_000.0,
        birth_spread_px=4.0,
        lifetime_us=5_000,
        coast_us=50_000,
        merge_overlap=0.85,
    ),
}

# Preset -> filters in front of the tracker.
FILTERS: dict[str, FilterConfig] = {
    "traffic": FilterConfig(activity_us=5_000),
}

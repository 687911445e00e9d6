# SPDX-License-Identifier: Apache-2.0
"""Settings of the Rectangular Cluster Tracker by name: the paper's, and one per kind of scene."""

from __future__ import annotations

from .config import RctConfig

__all__ = ["PRESETS"]

PRESETS: dict[str, RctConfig] = {
    "plain": RctConfig(),
    # A road that leads away from the camera, 346x260: cars shrink towards a row above the picture.
    "traffic": RctConfig(
        max_clusters=48,
        radius_px=58.0,
        perspective="row",
        vanishing_y_px=-65.0,
        reference_y_px=200.0,
        centre="box",
        box_quantile=0.03,
        velocity="regression",
        path_points=60,
        predict=1.0,
        friction_tau_us=30_000.0,
        mass_tau_us=20_000.0,
        visibility="rate",
        visible_rate_hz=4_000.0,
        hidden_share=0.3,
        birth_spread_px=3.0,
        lifetime_us=60_000,
        merge_overlap=0.1,
        merge_angle_deg=60.0,
    ),
    # Round objects of one size, about 20 px wide, that keep to ways of their own.
    "discs": RctConfig(
        radius_px=14.0,
        centre="box",
        box_quantile=0.03,
        velocity="regression",
        path_points=50,
        predict=1.0,
        friction_tau_us=50_000.0,
        mass_tau_us=10_000.0,
        visibility="rate",
        visible_rate_hz=3_000.0,
        hidden_share=0.2,
        birth_spread_px=3.0,
        merge_overlap=0.3,
        merge_angle_deg=60.0,
    ),
}

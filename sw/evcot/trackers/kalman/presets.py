# SPDX-License-Identifier: Apache-2.0
"""Named settings of the Kalman tracker."""

from __future__ import annotations

from .config import KalmanConfig

__all__ = ["PRESETS"]

PRESETS: dict[str, KalmanConfig] = {
    # Cars driving away: they enter partially, shrink, and leave trailing events behind them.
    "traffic": KalmanConfig(),
    # Rigid objects with events on the whole contour, which cross and bounce off the sensor's edges: they do not grow or merge,
    # and keep their course while they cross.
    "discs": KalmanConfig(
        packet_us=1_000,
        refractory_us=0,
        afterglow=0.0,
        gate_share=0.0,
        events_per_sample=2.0,
        velocity_walk=15.0,
        growth_walk=0.15,
        meeting_walk=0.03,
        speed=20.0,
        merge_velocity=0.0,
        walls=True,
    ),
    # Cars and people on one road: people are slow and cause few events, so births and gaps may take longer.
    "road": KalmanConfig(packet_us=4_000, birth_us=30_000, birth_pixels=10, coast_us=250_000, speed=12.0),
}

# SPDX-License-Identifier: Apache-2.0
"""The box experiment with the settings of the paper's Table 2: runs one setting on one recording."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from evcot.hardware.config import CotConfig
from evcot.hardware.contract import Shape
from evcot.scenes.boxes import BoxExperiment, simulate
from evcot.scenes.scene import Scene
from evcot.trackers.config import RunConfig
from evcot.trackers.presets import fit, preset
from evcot.tracks.log import Kind, TrackLog
from exact import cot_log
from following import follow

__all__ = [
    "ADJUSTMENTS",
    "SPEEDS",
    "Adjustment",
    "Outcome",
    "Setting",
    "Speed",
    "configured",
    "n_ev_over_time",
    "outcome",
    "scene",
]

Speed = Literal["slow", "fast"]

SPEEDS: tuple[Speed, ...] = ("slow", "fast")
_SLOTS = 16  # more than boxes: no track is missing for want of a slot
# Sampling interval. Fast boxes move 1.6 px in it and not a whole number of pixels: events come at certain phases of a pixel.
_STEP_US = 4_007


class Adjustment(StrEnum):
    """What N_ev does, from window of events to window."""

    FIXED = "fixed"
    COARSE = "half to twice, 1 ms"
    FINE = "half to twice, 10 us"
    WIDE = "1 to 64, 10 us"


# length of a tick in us, TH in ticks, N_ev's bounds (None: half and twice the initial one)
ADJUSTMENTS: dict[Adjustment, tuple[int, int, tuple[int, int] | None]] = {
    Adjustment.COARSE: (1_000, 2, None),
    Adjustment.FINE: (10, 10, None),
    Adjustment.WIDE: (10, 10, (1, 64)),
}


@dataclass(frozen=True)
class Setting:
    """Initial N_ev, TC, how N_ev moves, and k in alpha = 2^-k: 1 in the paper."""

    n_ev: int
    tc_ms: int
    adjustment: Adjustment
    hist_avg: int = 1


@dataclass(frozen=True)
class Outcome:
    """Results of one setting on one recording.

    Attributes:
        updates: CM updates.
        found: part of the instants of moving boxes at which a track was on its box.
        error_px, error_p90_px: distance of centre and box, median and 90 % quantile.
        lag_px, lag_ms: how far, and how long, behind the box along its motion, medians.
        lost, switches, fragments, born: as `following.Following` has them.
        n_ev: mean over the tracks' time.
        at_low, at_high: part of that time at N_ev's lower and upper bound.
    """

    updates: float
    found: float
    error_px: float
    error_p90_px: float
    lag_px: float
    lag_ms: float
    lost: float
    switches: float
    fragments: float
    born: float
    n_ev: float
    at_low: float
    at_high: float


def scene(speed: Speed, seed: int, duration_us: int = 2_500_000) -> Scene:
    """Boxes of one speed."""
    return simulate(BoxExperiment(speed=speed, seed=seed, duration_us=duration_us, truth_step_us=_STEP_US))


def configured(setting: Setting, sensor: tuple[int, int]) -> RunConfig:
    """The paper's preset with a setting's N_ev, TC, adjustment and alpha; all times but TC and TH stay."""
    base = preset("slow").hardware
    assert isinstance(base, CotConfig)
    slot = replace(base.slots[0], clust_nev=setting.n_ev, nev_min=setting.n_ev, nev_max=setting.n_ev, hist_avg=setting.hist_avg)
    tick_us = base.tick_us
    if setting.adjustment is not Adjustment.FIXED:
        tick_us, threshold, bounds = ADJUSTMENTS[setting.adjustment]
        low, high = bounds or (max(1, setting.n_ev // 2), 2 * setting.n_ev)
        slot = replace(slot, nev_min=low, nev_max=high, nev_th=threshold)
    per_tick = base.tick_us // tick_us
    slot = replace(slot, max_ticks=1_000 * setting.tc_ms // tick_us, detect_ticks=slot.detect_ticks * per_tick)
    return fit(RunConfig("table2", CotConfig.uniform(Shape(n_slots=_SLOTS), slot, tick_us)), *sensor)


def n_ev_over_time(log: TrackLog) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The N_ev that tracks had and for how long each, in us: from every record but a track's last to its next; (n,) each."""
    records = log.records[np.argsort(log.records["track_id"], kind="stable")]
    followed = records["track_id"][1:] == records["track_id"][:-1]
    lasted_us = np.diff(records["t_us"])[followed]
    return records["n_ev"][:-1][followed].astype(np.int64), lasted_us


def outcome(of: Scene, setting: Setting, *, rtl: bool = True) -> Outcome:
    """Run one setting on a scene and hold its tracks against the boxes.

    Raises:
        MismatchError: hardware and model differ.
    """
    config = configured(setting, (of.recording.width, of.recording.height))
    log = cot_log(of.recording, config, rtl=rtl)
    found = follow(log, of, 1_000 * setting.tc_ms)
    n_ev, lasted_us = n_ev_over_time(log)
    assert isinstance(config.hardware, CotConfig)
    slot = config.hardware.slots[0]
    return Outcome(
        updates=len(log.of_kind(Kind.BORN)) + len(log.of_kind(Kind.MOVED)),
        found=len(found.error_px) / found.objects,
        error_px=float(np.median(found.error_px)),
        error_p90_px=float(np.quantile(found.error_px, 0.9)),
        lag_px=float(np.median(found.lag_px)),
        lag_ms=float(np.median(found.lag_ms)),
        lost=found.lost,
        switches=found.switches,
        fragments=found.fragments,
        born=found.born,
        n_ev=float(np.average(n_ev, weights=lasted_us)),
        at_low=float(np.average(n_ev == slot.nev_min, weights=lasted_us)),
        at_high=float(np.average(n_ev == slot.nev_max, weights=lasted_us)),
    )

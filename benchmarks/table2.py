# SPDX-License-Identifier: Apache-2.0
"""Slow against fast: the box experiment with the paper's Table 2, in hardware and golden model, bit for bit.

N_ev of 8, 5 and 3 and a timer TC of 20 and 7 ms, on slow boxes (80 px/s) and on fast ones (400 px/s), with N_ev fixed and
with its dynamic adjustment. `python benchmarks/table2.py` prints docs/table2.md's table; --figure draws docs/images/table2.png.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from enum import StrEnum
from itertools import product
from pathlib import Path
from statistics import fmean
from typing import Literal

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from cot_quality import cot_log
from evcot.hardware.config import CotConfig
from evcot.hardware.contract import Shape
from evcot.scenes.boxes import BoxExperiment, simulate
from evcot.scenes.truth import Scene
from evcot.trackers.config import RunConfig
from evcot.trackers.presets import fit, preset
from evcot.tracks.log import Kind, TrackLog
from following import follow
from measure import Result, heading, line

__all__ = [
    "ADJUSTMENTS",
    "SPEEDS",
    "Adjustment",
    "Outcome",
    "Setting",
    "Speed",
    "configured",
    "draw",
    "measure",
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


_N_EV = (1, 2, 3, 5, 8, 12, 16, 24, 32)
_HIST_AVG = (1, 2, 3)
_COLOURS = {"slow": "#0072B2", "fast": "#D55E00"}
_DASHES = ("solid", "dashed", "dotted")
_SHOWN_MS = (1_100, 1_200)
_LADDER = 2.0 ** np.arange(7)  # values of N_ev that start at 8 and are bound by 1 and 64


def draw(path: Path) -> Path:
    """Measure with the golden model and draw."""
    figure, axes = plt.subplots(1, 4, figsize=(15, 3.8), layout="constrained")
    for speed in SPEEDS:
        of = scene(speed, 1)
        for hist_avg, dashes in zip(_HIST_AVG, _DASHES, strict=True):
            found = [outcome(of, Setting(n_ev, 20, Adjustment.FIXED, hist_avg), rtl=False) for n_ev in _N_EV]
            label = f"{speed}, α = 1/{2**hist_avg}"
            for axis, name in zip(axes, ("error_px", "lag_px"), strict=False):
                values = [getattr(one, name) for one in found]
                axis.plot(_N_EV, values, color=_COLOURS[speed], linestyle=dashes, marker=".", label=label)
        config = configured(Setting(8, 20, Adjustment.WIDE), (of.recording.width, of.recording.height))
        log = cot_log(of.recording, config, rtl=False)
        _course(axes[2], log, of, speed)
        _shares(axes[3], log, speed)
    for axis, title in zip(axes, ("position error, median", "lag along the motion, median"), strict=False):
        axis.set(title=title, xlabel="N_ev, fixed", ylabel="px", xscale="log", xticks=(1, 2, 4, 8, 16, 32), ylim=(0, None))
        axis.xaxis.set_major_formatter("{x:g}")
        axis.minorticks_off()
    axes[0].legend(fontsize="x-small")
    for axis in axes[2:]:
        axis.legend(fontsize="x-small")
    axes[2].set(
        title="one track, adjusted from 8 within 1 to 64", xlabel="time, ms", ylabel="N_ev", yscale="log", yticks=_LADDER
    )
    axes[2].yaxis.set_major_formatter("{x:g}")
    axes[3].set(title="where N_ev is, all boxes", xlabel="N_ev", ylabel="part of the time", xticks=range(7))
    axes[3].set_xticklabels([f"{n:g}" for n in _LADDER])
    for axis in axes:
        axis.grid(linewidth=0.3)
    figure.savefig(path, dpi=90)
    return path


def _course(axis: Axes, log: TrackLog, of: Scene, speed: str) -> None:
    """N_ev of the track that lives longest."""
    records = log.records[log.records["kind"] <= Kind.MOVED]
    ids, count = np.unique(records["track_id"], return_counts=True)
    own = records[records["track_id"] == ids[np.argmax(count)]]
    t_ms = (own["t_us"] - of.recording.events.t_us[0]) / 1_000
    axis.step(t_ms, own["n_ev"], where="post", color=_COLOURS[speed], linewidth=0.8, label=speed)
    axis.set_xlim(*_SHOWN_MS)


def _shares(axis: Axes, log: TrackLog, speed: str) -> None:
    n_ev, lasted_us = n_ev_over_time(log)
    shares = [np.average(n_ev == n, weights=lasted_us) for n in _LADDER]
    axis.bar(np.arange(7) + (-0.2 if speed == "slow" else 0.2), shares, 0.4, color=_COLOURS[speed], label=speed)


N_EV = (8, 5, 3)
TC_MS = (20, 7)
_PAPERS: tuple[tuple[Speed, int, int], ...] = (("slow", 8, 20), ("fast", 5, 7), ("fast", 3, 7))
_FIGURE = Path(__file__).parents[1] / "docs" / "images" / "table2.png"

# field of `Outcome` -> (heading, format)
_COLUMNS = {
    "updates": ("CM updates", ",.0f"),
    "found": ("found", ".1%"),
    "error_px": ("error, px", ".2f"),
    "error_p90_px": ("90 %", ".2f"),
    "lag_px": ("lag, px", ".2f"),
    "lag_ms": ("ms", ".2f"),
    "lost": ("lost", ".1f"),
    "switches": ("switches", ".1f"),
    "fragments": ("fragments", ".1f"),
    "born": ("tracks born", ",.0f"),
    "n_ev": ("N_ev", ".1f"),
    "at_low": ("lowest", ".0%"),
    "at_high": ("highest", ".0%"),
}


def measure(_folder: Path, quick: bool) -> Iterator[Result]:
    """Error and lag of the paper's settings; the reference is the same with N_ev fixed."""
    for speed, n_ev, tc_ms in _PAPERS:
        of = scene(speed, 1, 500_000 if quick else 2_500_000)
        fixed, adjusted = (outcome(of, Setting(n_ev, tc_ms, which)) for which in (Adjustment.FIXED, Adjustment.COARSE))
        how = f"{speed} boxes, N_ev {n_ev}, TC {tc_ms} ms; hardware and model the same bits"
        for name, unit in (("error_px", "px"), ("lag_ms", "ms")):
            value, reference = getattr(adjusted, name), getattr(fixed, name)
            yield Result(f"table2_{speed}_{n_ev}_{name}", value, unit, reference, "N_ev fixed", how=how)


def main() -> None:
    """Measure and print; draw where asked to."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=3, metavar="N", help="recordings of each speed (default: 3)")
    parser.add_argument("--hist-avg", type=int, default=1, metavar="K", help="alpha = 2^-K (default: 1, the paper's)")
    parser.add_argument("--model", action="store_true", help="the golden model alone: four times as fast")
    parser.add_argument("--figure", action="store_true", help=f"draw {_FIGURE.name} too")
    options = parser.parse_args()
    for speed in SPEEDS:
        scenes = [scene(speed, seed) for seed in range(1, 1 + options.seeds)]
        print(f"{speed} boxes, seeds 1 to {options.seeds}\n")
        heading("N_ev", "TC, ms", "adjusted", *(title for title, _ in _COLUMNS.values()))
        for adjustment, n_ev, tc_ms in product(Adjustment, N_EV, TC_MS):
            setting = Setting(n_ev, tc_ms, adjustment, options.hist_avg)
            mean = _mean([outcome(of, setting, rtl=not options.model) for of in scenes])
            cells = [format(getattr(mean, name), form) for name, (_, form) in _COLUMNS.items()]
            line([str(n_ev), str(tc_ms), adjustment, *cells])
        print()
    if options.figure:
        print(draw(_FIGURE))


def _mean(outcomes: Sequence[Outcome]) -> Outcome:
    return Outcome(**{field.name: fmean(getattr(one, field.name) for one in outcomes) for field in fields(Outcome)})


if __name__ == "__main__":
    main()

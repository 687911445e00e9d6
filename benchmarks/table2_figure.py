# SPDX-License-Identifier: Apache-2.0
"""The picture of Table 2: what N_ev and alpha do to error and lag, and where the adjustment takes N_ev."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from evcot.scenes.scene import Scene
from evcot.tracks.log import Kind, TrackLog
from exact import cot_log
from table2_runs import SPEEDS, Adjustment, Setting, configured, n_ev_over_time, outcome, scene

__all__ = ["draw"]

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

# SPDX-License-Identifier: Apache-2.0
"""ROC curves of the noise filters: a table on the terminal, and docs/images/filters_roc.png.

The box experiment without background activity is the signal (the flicker of moving contours belongs to it); noise of known
rate is added to it; each filter is swept over its window.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from evcot.filters.config import FilterConfig
from evcot.filters.run import Effect, add_noise, area_under_curve, effect
from evcot.scenes.boxes import BoxExperiment, simulate

NOISE_HZ_PER_PX = (1.0, 5.0, 10.0)
WINDOWS_US = np.geomspace(50, 500_000, 25).round().astype(int).tolist()
FILTERS: dict[str, tuple[str, FilterConfig]] = {
    "activity": ("activity_us", FilterConfig()),
    "activity, 2 neighbours": ("activity_us", FilterConfig(activity_support=2)),
    "recent, 32 events": ("recent_us", FilterConfig()),
    "recent, 256 events": ("recent_us", FilterConfig(recent_depth=256)),
    "decay": ("decay_tau_us", FilterConfig()),
    "row and column": ("rowcol_us", FilterConfig()),
    **{
        f"activity, 2 neighbours, cells of {side}": ("activity_us", FilterConfig(activity_support=2, cell_px=side))
        for side in (1, 2, 4)
    },
    **{f"decay, cells of {side}": ("decay_tau_us", FilterConfig(cell_px=side)) for side in (2, 4)},
}
EXACT = 5  # the first curves: those of filters with a time stamp per pixel, or a FIFO
PICTURE = Path(__file__).parents[1] / "docs" / "images" / "filters_roc.png"

Curves = Mapping[str, list[Effect]]


def main() -> None:
    """Measure, print, draw."""
    clean = simulate(BoxExperiment(noise_hz_per_px=0.0)).recording
    curves: dict[float, Curves] = {}
    for hz_per_px in NOISE_HZ_PER_PX:
        recording, is_noise = add_noise(clean, hz_per_px, np.random.default_rng(1))
        curves[hz_per_px] = {
            name: [effect(recording, is_noise, replace(base, **{field: us})) for us in WINDOWS_US]
            for name, (field, base) in FILTERS.items()
        }
        _print(hz_per_px, float(is_noise.mean()), curves[hz_per_px])
    _draw(curves)
    print(PICTURE)


def _print(hz_per_px: float, share: float, curves: Curves) -> None:
    print(f"noise {hz_per_px:g} Hz per pixel, {share:.0%} of the events")
    for name, effects in curves.items():
        best = max(range(len(effects)), key=lambda i: effects[i].signal_kept + effects[i].noise_removed)
        signal, removed = effects[best].signal_kept, effects[best].noise_removed
        print(
            f"  {name:36} AUC {area_under_curve(effects):.3f}; "
            f"at {WINDOWS_US[best] / 1000:5.1f} ms: signal kept {signal:.1%}, noise removed {removed:.1%}",
            flush=True,
        )


def _draw(curves: Mapping[float, Curves]) -> None:
    figure, axes = plt.subplots(1, len(curves), figsize=(13, 6), sharey=True, layout="constrained")
    for axis, (hz_per_px, by_filter) in zip(axes, curves.items(), strict=True):
        for number, (name, effects) in enumerate(by_filter.items()):
            style = "-" if number < EXACT else "--"
            signal, noise = zip(*effects, strict=True)
            axis.plot(
                noise,
                signal,
                marker=".",
                markersize=4,
                linewidth=1,
                linestyle=style,
                label=f"{name} ({area_under_curve(effects):.3f})",
            )
        axis.set(title=f"noise {hz_per_px:g} Hz per pixel", xlabel="noise kept", xscale="log", xlim=(1e-4, 1), ylim=(0, 1.02))
        axis.grid(linewidth=0.3)
        axis.legend(title="filter (area under curve)", fontsize="x-small", title_fontsize="x-small", loc="lower right")
    axes[0].set_ylabel("signal kept")
    figure.savefig(PICTURE, dpi=90)


if __name__ == "__main__":
    main()

# SPDX-License-Identifier: Apache-2.0
"""The effect of filters on noise: shares of signal and noise events that pass, for events of known kind."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..events import Events, Recording
from .config import FilterConfig
from .run import apply

__all__ = ["Effect", "add_noise", "area_under_curve", "effect"]


class Effect(NamedTuple):
    """Shares of signal and noise events that pass, 0 to 1."""

    signal_kept: float
    noise_kept: float

    @property
    def noise_removed(self) -> float:
        """Share of the noise that is removed."""
        return 1 - self.noise_kept


def add_noise(recording: Recording, hz_per_px: float, random: np.random.Generator) -> tuple[Recording, NDArray[np.bool_]]:
    """Add background activity to a clean recording: a Poisson process per pixel, with random polarity.

    Returns:
        The recording with noise from its first to its last event, and a mask of the noise events, (n,) bool. At equal times
        noise comes last.
    """
    clean, width, height = recording.events, recording.width, recording.height
    count = random.poisson(hz_per_px * width * height * recording.duration_us * 1e-6)
    t_us = clean.t_us[0] + random.integers(0, recording.duration_us, count, endpoint=True) if count else clean.t_us[:0]
    addresses = (random.integers(0, high, count) for high in (width, height, 2))
    together = Events.joined(
        [clean, Events(t_us, *(column.astype(kind) for column, kind in zip(addresses, ("u2", "u2", "u1"), strict=True)))]
    )
    order = np.argsort(together.t_us, kind="stable")
    events = Events(together.t_us[order], together.x[order], together.y[order], together.p[order])
    return Recording(events, width, height, recording.name), order >= len(clean)


def effect(recording: Recording, is_noise: NDArray[np.bool_], config: FilterConfig) -> Effect:
    """The shares of signal and noise that pass the filters; there must be events of both."""
    keep = apply(recording, config)[1]
    return Effect(float(keep[~is_noise].mean()), float(keep[is_noise].mean()))


def area_under_curve(effects: Iterable[Effect]) -> float:
    """Area under the curve of signal kept over noise kept, through (0, 0) and (1, 1); 1 is perfect, 0.5 is chance.

    Args:
        effects: of one filter from its strictest to its most permissive setting.
    """
    signal, noise = np.array([Effect(0, 0), *effects, Effect(1, 1)]).T
    return float(np.trapezoid(signal, noise))

# SPDX-License-Identifier: Apache-2.0
"""Filter a recording in memory, or a stream of blocks of events; and the effect of filters on noise."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..events import Events, Recording
from ..ticks import TickCounter
from .chain import FilterChain, Total
from .config import FilterConfig
from .contract import Filter

__all__ = ["Effect", "Filtered", "add_noise", "apply", "area_under_curve", "effect", "filtered"]


class Filtered(Iterator[Events]):
    """Iterator over the events that pass, block by block; `totals` are updated with each block."""

    def __init__(self, blocks: Iterable[Events], chain: FilterChain, tick_us: int) -> None:
        self._blocks = iter(blocks)
        self._chain = chain
        self._clock = TickCounter(tick_us)

    def __next__(self) -> Events:
        block = next(self._blocks)
        return block.where(self.keep(block))

    def keep(self, block: Events) -> NDArray[np.bool_]:
        """The mask of the events of the next block that pass, (n,) bool; tick 0 is the time of the very first event."""
        return self._chain.feed(self._clock.count(block))

    @property
    def totals(self) -> dict[Filter, Total]:
        """Event counts of each enabled filter so far, in the order of the chain."""
        return self._chain.totals


def filtered(blocks: Iterable[Events], config: FilterConfig, sensor: tuple[int, int], tick_us: int = 1) -> Filtered:
    """Filter a stream of blocks of events; memory does not grow with its length.

    Args:
        blocks: events in time order.
        sensor: (width, height) in pixels.
        tick_us: length of a tick.

    Raises:
        ConfigError: a time that cannot be represented in ticks, or a hot pixel outside the sensor.
    """
    return Filtered(blocks, FilterChain(config.registers(tick_us), config.shape(*sensor)), tick_us)


def apply(recording: Recording, config: FilterConfig, tick_us: int = 1) -> tuple[Recording, NDArray[np.bool_]]:
    """A recording of the events that pass, with the same name, and their mask, (n,) bool; raises as `filtered` does."""
    keep = filtered((), config, (recording.width, recording.height), tick_us).keep(recording.events)
    return Recording(recording.events.where(keep), recording.width, recording.height, recording.name), keep


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

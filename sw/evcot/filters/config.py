# SPDX-License-Identifier: Apache-2.0
"""Settings of the filters in physical units, and their conversion to the hardware's registers.

`thresholds` follows docs/filters.md, "Support that follows the noise".
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ..errors import ConfigError
from ..ranges import Range, check_ranges, ranges_of, setting
from .contract import (
    CELL_LOG2,
    CELL_PX,
    CELL_STAMP_W,
    CLOCK_FRAC,
    FILTER_REGISTERS,
    LEVEL_FRAC,
    LEVEL_MAX,
    NOISE_SUPPORTS,
    UNITS_PER_HALF_LIFE,
    Filter,
    FilterShape,
)
from .registers import FilterRegisters

__all__ = ["DEFAULT_FILTERS", "FILTER_RANGES", "FilterConfig", "thresholds"]

_NOISE_WINDOW_US = 1 << 14


@dataclass(frozen=True)
class FilterConfig:
    """The filters in front of both trackers, all off by default; see docs/filters.md.

    Attributes:
        region: (x0, y0, x1, y1), first and last column and row that pass, in pixels; None is off.
        polarity: the polarity that passes; None is off.
        hot_pixels: (x, y) of the pixels that are masked.
        activity_noise_hz: events of noise that may pass the activity filter, per pixel and second: the noise is measured, and
            activity_support follows it; needs memories of cells. 0 is off.
        cell_px: memories of refractory, activity and decay: 0, a time stamp per pixel in each; 1, 2 or 4, cells of this side,
            with one memory for the first two.

    Raises:
        ConfigError: a value outside its range.
    """

    region: tuple[int, int, int, int] | None = None
    polarity: Literal["on", "off"] | None = None
    hot_pixels: tuple[tuple[int, int], ...] = ()
    refractory_us: int = setting(0, 0, 10**9, "silence of a pixel after an event; 0 is off")
    activity_us: int = setting(0, 0, 10**9, "oldest neighbour that supports an event; 0 is off")
    activity_support: int = setting(1, 1, 8, "neighbours that an event needs")
    activity_noise_hz: float = setting(
        0.0, 0.0, 1e6, "noise that may pass, per pixel and second; neighbours follow it; 0 is off"
    )
    recent_us: int = setting(0, 0, 10**9, "age past which an event leaves the FIFO; 0 is off")
    recent_radius: int = setting(4, 1, 15, "how near an event in the FIFO must be, pixels")
    recent_support: int = setting(1, 1, 256, "events in the FIFO that an event needs")
    recent_depth: int = setting(32, 1, 256, "events in the FIFO")
    decay_tau_us: float = setting(0.0, 0.0, 1e9, "time constant of a weight's decay; 0 is off")
    decay_epsilon: float = setting(0.1, 0.0, 1.0, "weight up to which an event is discarded")
    decay_support: float = setting(1.0, 1 / 256, 8.0, "sum of weights needed")
    rowcol_us: int = setting(0, 0, 10**9, "oldest event of a row or column that supports an event; 0 is off")
    rowcol_radius: int = setting(1, 1, 15, "how near it must be along the row or column, pixels")
    rowcol_support: int = setting(1, 1, 6, "rows and columns whose last events an event needs")
    cell_px: int = setting(0, 0, 4, "side of a cell in pixels: 1, 2 or 4; 0: a time stamp per pixel and filter")

    def __post_init__(self) -> None:
        if self.region is not None:
            object.__setattr__(self, "region", _addresses(self.region, 4, "filters.region =", "x0, y0, x1, y1"))
            x0, y0, x1, y1 = self.region
            if x0 > x1 or y0 > y1:
                raise ConfigError(f"filters.region = {list(self.region)}: must have x0 <= x1 and y0 <= y1")
        if self.polarity not in (None, "on", "off"):
            raise ConfigError(f"filters.polarity = {self.polarity!r}: must be 'on' or 'off'")
        if not isinstance(self.hot_pixels, Sequence) or isinstance(self.hot_pixels, str):
            raise ConfigError(f"filters.hot_pixels = {self.hot_pixels!r}: must be a list of pixels")
        pixels = tuple(_addresses(pixel, 2, "filters.hot_pixels holds", "x, y") for pixel in self.hot_pixels)
        object.__setattr__(self, "hot_pixels", tuple(dict.fromkeys(pixels)))
        check_ranges("filters", self)
        if self.cell_px not in CELL_PX:
            raise ConfigError(f"filters.cell_px = {self.cell_px}: must be 0, 1, 2 or 4")
        if self.activity_noise_hz and not self.activity_us:
            raise ConfigError(f"filters.activity_noise_hz = {self.activity_noise_hz:g}: must be 0 without activity_us")
        if self.activity_noise_hz and not self.cell_px:
            rule = "must be 0 without memories of cells; set cell_px to 1, 2 or 4"
            raise ConfigError(f"filters.activity_noise_hz = {self.activity_noise_hz:g}: {rule}")
        if self.recent_support > self.recent_depth:
            raise ConfigError(
                f"filters.recent_support = {self.recent_support}: must be at most recent_depth = {self.recent_depth}"
            )

    def changed(self, given: Mapping[str, Any]) -> FilterConfig:
        """These filters with other values for some fields: an activity filter that is off, has its neighbours from there, or
        has no memories of cells, follows no noise unless they say so."""
        holds = given.get("activity_us") == 0 or "activity_support" in given or given.get("cell_px") == 0
        return replace(self, **({"activity_noise_hz": 0.0} if holds else {}) | dict(given))

    @property
    def filters(self) -> tuple[Filter, ...]:
        """The enabled filters, in the order of a chain."""
        on = {
            Filter.REGION: self.region,
            Filter.POLARITY: self.polarity,
            Filter.MASK: self.hot_pixels,
            Filter.REFRACTORY: self.refractory_us,
            Filter.ACTIVITY: self.activity_us,
            Filter.RECENT: self.recent_us,
            Filter.DECAY: self.decay_tau_us,
            Filter.ROWCOL: self.rowcol_us,
        }
        return tuple(which for which in Filter if on[which])

    @property
    def enabled(self) -> bool:
        """Whether any filter is enabled."""
        return bool(self.filters)

    def shape(self, width: int, height: int) -> FilterShape:
        """The shape of the filter chain in hardware for a sensor of this size."""
        return FilterShape(width, height, recent_depth=self.recent_depth, cell_px=self.cell_px)

    def registers(self, tick_us: int) -> FilterRegisters:
        """Convert to the hardware's integers: times to the nearest tick and weights to the nearest 1/256, halves up.

        The decay rate is rounded, too: the half-life in ticks is then 2^29 / decay_rate.

        Raises:
            ConfigError: a time below one tick, or beyond the range of the time stamps.
        """
        x0, y0, x1, y1 = self.region or (0, 0, 65535, 65535)
        refractory, activity = self._ticks("refractory", tick_us), self._ticks("activity", tick_us)
        return FilterRegisters(
            enable=sum(1 << which for which in self.filters),
            region_x0=x0,
            region_x1=x1,
            region_y0=y0,
            region_y1=y1,
            polarity=int(self.polarity != "off"),
            refractory_ticks=refractory or 1,
            activity_ticks=activity,
            activity_support=0 if self.activity_noise_hz else self.activity_support,
            recent_ticks=self._ticks("recent", tick_us),
            recent_radius=self.recent_radius,
            recent_support=self.recent_support,
            decay_rate=self._decay_rate(tick_us),
            decay_epsilon=min(255, math.floor(256 * self.decay_epsilon + 0.5)),
            decay_support=max(1, math.floor(256 * self.decay_support + 0.5)),
            rowcol_ticks=self._ticks("rowcol", tick_us),
            rowcol_radius=self.rowcol_radius,
            rowcol_support=self.rowcol_support,
            stamp_shift=self._stamp_shift(refractory, activity, tick_us),
            **self._noise_registers(tick_us),
            hot_pixels=self.hot_pixels,
        )

    def _ticks(self, name: str, tick_us: int) -> int:
        """A filter's time in ticks; 0 if it is off."""
        us: int = getattr(self, f"{name}_us")
        high = FILTER_REGISTERS[f"{name}_ticks"].limits(FilterShape())[1]
        if us and not tick_us <= us <= high * tick_us:
            raise ConfigError(
                f"filters.{name}_us = {us}: must be from {tick_us} to {high * tick_us}, 1 to {high} ticks of {tick_us} us"
            )
        return (2 * us + tick_us) // (2 * tick_us) if us else 0

    def _stamp_shift(self, refractory: int, activity: int, tick_us: int) -> int:
        """The finest unit with which the stamps of cells reach both times; 0 without cells."""
        if not self.cell_px:
            return 0
        most = FilterShape(cell_px=self.cell_px).units_max
        shift = 0
        while refractory >> shift > most or activity >> shift >= most:
            shift += 1
        if refractory and not refractory >> shift:
            unit = (1 << shift) * tick_us
            stamps = f"one unit of stamps of {CELL_STAMP_W[self.cell_px]} bits that reach activity_us = {self.activity_us}"
            raise ConfigError(
                f"filters.refractory_us = {self.refractory_us}: must be at least {unit}, {stamps}; or a smaller cell_px"
            )
        return shift

    def _noise_registers(self, tick_us: int) -> dict[str, int]:
        """The longest window, of about 16 ms, and the thresholds of the support; reset values if it holds."""
        if not self.activity_noise_hz:
            return {}
        noise_log2 = max((_NOISE_WINDOW_US // tick_us).bit_length() - 1, 0)
        least = thresholds(self.activity_us, self.activity_noise_hz, (1 << noise_log2) * tick_us)
        return {"noise_log2": noise_log2, **{f"noise_{n}": one for n, one in zip(NOISE_SUPPORTS, least, strict=True)}}

    def _decay_rate(self, tick_us: int) -> int:
        """Units of the decay clock per tick, in 2^-24; 1 if the filter is off."""
        if not self.decay_tau_us:
            return 1
        one_tick_us = tick_us * UNITS_PER_HALF_LIFE / math.log(2) * (1 << CLOCK_FRAC)  # tau at a rate of 1
        low, high = FILTER_REGISTERS["decay_rate"].limits(FilterShape())
        if not low <= one_tick_us / self.decay_tau_us <= high:
            rule = f"must be from {one_tick_us / high:.4g} to {one_tick_us / low:.4g} at ticks of {tick_us} us"
            raise ConfigError(f"filters.decay_tau_us = {self.decay_tau_us:g}: {rule}")
        return math.floor(one_tick_us / self.decay_tau_us + 0.5)


FILTER_RANGES: dict[str, Range] = ranges_of(FilterConfig)


def _addresses(value: object, count: int, where: str, names: str) -> tuple[int, ...]:
    """Convert a list of `count` addresses, as from TOML or JSON, to a tuple."""
    if isinstance(value, list | tuple) and len(value) == count and all(type(v) is int and 0 <= v <= 65535 for v in value):
        return tuple(value)
    raise ConfigError(f"{where} {value!r}: must be [{names}], each from 0 to 65535")


DEFAULT_FILTERS = FilterConfig(refractory_us=1_000, activity_us=40_000, activity_noise_hz=0.03, cell_px=1)
"""The filters of the default configuration; `evcot_top` has their registers after reset."""


def thresholds(within_us: float, passing_hz: float, window_us: float) -> list[int]:
    """The least levels of noise at which an event needs 2, 3, ... 6 neighbours, so that at most `passing_hz` a pixel passes.

    Events of noise in the 8 neighbours within the time have a Poisson distribution. A level counts events per cell of 8 x 8
    pixels and longest window, in 1/256.

    Args:
        within_us: time of the activity filter.
        passing_hz: events of noise that may pass, per pixel and second.
        window_us: length of the longest window.
    """
    rates_hz = np.geomspace(1e-4, 1e4, 80_001)  # per pixel, in steps of 0.02 %
    mean = 8e-6 * rates_hz * within_us
    at_least, exactly = np.ones_like(mean), np.exp(-mean)
    found = []
    for neighbours in NOISE_SUPPORTS:
        at_least = at_least - exactly  # the probability of as many events, one fewer than `neighbours`
        exactly = exactly * mean / (neighbours - 1)
        found.append(_least(rates_hz, rates_hz * at_least > passing_hz, window_us))
    return found


def _least(rates_hz: NDArray[np.float64], passes: NDArray[np.bool_], window_us: float) -> int:
    if not passes.any():
        return LEVEL_MAX
    level = rates_hz[np.argmax(passes)] * 1e-6 * window_us * (1 << (2 * CELL_LOG2 + LEVEL_FRAC))
    return int(min(max(round(level), 1), LEVEL_MAX))

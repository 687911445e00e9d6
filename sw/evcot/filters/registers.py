# SPDX-License-Identifier: Apache-2.0
"""The register values of a filter chain, in the hardware's integers."""

from __future__ import annotations

from dataclasses import dataclass

from ..errors import ConfigError
from ..ranges import check_integer
from .contract import CELL_STAMP_W, FILTER_REGISTERS, Filter, FilterShape

__all__ = ["FilterRegisters"]


@dataclass(frozen=True)
class FilterRegisters:
    """The registers of a filter chain; meanings and limits are those of `contract.FILTER_REGISTERS`.

    Attributes:
        hot_pixels: (x, y) of every pixel marked as hot by writes to the register `mask`.
    """

    enable: int = 0
    region_x0: int = 0
    region_x1: int = 65535
    region_y0: int = 0
    region_y1: int = 65535
    polarity: int = 1
    refractory_ticks: int = 1
    activity_ticks: int = 0
    activity_support: int = 1
    recent_ticks: int = 0
    recent_radius: int = 1
    recent_support: int = 1
    decay_rate: int = 1
    decay_epsilon: int = 0
    decay_support: int = 1
    rowcol_ticks: int = 0
    rowcol_radius: int = 1
    rowcol_support: int = 1
    stamp_shift: int = 0
    noise_log2: int = 14
    noise_2: int = 65535
    noise_3: int = 65535
    noise_4: int = 65535
    noise_5: int = 65535
    noise_6: int = 65535
    hot_pixels: tuple[tuple[int, int], ...] = ()

    def enables(self, which: Filter) -> bool:
        """Whether the filter's bit in `enable` is set."""
        return bool(self.enable >> which & 1)

    def check(self, shape: FilterShape) -> None:
        """Raise ConfigError for the first register outside its limits, or hot pixel outside the sensor.

        With cells, the times of refractory and activity, where enabled, must also be representable in units of the stamps.
        """
        for name, register in FILTER_REGISTERS.items():
            if name == "mask":
                continue
            check_integer(f"filters.{name}", getattr(self, name), *register.limits(shape), register.meaning)
        if shape.cell_px:
            self._check_units(shape)
        elif self.enables(Filter.ACTIVITY) and not self.activity_support:
            raise ConfigError("filters.activity_support = 0: must be 1 to 8 with cell_px = 0")
        for x, y in self.hot_pixels:
            if not (0 <= x < shape.width and 0 <= y < shape.height):
                raise ConfigError(f"filters.hot_pixels holds ({x}, {y}): must lie on the {shape.width}x{shape.height} sensor")

    def _check_units(self, shape: FilterShape) -> None:
        unit, most = 1 << self.stamp_shift, shape.units_max
        times = {"refractory_ticks": (Filter.REFRACTORY, 1, most), "activity_ticks": (Filter.ACTIVITY, 0, most - 1)}
        for name, (which, low, high) in times.items():
            ticks = getattr(self, name)
            if self.enables(which) and not low <= ticks >> self.stamp_shift <= high:
                stamps = f"stamps of {CELL_STAMP_W[shape.cell_px]} bits in units of {unit} ticks"
                raise ConfigError(
                    f"filters.{name} = {ticks}: must be from {low * unit} to {(high + 1) * unit - 1}, with {stamps}"
                )

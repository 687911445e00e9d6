# SPDX-License-Identifier: Apache-2.0
"""The contract of filters in RTL, their models and the host: order, shape and registers of a filter chain.

The hardware side is generated from it: see `hardware.generate`.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from enum import IntEnum

from ..errors import ConfigError
from ..ranges import check_integer

__all__ = [
    "CELL_LOG2",
    "CELL_PX",
    "CELL_STAMP_W",
    "CLOCK_FRAC",
    "FILTER_REGISTERS",
    "FILTER_SHAPE_RANGES",
    "LEVEL_FRAC",
    "LEVEL_MAX",
    "NOISE_SHORTER",
    "NOISE_SUPPORTS",
    "UNITS_PER_HALF_LIFE",
    "Filter",
    "FilterRegister",
    "FilterShape",
    "mask_word",
]


class Filter(IntEnum):
    """The filters in the order of a chain; values are bit numbers in the register `enable`."""

    REGION = 0
    POLARITY = 1
    MASK = 2
    REFRACTORY = 3
    ACTIVITY = 4
    RECENT = 5
    DECAY = 6
    ROWCOL = 7


CELL_STAMP_W: dict[int, int] = {1: 9, 2: 7, 4: 5}
"""Side of a cell in pixels -> bits of its time stamp: with the place of the event within the cell, 9 bits."""

CELL_PX = (0, *CELL_STAMP_W)
"""Legal values of `FilterShape.cell_px`."""

CELL_LOG2 = 3
"""log2 of the side of a cell in which noise is counted, in pixels."""

LEVEL_FRAC = 8
LEVEL_MAX = 65_535
"""A level of noise has this many fractional bits, and saturates."""

NOISE_SHORTER = 6
"""The shortest window in which noise is counted is 2^-6 of the longest."""

NOISE_SUPPORTS = range(2, 7)
"""Numbers of neighbours with a threshold of their own; below the first an event needs one."""

# The clock of the decay filter counts units; it has fractional bits.
UNITS_PER_HALF_LIFE = 32
CLOCK_FRAC = 24

# Shape of a filter chain: field -> (lowest, highest, meaning). The RTL checks the same ranges at elaboration.
FILTER_SHAPE_RANGES: dict[str, tuple[int, int, str]] = {
    "width": (1, 65536, "pixels of the sensor across"),
    "height": (1, 65536, "pixels of the sensor down"),
    "stamp_w": (4, 32, "bits of a time stamp in a filter's memory"),
    "recent_depth": (1, 256, "events in the FIFO of recent events"),
    "cell_px": (0, 4, "side of a cell in pixels: 1, 2 or 4; 0: a time stamp per pixel and filter"),
    "cell_stamp_w": (0, 32, "bits of a time stamp of refractory and activity in a cell; 0: as many as 9 bits hold"),
}


@dataclass(frozen=True)
class FilterShape:
    """Elaboration parameters of a filter chain in hardware.

    Raises:
        ConfigError: a field lies outside `FILTER_SHAPE_RANGES`, or cell_px is 3.
    """

    width: int = 346
    height: int = 260
    stamp_w: int = 20
    recent_depth: int = 32
    cell_px: int = 0
    cell_stamp_w: int = 0

    def __post_init__(self) -> None:
        for field in fields(self):
            low, high, meaning = FILTER_SHAPE_RANGES[field.name]
            check_integer(f"filter shape.{field.name}", getattr(self, field.name), low, high, meaning)
        if self.cell_px not in CELL_PX:
            raise ConfigError(f"filter shape.cell_px = {self.cell_px}: must be 0, 1, 2 or 4")
        if self.cell_stamp_w and not (self.cell_px and self.cell_stamp_w >= CELL_STAMP_W[self.cell_px]):
            rule = "must be 0, or at least the bits that the contract gives cells of this size"
            raise ConfigError(f"filter shape.cell_stamp_w = {self.cell_stamp_w}: {rule}")

    @property
    def units_max(self) -> int:
        """Units from which on an age in a cell counts as none: 384, 96 or 24; with a time stamp per pixel there is none."""
        return 3 << (CELL_STAMP_W[self.cell_px] - 2)


@dataclass(frozen=True)
class FilterRegister:
    """One software-written register of a filter chain: word address, legal values, and a one-line description.

    A `high` of None is 2^(stamp_w - 1) - 1, the longest age that time stamps can represent.
    """

    address: int
    low: int
    high: int | None
    meaning: str

    def limits(self, shape: FilterShape) -> tuple[int, int]:
        """Smallest and largest legal value for one shape."""
        return self.low, (1 << (shape.stamp_w - 1)) - 1 if self.high is None else self.high


FILTER_REGISTERS: dict[str, FilterRegister] = {
    "enable": FilterRegister(0, 0, (1 << len(Filter)) - 1, "one bit per filter, in their order"),
    "region_x0": FilterRegister(1, 0, 65535, "first column that stays"),
    "region_x1": FilterRegister(2, 0, 65535, "last column that stays"),
    "region_y0": FilterRegister(3, 0, 65535, "first row that stays"),
    "region_y1": FilterRegister(4, 0, 65535, "last row that stays"),
    "polarity": FilterRegister(5, 0, 1, "polarity that stays"),
    "refractory_ticks": FilterRegister(6, 1, None, "ticks for which a pixel is silent after an event that stayed"),
    "activity_ticks": FilterRegister(7, 0, None, "oldest neighbour that supports an event"),
    "activity_support": FilterRegister(8, 0, 8, "neighbours that an event needs; 0: they follow the noise"),
    "recent_ticks": FilterRegister(9, 0, None, "age past which an event leaves the FIFO"),
    "recent_radius": FilterRegister(10, 1, 15, "how near an event in the FIFO must be to support another"),
    "recent_support": FilterRegister(11, 1, 256, "events in the FIFO that an event needs"),
    "decay_rate": FilterRegister(12, 1, (1 << 24), "units of 1/32 half-life per tick, in 2^-24"),
    "decay_epsilon": FilterRegister(13, 0, 255, "weight in 1/256 up to which an event is discarded"),
    "decay_support": FilterRegister(14, 1, 2048, "sum of weights in 1/256 that an event needs"),
    "mask": FilterRegister(15, 0, (1 << 32) - 1, "marks one pixel as hot, or not: see `mask_word`"),
    "rowcol_ticks": FilterRegister(16, 0, None, "oldest event of a row or column that supports another"),
    "rowcol_radius": FilterRegister(17, 1, 15, "how near along its row or column it must be"),
    "rowcol_support": FilterRegister(18, 1, 6, "rows and columns whose last events an event needs"),
    "stamp_shift": FilterRegister(19, 0, 15, "log2 of the ticks in a unit of the time stamps of cells"),
    "noise_log2": FilterRegister(20, 0, 20, "log2 of the ticks in the longest window in which noise is counted"),
    **{
        f"noise_{support}": FilterRegister(
            19 + support, 0, 65535, f"least noise at which an event needs {support} neighbours, per cell and window, in 1/256"
        )
        for support in NOISE_SUPPORTS
    },
}


def mask_word(x: int, y: int, hot: bool = True) -> int:
    """The word to write to the register `mask` for a pixel: hot or not in bit 31, y in bits 30 to 16, x in 15 to 0."""
    return int(hot) << 31 | y << 16 | x

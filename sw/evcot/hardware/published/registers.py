# SPDX-License-Identifier: Apache-2.0
"""The published tracker's register map, from registers.toml: for the model, and for `published_regs.vh`."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from importlib.resources import files

__all__ = ["REGISTERS", "SELECT", "SELECT_FIRST", "SELECT_NONE", "TRACKERS", "PublishedRegister"]

TRACKERS = 4
"""Trackers of the published cascade."""


@dataclass(frozen=True)
class PublishedRegister:
    """One register: address of its low byte, width, value after reset (or one for each tracker), legal values."""

    address: int
    bits: int
    reset: int | list[int]
    meaning: str
    low: int = 0
    high: int = -1

    def __post_init__(self) -> None:
        if self.high < 0:
            object.__setattr__(self, "high", (1 << self.bits) - 1)

    @property
    def resets(self) -> tuple[int, ...]:
        """Value after reset of each tracker."""
        return tuple(self.reset) if isinstance(self.reset, list) else (self.reset,) * TRACKERS

    @property
    def n_bytes(self) -> int:
        """Number of byte addresses, low byte first."""
        return -(-self.bits // 8)


_DATA = tomllib.loads(files("evcot.hardware.published").joinpath("registers.toml").read_text(encoding="utf-8"))

REGISTERS = {name: PublishedRegister(**entry) for name, entry in _DATA["register"].items()}
SELECT: int = _DATA["select"]  # the tracker selected here is held in reset and receives register writes
SELECT_FIRST: int = _DATA["select_first"]  # selects tracker 0
SELECT_NONE: int = _DATA["select_none"]

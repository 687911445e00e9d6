# SPDX-License-Identifier: Apache-2.0
"""The configuration of the hardware tracker: frozen and validated on construction."""

from __future__ import annotations

from dataclasses import dataclass, field

from ..errors import ConfigError
from ..filters.contract import FilterShape
from ..filters.registers import FilterRegisters
from ..ranges import check_integer
from .contract import ORDERED, REGISTERS, Mode, Shape
from .motion.contract import MotionRegisters

__all__ = ["CotConfig", "SlotConfig"]


@dataclass(frozen=True)
class SlotConfig:
    """The registers of one tracker slot; meanings and limits are those of `contract.REGISTERS`."""

    mode: int = Mode.SEEDED
    init_cm_x: int = 0
    init_cm_y: int = 0
    init_radix: int = 8
    radix_th: int = 4
    radix_step: int = 1
    radix_min: int = 4
    radix_max: int = 16
    hist_avg: int = 3
    max_ticks: int = 50_000
    clust_nev: int = 16
    nev_min: int = 8
    nev_max: int = 32
    nev_th: int = 5_000
    detect_ticks: int = 20_000

    def check(self, shape: Shape, where: str) -> None:
        """Raise ConfigError for the first register outside its limits; `where` prefixes the field's name."""
        for name, register in REGISTERS.items():
            check_integer(f"{where}.{name}", getattr(self, name), *register.limits(shape), register.meaning)
        for low_name, name, high_name in ORDERED:
            low, value, high = getattr(self, low_name), getattr(self, name), getattr(self, high_name)
            if not low <= value <= high:
                raise ConfigError(f"{where}.{name} = {value}: must lie from {low_name} = {low} to {high_name} = {high}")


@dataclass(frozen=True)
class CotConfig:
    """Configuration of the hardware tracker: shape, one register set per slot, the length of a tick, and the filters in front.

    Attributes:
        filters, filter_shape: registers and shape of the filter chain; with no filter enabled there is no chain.
        motion: registers of the extended contract, docs/motion.md; off by default. While it is on, of a slot's registers only
            `mode` has a meaning.

    Raises:
        ConfigError: a value outside its limits, a number of slots that is not the shape's, or a fixed start with motion.
    """

    shape: Shape = field(default_factory=Shape)
    slots: tuple[SlotConfig, ...] = ()
    tick_us: int = 1
    filters: FilterRegisters = field(default_factory=FilterRegisters)
    filter_shape: FilterShape = field(default_factory=FilterShape)
    motion: MotionRegisters = field(default_factory=MotionRegisters)

    def __post_init__(self) -> None:
        if not self.slots:
            object.__setattr__(self, "slots", (SlotConfig(),) * self.shape.n_slots)
        if len(self.slots) != self.shape.n_slots:
            raise ConfigError(f"cot.slots has {len(self.slots)} entries: must be shape.n_slots = {self.shape.n_slots}")
        check_integer("cot.tick_us", self.tick_us, 1, 1_000_000)
        for i, slot in enumerate(self.slots):
            slot.check(self.shape, f"cot.slot[{i}]")
            if self.motion.enable and slot.mode == Mode.FIXED:
                raise ConfigError(f"cot.slot[{i}].mode = {int(slot.mode)}: must be 0 or 2 with motion.enable = 1")
        if self.filtered:
            self.filters.check(self.filter_shape)

    @property
    def filtered(self) -> bool:
        """Whether there is a filter chain in front of the tracker."""
        return bool(self.filters.enable)

    @classmethod
    def check(cls, config: object) -> None:
        """Raise ConfigError if something is given as the configuration of hardware that is none."""
        if not isinstance(config, cls):
            rule = "must be a CotConfig, as run_config(width, height).hardware(width, height) returns it"
            raise ConfigError(f"config is of type {type(config).__name__}: {rule}")

    @classmethod
    def uniform(cls, shape: Shape, slot: SlotConfig, tick_us: int = 1) -> CotConfig:
        """A configuration with the same registers in every slot."""
        return cls(shape, (slot,) * shape.n_slots, tick_us)

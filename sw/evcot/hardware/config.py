# SPDX-License-Identifier: Apache-2.0
"""The configurations of the hardware trackers, one class per contract: frozen and validated on construction."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from ..errors import ConfigError, meant
from ..filters.contract import FilterShape
from ..filters.registers import FilterRegisters
from ..ranges import check_integer
from .contract import ORDERED, REGISTERS, Mode, Shape
from .modules import MODULES, Module
from .motion.contract import MotionRegisters

__all__ = ["CotConfig", "HardwareConfig", "MotionConfig", "SlotConfig", "with_module"]


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


class HardwareConfig:
    """What the configurations of all hardware trackers have.

    Attributes:
        module: name of the Verilog module.
        shape: elaboration parameters.
        tick_us: length of a tick, in microseconds.
        filters, filter_shape: registers and shape of the filter chain; with no filter enabled there is no chain.
    """

    module: Module
    shape: Shape
    tick_us: int
    filters: FilterRegisters
    filter_shape: FilterShape

    def _check(self) -> None:
        check_integer("tick_us", self.tick_us, 1, 1_000_000)
        if self.filtered:
            if self.module == "cot":
                raise ConfigError("a single `cot` has no filters in front: use cot_array with one slot")
            self.filters.check(self.filter_shape)

    @property
    def filtered(self) -> bool:
        """Whether there is a filter chain in front of the tracker."""
        return bool(self.filters.enable)

    @staticmethod
    def check_type(config: object) -> None:
        """Raise ConfigError if something is given as the configuration of hardware that is none."""
        if not isinstance(config, HardwareConfig):
            rule = "must be a MotionConfig or a CotConfig, as run_config(width, height).device_config() returns it"
            raise ConfigError(f"config is of type {type(config).__name__}: {rule}")


@dataclass(frozen=True)
class CotConfig(HardwareConfig):
    """Configuration of `cot`, `cot_chain` and `cot_array` (docs/algorithm.md): one register set per slot.

    Raises:
        ConfigError: a value outside its limits, a number of slots that is not the shape's, or one that the module cannot have.
    """

    shape: Shape = field(default_factory=Shape)
    slots: tuple[SlotConfig, ...] = ()
    tick_us: int = 1
    filters: FilterRegisters = field(default_factory=FilterRegisters)
    filter_shape: FilterShape = field(default_factory=FilterShape)
    module: Module = "cot_array"

    def __post_init__(self) -> None:
        if self.module not in MODULES or self.module == "cot_motion":
            raise ConfigError(f"module = {self.module!r}: must be one of cot, cot_chain, cot_array for a CotConfig")
        if not self.slots:
            object.__setattr__(self, "slots", (SlotConfig(),) * self.shape.n_slots)
        if self.module == "cot" and self.shape.n_slots != 1:
            raise ConfigError(f"shape.n_slots = {self.shape.n_slots}: must be 1 for a single tracker")
        if len(self.slots) != self.shape.n_slots:
            raise ConfigError(f"cot.slots has {len(self.slots)} entries: must be shape.n_slots = {self.shape.n_slots}")
        for i, slot in enumerate(self.slots):
            slot.check(self.shape, f"cot.slot[{i}]")
        self._check()

    @classmethod
    def uniform(cls, shape: Shape, slot: SlotConfig, tick_us: int = 1, module: Module = "cot_array") -> CotConfig:
        """A configuration with the same registers in every slot."""
        return cls(shape, (slot,) * shape.n_slots, tick_us, module=module)


@dataclass(frozen=True)
class MotionConfig(HardwareConfig):
    """Configuration of `cot_motion` (docs/motion.md): one register set for all slots.

    Attributes:
        modes: start mode of each slot, `Mode.SEEDED` or `Mode.OFF`; empty: all seeded.

    Raises:
        ConfigError: a value outside its limits, or a number of modes that is not the shape's number of slots.
    """

    shape: Shape = field(default_factory=lambda: Shape(n_slots=16))
    registers: MotionRegisters = field(default_factory=MotionRegisters)
    tick_us: int = 1
    filters: FilterRegisters = field(default_factory=FilterRegisters)
    filter_shape: FilterShape = field(default_factory=FilterShape)
    modes: tuple[int, ...] = ()
    module: Module = field(default="cot_motion", init=False)

    def __post_init__(self) -> None:
        shape = self.shape
        if not self.modes:
            object.__setattr__(self, "modes", (int(Mode.SEEDED),) * shape.n_slots)
        if len(self.modes) != shape.n_slots:
            raise ConfigError(f"motion.modes has {len(self.modes)} entries: must be shape.n_slots = {shape.n_slots}")
        for i, mode in enumerate(self.modes):
            if mode not in (Mode.OFF, Mode.SEEDED):
                raise ConfigError(f"motion.modes[{i}] = {mode}: must be 0 (off) or 2 (seeded)")
        if shape.time_w < 32:
            raise ConfigError(f"shape.time_w = {shape.time_w}: must be from 32 to 48 for cot_motion")
        if shape.time_w == shape.tick_w:
            raise ConfigError(f"shape.time_w = {shape.time_w}: must be more than tick_w = {shape.tick_w} for cot_motion")
        self._check()


def with_module(config: CotConfig | MotionConfig, module: str) -> CotConfig | MotionConfig:
    """The same configuration for another module with the same contract; a single `cot` keeps the first slot.

    Raises:
        ConfigError: no such module, or one with the other contract.
    """
    if module not in MODULES:
        raise ConfigError(f"hardware = {module!r}: must be one of {', '.join(MODULES)}{meant(module, MODULES)}")
    if module == config.module:
        return config
    if isinstance(config, MotionConfig) or module == "cot_motion":
        rule = "these registers are those of cot, cot_chain and cot_array"
        if isinstance(config, MotionConfig):
            rule = "these registers are those of cot_motion"
        raise ConfigError(f"hardware = {module!r}: {rule}")
    if module == "cot":
        return replace(config, module="cot", shape=replace(config.shape, n_slots=1), slots=config.slots[:1])
    return replace(config, module=module)  # one of MODULES

# SPDX-License-Identifier: Apache-2.0
"""Configurations: frozen, validated on construction, loadable from TOML; limits come from `contract`."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields, replace
from pathlib import Path
from typing import Any, Literal

from .contract import FILTER_REGISTERS, REGISTERS, Filter, FilterShape, Mode, Shape
from .errors import ConfigError
from .filters.decay import CLOCK_FRAC, UNITS_PER_HALF_LIFE
from .filters.hot_pixels import load_hot_pixels
from .filters.registers import FilterRegisters

__all__ = ["CotConfig", "FilterConfig", "RctConfig", "RunConfig", "SlotConfig", "load_toml"]

Ranges = Mapping[str, tuple[float, float, str]]


def _check_ranges(config: object, ranges: Ranges, where: str) -> None:
    """Raise ConfigError for the first field outside its (lowest, highest, meaning); an integer limit asks for an integer."""
    for name, (low, high, meaning) in ranges.items():
        value = getattr(config, name)
        wanted = type(low) if isinstance(low, int) else (int, float)
        if isinstance(value, bool) or not isinstance(value, wanted) or not low <= value <= high:
            raise ConfigError(f"{where}.{name} = {value!r}: must be from {low:g} to {high:g} ({meaning})")


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
            low, high = register.limits(shape)
            value = getattr(self, name)
            if not isinstance(value, int) or not low <= value <= high:
                raise ConfigError(f"{where}.{name} = {value!r}: must be an integer from {low} to {high} ({register.meaning})")
        for low_name, name, high_name in (("radix_min", "init_radix", "radix_max"), ("nev_min", "clust_nev", "nev_max")):
            low, value, high = getattr(self, low_name), getattr(self, name), getattr(self, high_name)
            if not low <= value <= high:
                raise ConfigError(f"{where}.{name} = {value}: must lie from {low_name} = {low} to {high_name} = {high}")


@dataclass(frozen=True)
class CotConfig:
    """The hardware tracker: shape, one register set per slot, the length of a tick, and the filters in front.

    Attributes:
        filters, filter_shape: of the filter chain; with nothing enabled there is none.

    Raises:
        ConfigError: a value outside its limits, or another number of slots than the shape has.
    """

    shape: Shape = field(default_factory=Shape)
    slots: tuple[SlotConfig, ...] = ()
    tick_us: int = 1
    filters: FilterRegisters = field(default_factory=FilterRegisters)
    filter_shape: FilterShape = field(default_factory=FilterShape)

    def __post_init__(self) -> None:
        if not self.slots:
            object.__setattr__(self, "slots", (SlotConfig(),) * self.shape.n_slots)
        if len(self.slots) != self.shape.n_slots:
            raise ConfigError(f"cot.slots has {len(self.slots)} entries: must be shape.n_slots = {self.shape.n_slots}")
        if not isinstance(self.tick_us, int) or not 1 <= self.tick_us <= 1_000_000:
            raise ConfigError(f"cot.tick_us = {self.tick_us!r}: must be an integer from 1 to 1000000")
        for i, slot in enumerate(self.slots):
            slot.check(self.shape, f"cot.slot[{i}]")
        if self.filtered:
            self.filters.check(self.filter_shape)

    @property
    def filtered(self) -> bool:
        """Whether there is a filter chain in front."""
        return bool(self.filters.enable)

    @classmethod
    def uniform(cls, shape: Shape, slot: SlotConfig, tick_us: int = 1) -> CotConfig:
        """The same registers in every slot."""
        return cls(shape, (slot,) * shape.n_slots, tick_us)


# field -> (lowest, highest, meaning)
RCT_RANGES: Ranges = {
    "max_clusters": (1, 1024, "clusters alive at once"),
    "radius_px": (0.5, 1000.0, "half the side of a cluster's square window"),
    "alpha": (1e-6, 1.0, "mixing factor of location"),
    "velocity_alpha": (1e-6, 1.0, "mixing factor of velocity"),
    "visible_events": (1, 1_000_000, "events after which a cluster becomes visible"),
    "lifetime_us": (1, 10**12, "silence after which a cluster is removed"),
    "packet_us": (1, 10**9, "length of a packet"),
}


@dataclass(frozen=True)
class RctConfig:
    """The software Rectangular Cluster Tracker; limits in `RCT_RANGES`.

    Raises:
        ConfigError: a value outside its range.
    """

    max_clusters: int = 32
    radius_px: float = 12.0
    alpha: float = 0.01
    velocity_alpha: float = 0.05
    visible_events: int = 5
    lifetime_us: int = 50_000
    packet_us: int = 1_000

    def __post_init__(self) -> None:
        _check_ranges(self, RCT_RANGES, "rct")


# field -> (lowest, highest, meaning)
FILTER_RANGES: Ranges = {
    "refractory_us": (0, 10**9, "silence of a pixel after an event; 0 is off"),
    "activity_us": (0, 10**9, "oldest neighbour that supports an event; 0 is off"),
    "activity_support": (1, 8, "neighbours that an event needs"),
    "recent_us": (0, 10**9, "age past which an event leaves the FIFO; 0 is off"),
    "recent_radius": (1, 15, "how near an event in the FIFO must be, pixels"),
    "recent_support": (1, 256, "events in the FIFO that an event needs"),
    "recent_depth": (1, 256, "events in the FIFO"),
    "decay_tau_us": (0.0, 1e9, "time constant of a weight's decay; 0 is off"),
    "decay_epsilon": (0.0, 1.0, "weight up to which an event is discarded"),
    "decay_support": (1 / 256, 8.0, "sum of weights that an event needs"),
}


@dataclass(frozen=True)
class FilterConfig:
    """The filters in front of both trackers, all off by default; limits in `FILTER_RANGES`, meanings in docs/filters.md.

    Attributes:
        region: (x0, y0, x1, y1), first and last column and row that stay, in pixels; None is off.
        polarity: the one that stays; None is off.
        hot_pixels: (x, y) of the pixels that are silenced.

    Raises:
        ConfigError: a value outside its range.
    """

    region: tuple[int, int, int, int] | None = None
    polarity: Literal["on", "off"] | None = None
    hot_pixels: tuple[tuple[int, int], ...] = ()
    refractory_us: int = 0
    activity_us: int = 0
    activity_support: int = 1
    recent_us: int = 0
    recent_radius: int = 4
    recent_support: int = 1
    recent_depth: int = 32
    decay_tau_us: float = 0.0
    decay_epsilon: float = 0.1
    decay_support: float = 1.0

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
        _check_ranges(self, FILTER_RANGES, "filters")
        if self.recent_support > self.recent_depth:
            raise ConfigError(
                f"filters.recent_support = {self.recent_support}: must be at most recent_depth = {self.recent_depth}"
            )

    @property
    def filters(self) -> tuple[Filter, ...]:
        """The filters that are on, in the order of a chain."""
        on = {
            Filter.REGION: self.region,
            Filter.POLARITY: self.polarity,
            Filter.MASK: self.hot_pixels,
            Filter.REFRACTORY: self.refractory_us,
            Filter.ACTIVITY: self.activity_us,
            Filter.RECENT: self.recent_us,
            Filter.DECAY: self.decay_tau_us,
        }
        return tuple(which for which in Filter if on[which])

    @property
    def enabled(self) -> bool:
        """Whether any filter is on."""
        return bool(self.filters)

    def shape(self, width: int, height: int) -> FilterShape:
        """The hardware for a sensor of this size."""
        return FilterShape(width, height, recent_depth=self.recent_depth)

    def registers(self, tick_us: int) -> FilterRegisters:
        """The same in the hardware's integers: times to the nearest tick and weights to the nearest 1/256, halves up.

        The decay's rate is rounded too: its half-life in ticks then is 2^29 / decay_rate.

        Raises:
            ConfigError: a time below one tick, or longer than stamps can tell.
        """
        x0, y0, x1, y1 = self.region or (0, 0, 65535, 65535)
        return FilterRegisters(
            enable=sum(1 << which for which in self.filters),
            region_x0=x0,
            region_x1=x1,
            region_y0=y0,
            region_y1=y1,
            polarity=int(self.polarity != "off"),
            refractory_ticks=self._ticks("refractory", tick_us) or 1,
            activity_ticks=self._ticks("activity", tick_us),
            activity_support=self.activity_support,
            recent_ticks=self._ticks("recent", tick_us),
            recent_radius=self.recent_radius,
            recent_support=self.recent_support,
            decay_rate=self._decay_rate(tick_us),
            decay_epsilon=min(255, math.floor(256 * self.decay_epsilon + 0.5)),
            decay_support=max(1, math.floor(256 * self.decay_support + 0.5)),
            hot_pixels=self.hot_pixels,
        )

    def _ticks(self, name: str, tick_us: int) -> int:
        """A filter's time in ticks; 0 where it is off."""
        us: int = getattr(self, f"{name}_us")
        high = FILTER_REGISTERS[f"{name}_ticks"].limits(FilterShape())[1]
        if us and not tick_us <= us <= high * tick_us:
            raise ConfigError(
                f"filters.{name}_us = {us}: must be from {tick_us} to {high * tick_us}, 1 to {high} ticks of {tick_us} us"
            )
        return (2 * us + tick_us) // (2 * tick_us) if us else 0

    def _decay_rate(self, tick_us: int) -> int:
        """Units of the decay's clock per tick, in 2^-24; 1 where the filter is off."""
        if not self.decay_tau_us:
            return 1
        one_tick_us = tick_us * UNITS_PER_HALF_LIFE / math.log(2) * (1 << CLOCK_FRAC)  # tau at a rate of 1
        low, high = FILTER_REGISTERS["decay_rate"].limits(FilterShape())
        if not low <= one_tick_us / self.decay_tau_us <= high:
            rule = f"must be from {one_tick_us / high:.4g} to {one_tick_us / low:.4g} at ticks of {tick_us} us"
            raise ConfigError(f"filters.decay_tau_us = {self.decay_tau_us:g}: {rule}")
        return math.floor(one_tick_us / self.decay_tau_us + 0.5)


def _addresses(value: object, count: int, where: str, names: str) -> tuple[int, ...]:
    """A list of this many addresses, as TOML and JSON have it, as a tuple."""
    if isinstance(value, list | tuple) and len(value) == count and all(type(v) is int and 0 <= v <= 65535 for v in value):
        return tuple(value)
    raise ConfigError(f"{where} {value!r}: must be [{names}], each from 0 to 65535")


@dataclass(frozen=True)
class RunConfig:
    """What one run needs: the filters' and both trackers' configurations under a name."""

    name: str = "default"
    cot: CotConfig = field(default_factory=CotConfig)
    rct: RctConfig = field(default_factory=RctConfig)
    filters: FilterConfig = field(default_factory=FilterConfig)

    def hardware(self, width: int, height: int) -> CotConfig:
        """What the hardware in front of a sensor is configured with: `cot`, behind `filters`.

        Raises:
            ConfigError: a filter's time that ticks cannot count, or a hot pixel outside the sensor.
        """
        if not self.filters.enabled:
            return self.cot
        filters, shape = self.filters.registers(self.cot.tick_us), self.filters.shape(width, height)
        return replace(self.cot, filters=filters, filter_shape=shape)

    def to_dict(self) -> dict[str, Any]:
        """Plain values, as summary.json stores them; the filters once, in users' units."""
        values = asdict(self)
        for name in ("filters", "filter_shape"):
            del values["cot"][name]
        return values


def _section(data: Mapping[str, Any], allowed: set[str], where: str) -> Mapping[str, Any]:
    for key in data:
        if key not in allowed:
            raise ConfigError(f"{where}: unknown field {key!r}: must be one of {', '.join(sorted(allowed))}")
    return data


def _table(data: Mapping[str, Any], key: str, where: str) -> Mapping[str, Any]:
    value = data.get(key, {})
    if not isinstance(value, Mapping):
        raise ConfigError(f"{where}: [{key}] must be a table, not {value!r}")
    return value


def _names(cls: type) -> set[str]:
    return {f.name for f in fields(cls)}


def load_toml(path: Path, base: RunConfig) -> RunConfig:
    """Read a TOML file whose tables `[shape]`, `[cot]`, `[[slot]]`, `[rct]` and `[filters]` override `base`.

    `[cot]` takes `tick_us` and any register, for all slots; the i-th `[[slot]]` then overrides registers of slot i. `[filters]`
    also takes `hot_pixels_file`, a file of `filters.hot_pixels` beside the TOML file, in place of `hot_pixels`.

    Raises:
        ConfigError: the file cannot be read, is not TOML, has an unknown field, or a value outside its limits; the message
            starts with the file's name.
    """
    try:
        data = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read: {error.strerror}") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ConfigError(f"{path}: is not TOML: {error}") from error
    try:
        return _override(base, data, path.parent)
    except ConfigError as error:
        raise ConfigError(f"{path}: {error}") from error


def _override(base: RunConfig, data: Mapping[str, Any], folder: Path) -> RunConfig:
    _section(data, {"name", "shape", "cot", "slot", "rct", "filters"}, "top level")
    shape = replace(base.cot.shape, **_section(_table(data, "shape", "top level"), _names(Shape), "[shape]"))
    cot = dict(_section(_table(data, "cot", "top level"), _names(SlotConfig) | {"tick_us"}, "[cot]"))
    tick_us = cot.pop("tick_us", base.cot.tick_us)
    template = base.cot.slots
    slots = [replace(template[min(i, len(template) - 1)], **cot) for i in range(shape.n_slots)]
    own = data.get("slot", [])
    if not isinstance(own, list) or not all(isinstance(entry, Mapping) for entry in own):
        raise ConfigError("[[slot]] must be a list of tables")
    if len(own) > shape.n_slots:
        raise ConfigError(f"[[slot]] stands {len(own)} times: must be at most shape.n_slots = {shape.n_slots}")
    for i, entry in enumerate(own):
        slots[i] = replace(slots[i], **_section(entry, _names(SlotConfig), f"[[slot]] {i}"))
    rct = replace(base.rct, **_section(_table(data, "rct", "top level"), _names(RctConfig), "[rct]"))
    filters = _filters(base.filters, _table(data, "filters", "top level"), folder)
    return RunConfig(str(data.get("name", base.name)), CotConfig(shape, tuple(slots), tick_us), rct, filters)


def _filters(base: FilterConfig, table: Mapping[str, Any], folder: Path) -> FilterConfig:
    own = dict(_section(table, _names(FilterConfig) | {"hot_pixels_file"}, "[filters]"))
    name = own.pop("hot_pixels_file", None)
    if name is not None:
        if not isinstance(name, str) or "hot_pixels" in own:
            raise ConfigError(f"[filters]: hot_pixels_file = {name!r}: must be a file's name, and stand without hot_pixels")
        own["hot_pixels"] = load_hot_pixels(folder / name)
    return replace(base, **own)

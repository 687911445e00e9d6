# SPDX-License-Identifier: Apache-2.0
"""The configuration of a whole run (hardware, software tracker, filters): frozen, validated, loadable from TOML."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field, fields, replace
from pathlib import Path
from typing import Any, Literal, get_args

from ..errors import ConfigError, meant
from ..filters.config import FilterConfig
from ..hardware.config import CotConfig, SlotConfig
from ..hardware.contract import Shape
from ..hardware.motion.contract import MotionRegisters
from ..outputs import note_input
from ..toml_file import read_toml
from .auto.config import AutoConfig
from .rct.config import RctConfig

__all__ = ["RunConfig", "Software", "load_toml", "load_tracker", "run_config_from", "tracker_from", "without_motion"]

Software = Literal["auto", "rct"]


@dataclass(frozen=True)
class RunConfig:
    """Named configuration of a run: filters and both trackers.

    Attributes:
        software: which software tracker runs beside the hardware; `rct` and `auto` are the settings of each.
        filters: in front of the hardware, and of the software tracker unless `software_filters` has others for it.

    Raises:
        ConfigError: no such software tracker.
    """

    name: str = "default"
    cot: CotConfig = field(default_factory=CotConfig)
    rct: RctConfig = field(default_factory=RctConfig)
    filters: FilterConfig = field(default_factory=FilterConfig)
    software: Software = "rct"
    auto: AutoConfig = field(default_factory=AutoConfig)
    software_filters: FilterConfig | None = None

    def __post_init__(self) -> None:
        if self.software not in get_args(Software):
            raise ConfigError(f"software = {self.software!r}: must be one of {', '.join(get_args(Software))}")

    @property
    def in_front_of_software(self) -> FilterConfig:
        """The filters in front of the software tracker."""
        return self.filters if self.software_filters is None else self.software_filters

    def hardware(self, width: int, height: int) -> CotConfig:
        """The hardware configuration for a sensor: `cot`, behind `filters`.

        Raises:
            ConfigError: a filter time that cannot be represented in ticks, or a hot pixel outside the sensor.
        """
        if not self.filters.enabled:
            return self.cot
        if self.filters.activity_noise_hz:
            rule = "must be 0 in hardware, whose registers hold; choose activity_support"
            raise ConfigError(f"filters.activity_noise_hz = {self.filters.activity_noise_hz:g}: {rule}")
        filters, shape = self.filters.registers(self.cot.tick_us), self.filters.shape(width, height)
        return replace(self.cot, filters=filters, filter_shape=shape)

    def to_dict(self) -> dict[str, Any]:
        """Plain values, as stored in summary.json; the filters only once, in physical units, and one software tracker."""
        values = asdict(self)
        for name in get_args(Software):
            if name != self.software:
                del values[name]
        for name in ("filters", "filter_shape"):
            del values["cot"][name]
        if not self.cot.motion.enable:
            del values["cot"]["motion"]
        return values


def _section(data: Mapping[str, Any], allowed: set[str], where: str) -> Mapping[str, Any]:
    for key in data:
        if key not in allowed:
            rule = f"must be one of {', '.join(sorted(allowed))}"
            raise ConfigError(f"{where}: unknown field {key!r}: {rule}{meant(str(key), allowed)}")
    return data


def _table(data: Mapping[str, Any], key: str, where: str) -> Mapping[str, Any]:
    value = data.get(key, {})
    if not isinstance(value, Mapping):
        raise ConfigError(f"{where}: [{key}] must be a table, not {value!r}")
    return value


def _names(cls: type) -> set[str]:
    return {f.name for f in fields(cls)}


def load_toml(path: Path, base: RunConfig) -> RunConfig:
    """Read a TOML file whose tables `[shape]`, `[cot]`, `[[slot]]`, `[motion]`, `[rct]`, `[auto]` and `[filters]`
    override `base`.

    `software` names the software tracker, and `[software_filters]` holds its filters if they are not those of `[filters]`.

    `[cot]` has `tick_us` and any register, for all slots; the i-th `[[slot]]` then overrides registers of slot i. `[filters]`
    may have `hot_pixels_file`, a file of `filters.hot_pixels` relative to the TOML file, instead of `hot_pixels`. `[run]`,
    which describes the inputs of a run, and `[files]`, which lists its output files, are ignored.

    Raises:
        ConfigError: the file cannot be read, is not TOML, has an unknown field, or a value outside its limits; the message
            starts with the file's name.
    """
    with _named(path):
        return run_config_from(_tables(path), base, path.parent)


def without_motion(path: Path) -> bool:
    """Whether a TOML file for `load_toml` is about the array without motion: has registers of slots, or says so.

    Raises:
        ConfigError: the file cannot be read, or is not TOML.
    """
    with _named(path):
        data = _tables(path)
        registers = set(_table(data, "cot", "top level")) - {"tick_us"}
        enable = _table(data, "motion", "top level").get("enable")
        return not enable and (enable is not None or bool(registers) or "slot" in data)


def load_tracker(path: Path, name: str, settings: Any, filters: FilterConfig) -> tuple[Any, FilterConfig]:
    """Read a TOML file whose table with the tracker's name, and `[filters]`, override the tracker's settings and its filters.

    Raises:
        ConfigError: as for `load_toml`.
    """
    with _named(path):
        return tracker_from(_tables(path), name, settings, filters, path.parent)


def tracker_from(
    tables: Mapping[str, Any], name: str, settings: Any, filters: FilterConfig, folder: Path
) -> tuple[Any, FilterConfig]:
    """As `load_tracker`, of tables that were read already; `folder` is that of their file."""
    data = _section(tables, {name, "filters"}, "top level")
    own = _section(_table(data, name, "top level"), _names(type(settings)), f"[{name}]")
    return replace(settings, **own), _filters(filters, _table(data, "filters", "top level"), folder)


@contextmanager
def _named(path: Path) -> Iterator[None]:
    """Prefix errors with the file's name."""
    try:
        yield
    except ConfigError as error:
        raise ConfigError(f"{path}: {error}") from error


def _tables(path: Path) -> Mapping[str, Any]:
    note_input(path)
    return read_toml(path)


def run_config_from(data: Mapping[str, Any], base: RunConfig, folder: Path) -> RunConfig:
    """As `load_toml`, of tables that were read already; `folder` is that of their file."""
    known = {"name", "software", "run", "made", "files", "shape", "cot", "slot", "motion", "rct", "auto", "filters"}
    known.add("software_filters")
    _section(data, known, "top level")
    shape = replace(base.cot.shape, **_section(_table(data, "shape", "top level"), _names(Shape), "[shape]"))
    cot = dict(_section(_table(data, "cot", "top level"), _names(SlotConfig) | {"tick_us"}, "[cot]"))
    tick_us = cot.pop("tick_us", base.cot.tick_us)
    template = base.cot.slots
    slots = [replace(template[min(i, len(template) - 1)], **cot) for i in range(shape.n_slots)]
    own = data.get("slot", [])
    if not isinstance(own, list) or not all(isinstance(entry, Mapping) for entry in own):
        raise ConfigError("[[slot]] must be a list of tables")
    if len(own) > shape.n_slots:
        raise ConfigError(f"[[slot]] occurs {len(own)} times: must be at most shape.n_slots = {shape.n_slots}")
    for i, entry in enumerate(own):
        slots[i] = replace(slots[i], **_section(entry, _names(SlotConfig), f"[[slot]] {i}"))
    motion = replace(base.cot.motion, **_section(_table(data, "motion", "top level"), _names(MotionRegisters), "[motion]"))
    rct = replace(base.rct, **_section(_table(data, "rct", "top level"), _names(RctConfig), "[rct]"))
    auto = replace(base.auto, **_section(_table(data, "auto", "top level"), _names(AutoConfig), "[auto]"))
    return RunConfig(
        name=str(data.get("name", base.name)),
        cot=CotConfig(shape, tuple(slots), tick_us, motion=motion),
        rct=rct,
        filters=_filters(base.filters, _table(data, "filters", "top level"), folder),
        software=data.get("software", base.software),
        auto=auto,
        software_filters=_software_filters(base, data, folder),
    )


def _software_filters(base: RunConfig, data: Mapping[str, Any], folder: Path) -> FilterConfig | None:
    table = _table(data, "software_filters", "top level")
    if "software_filters" not in data:
        return base.software_filters
    return _filters(base.software_filters or FilterConfig(), table, folder, "software_filters")


def _filters(base: FilterConfig, table: Mapping[str, Any], folder: Path, key: str = "filters") -> FilterConfig:
    own = dict(_section(table, _names(FilterConfig) | {"hot_pixels_file"}, f"[{key}]"))
    name = own.pop("hot_pixels_file", None)
    if name is not None:
        if not isinstance(name, str) or "hot_pixels" in own:
            raise ConfigError(f"[{key}]: hot_pixels_file = {name!r}: must be a file name, given without hot_pixels")
        from ..filters.hot_pixels import load_hot_pixels  # with Numba, which settings alone do not need

        own["hot_pixels"] = load_hot_pixels(folder / name)
    return base.changed(own)

# SPDX-License-Identifier: Apache-2.0
"""The configuration of a whole run (hardware, software tracker, filters): frozen, validated, loadable from TOML."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field, fields, replace
from pathlib import Path
from typing import Any, Literal, get_args

from ..errors import ConfigError, EvcotError, meant
from ..filters.config import FilterConfig
from ..hardware.config import CotConfig, MotionConfig, SlotConfig, with_module
from ..hardware.contract import Shape
from ..hardware.modules import MODULES, Module
from ..hardware.motion.contract import MotionRegisters
from ..outputs import note_input
from ..recordings.formats.source import Sensor
from ..toml_file import read_toml
from .adaptive.config import AdaptiveConfig
from .rct.config import RctConfig

__all__ = [
    "RunConfig",
    "Software",
    "load_toml",
    "load_tracker",
    "module_in",
    "run_config_from",
    "tracker_from",
    "with_settings",
]

Software = Literal["adaptive", "rct"]

# Bits of time stamps in simulated filters; decisions are those of fewer bits. A simulation has clocks only where there are
# events, so the walk that renews old stamps (docs/filters.md) takes clocks that a chip has between events.
_SIMULATED_STAMP_W = 24
_SIMULATED_CELL_STAMP_W = 32  # whole words of the simulator


@dataclass(frozen=True)
class RunConfig:
    """Named configuration of a run: filters and both trackers.

    Attributes:
        hardware: module, shape and registers of the hardware tracker.
        software: which software tracker runs beside the hardware; `rct` and `adaptive` are the settings of each.
        filters: in front of the hardware, and of the software tracker unless `software_filters` has others for it.
        sensor: (width, height) in pixels of the sensor that the addresses fit; None: not known.

    Raises:
        ConfigError: no such software tracker.
    """

    name: str = "default"
    hardware: CotConfig | MotionConfig = field(default_factory=MotionConfig)
    rct: RctConfig = field(default_factory=RctConfig)
    filters: FilterConfig = field(default_factory=FilterConfig)
    software: Software = "rct"
    adaptive: AdaptiveConfig = field(default_factory=AdaptiveConfig)
    software_filters: FilterConfig | None = None
    sensor: Sensor | None = field(default=None, compare=False)

    def __post_init__(self) -> None:
        if self.software not in get_args(Software):
            raise ConfigError(f"software = {self.software!r}: must be one of {', '.join(get_args(Software))}")

    @property
    def in_front_of_software(self) -> FilterConfig:
        """The filters in front of the software tracker."""
        return self.filters if self.software_filters is None else self.software_filters

    def device_config(self, width: int = 0, height: int = 0) -> CotConfig | MotionConfig:
        """The complete configuration of the hardware: `hardware` behind `filters`, whose memories fit the sensor.

        Args:
            width, height: of the sensor; 0: that for which `presets.run_config` made this configuration.

        Raises:
            ConfigError: a filter time that cannot be represented in ticks, or a hot pixel outside the sensor.
        """
        if not self.filters.enabled:
            return self.hardware
        if not width:
            if self.sensor is None:
                raise ConfigError("device_config: width and height must be given: this configuration is for any sensor")
            width, height = self.sensor
        filters, shape = self.filters.registers(self.hardware.tick_us), self.filters.shape(width, height)
        filters.check(shape)
        wide = {"cell_stamp_w": _SIMULATED_CELL_STAMP_W} if shape.cell_px else {"stamp_w": _SIMULATED_STAMP_W}
        shape = replace(shape, **wide)
        return replace(self.hardware, filters=filters, filter_shape=shape)

    def to_dict(self) -> dict[str, Any]:
        """Plain values, as stored in summary.json; the filters only once, in physical units, and one software tracker."""
        values = asdict(self)
        for name in get_args(Software):
            if name != self.software:
                del values[name]
        del values["sensor"]
        for name in ("filters", "filter_shape"):
            del values["hardware"][name]
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
    """Read a TOML file whose fields and tables override `base`.

    `hardware` names the module. `[shape]` has its elaboration parameters. `[motion]` has the registers of cot_motion, `tick_us`
    and `modes`; `[cot]` has `tick_us` and any register of the other modules, for all slots; the i-th `[[slot]]` then overrides
    registers of slot i. `software` names the software tracker, with its settings in `[rct]` or `[adaptive]`. `[filters]` may
    have `hot_pixels_file`, a file of `filters.hot_pixels` relative to the TOML file, instead of `hot_pixels`;
    `[software_filters]` holds the filters of the software tracker if they are not those of `[filters]`. `[run]`, which
    describes the inputs of a run, and `[files]`, which lists its output files, are ignored.

    Raises:
        ConfigError: the file cannot be read, is not TOML, has an unknown field, or a value outside its limits; the message
            starts with the file's name.
    """
    with _named(path):
        return run_config_from(_tables(path), base, path.parent)


def module_in(path: Path) -> Module | None:
    """The module that a TOML file for `load_toml` names, or the usual one with the registers that it has; else None.

    Raises:
        ConfigError: the file cannot be read, is not TOML, or names no module.
    """
    with _named(path):
        return _module_of(_tables(path))


def _module_of(data: Mapping[str, Any]) -> Module | None:
    module = data.get("hardware")
    if module is not None:
        if module not in MODULES:
            known = f"must be one of {', '.join(MODULES)}{meant(str(module), MODULES)}"
            raise ConfigError(f"hardware = {module!r}: {known}")
        return module  # type: ignore[no-any-return]  # one of MODULES
    if "cot" in data or "slot" in data:
        return "cot_array"
    return "cot_motion" if "motion" in data else None


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
    return with_settings(name, settings, own), _filters(filters, _table(data, "filters", "top level"), folder)


def with_settings(name: str, settings: Any, changes: Mapping[str, Any]) -> Any:
    """The settings of a software tracker with other values, which may be another package's to check.

    Raises:
        ConfigError: a value that the settings refuse.
    """
    try:
        return replace(settings, **changes)
    except EvcotError:
        raise
    except Exception as error:
        given = ", ".join(f"{key} = {value!r}" for key, value in changes.items())
        raise ConfigError(f"{name}: {given}: {type(error).__name__}: {' '.join(str(error).split())}") from error


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
    known = {"name", "hardware", "software", "run", "made", "files", "shape", "cot", "slot", "motion", "rct", "adaptive"}
    _section(data, known | {"filters", "software_filters"}, "top level")
    rct = replace(base.rct, **_section(_table(data, "rct", "top level"), _names(RctConfig), "[rct]"))
    adaptive = replace(base.adaptive, **_section(_table(data, "adaptive", "top level"), _names(AdaptiveConfig), "[adaptive]"))
    return RunConfig(
        name=str(data.get("name", base.name)),
        hardware=_hardware(data, base.hardware),
        rct=rct,
        filters=_filters(base.filters, _table(data, "filters", "top level"), folder),
        software=data.get("software", base.software),
        adaptive=adaptive,
        software_filters=_software_filters(base, data, folder),
        sensor=base.sensor,
    )


def _hardware(data: Mapping[str, Any], base: CotConfig | MotionConfig) -> CotConfig | MotionConfig:
    """The hardware's configuration: that of the base, or the default one of another contract, with what the tables change."""
    module = _module_of(data) or base.module
    if module == "cot_motion":
        return _motion_hardware(data, base if isinstance(base, MotionConfig) else MotionConfig())
    if not isinstance(base, CotConfig):
        base = CotConfig()
    elif "hardware" not in data:
        module = base.module  # registers alone fit cot, cot_chain and cot_array
    return _cot_hardware(data, base, module)


def _motion_hardware(data: Mapping[str, Any], base: MotionConfig) -> MotionConfig:
    for name in ("cot", "slot"):
        if name in data:
            raise ConfigError(f"[{name}]: must not be given for cot_motion, whose registers stand in [motion]")
    shape = replace(base.shape, **_section(_table(data, "shape", "top level"), _names(Shape), "[shape]"))
    own = dict(_section(_table(data, "motion", "top level"), _names(MotionRegisters) | {"tick_us", "modes"}, "[motion]"))
    tick_us, modes = own.pop("tick_us", base.tick_us), own.pop("modes", None)
    if modes is None:
        modes = (base.modes + base.modes[-1:] * shape.n_slots)[: shape.n_slots]
    elif not isinstance(modes, list) or not all(type(mode) is int for mode in modes):
        raise ConfigError(f"[motion]: modes = {modes!r}: must be a list of 0 (off) or 2 (seeded), one per slot")
    return replace(base, shape=shape, registers=replace(base.registers, **own), tick_us=tick_us, modes=tuple(modes))


def _cot_hardware(data: Mapping[str, Any], base: CotConfig, module: str) -> CotConfig:
    if "motion" in data:
        raise ConfigError(f"[motion]: must not be given for {module}, whose registers stand in [cot] and [[slot]]")
    named = with_module(base, module)
    assert isinstance(named, CotConfig)
    shape = replace(named.shape, **_section(_table(data, "shape", "top level"), _names(Shape), "[shape]"))
    cot = dict(_section(_table(data, "cot", "top level"), _names(SlotConfig) | {"tick_us"}, "[cot]"))
    tick_us, template = cot.pop("tick_us", named.tick_us), named.slots
    slots = [replace(template[min(i, len(template) - 1)], **cot) for i in range(shape.n_slots)]
    own = data.get("slot", [])
    if not isinstance(own, list) or not all(isinstance(entry, Mapping) for entry in own):
        raise ConfigError("[[slot]] must be a list of tables")
    if len(own) > shape.n_slots:
        raise ConfigError(f"[[slot]] occurs {len(own)} times: must be at most shape.n_slots = {shape.n_slots}")
    for i, entry in enumerate(own):
        slots[i] = replace(slots[i], **_section(entry, _names(SlotConfig), f"[[slot]] {i}"))
    return CotConfig(shape, tuple(slots), tick_us, module=named.module)


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

# SPDX-License-Identifier: Apache-2.0
"""The fields of a configuration that a sweep may set: `preset`, `hardware`, or `TABLE.FIELD` as in a file for `--config`."""

from __future__ import annotations

import re
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict, fields
from functools import cache
from typing import Any

from evcot.errors import ConfigError
from evcot.filters.config import FILTER_RANGES, FilterConfig
from evcot.hardware.config import SlotConfig
from evcot.hardware.contract import REGISTERS, SHAPE_RANGES, Shape
from evcot.hardware.modules import MODULES
from evcot.hardware.motion.contract import MOTION_RANGES, MotionRegisters
from evcot.ranges import Range
from evcot.trackers.engines import ENGINES, usable_engines

__all__ = [
    "HARDWARE",
    "PRESET",
    "RTL",
    "check_engine",
    "check_field",
    "concerns",
    "limits",
    "nested",
    "numeric_fields",
    "with_fields",
]

RTL = "rtl"  # beside the names of `ENGINES`: the compiled hardware, in lock-step with the golden model
PRESET, HARDWARE = "preset", "hardware"
_OF_COT = ("cot", "slot")  # tables of cot, cot_chain and cot_array
_TICK_US: Range = (1, 1_000_000, "microseconds of a tick")
_SLOT = re.compile(r"slot\[(\d+)\]")
_FIELD = re.compile(r"([\w-]+(?:\[\d+\])?)\.(\w+)")


@cache
def _tables() -> Mapping[str, frozenset[str]]:
    """Table -> its fields."""
    registers = frozenset(field.name for field in fields(SlotConfig))
    return {
        "shape": frozenset(field.name for field in fields(Shape)),
        "cot": registers | {"tick_us"},
        "slot": registers,
        "motion": frozenset(field.name for field in fields(MotionRegisters)) | {"tick_us"},
        "filters": frozenset(field.name for field in fields(FilterConfig)),
        **{name: frozenset(asdict(_default(name))) for name in usable_engines() if name not in MODULES},
    }


def _default(engine: str) -> Any:
    return next(iter(ENGINES[engine].presets.values()))


def check_engine(name: str) -> None:
    """Raise ConfigError for a name that is neither of `ENGINES` nor `RTL`, EngineError for an engine that cannot be used."""
    if name not in (*ENGINES, RTL):
        raise ConfigError(f"engines: {name!r}: must be one of {', '.join((*ENGINES, RTL))}")
    if name != RTL:
        _default(name)


def check_field(name: str, where: str = "fields.") -> None:
    """Raise ConfigError for a name that no configuration has, EngineError for one of an engine that cannot be used.

    Args:
        where: prefixes the name.
    """
    if name in (PRESET, HARDWARE):
        return
    tables = _tables()
    parts = _FIELD.fullmatch(name)
    table = _SLOT.sub("slot", parts[1]) if parts else ""
    if table in ENGINES and table not in {*tables, *MODULES}:
        _default(table)  # says why the engine cannot be used
    if parts is None or table not in tables or (table == "slot") != (parts[1] != table):
        shown = ", ".join([*sorted(tables.keys() - {"slot"}), "slot[I]"])
        raise ConfigError(f"{where}{name}: no such field: must be preset, hardware, or TABLE.FIELD with a table among {shown}")
    if parts[2] not in tables[table]:
        raise ConfigError(f"{where}{name}: no such field: must be one of {', '.join(sorted(tables[table]))} in {parts[1]}")


def concerns(name: str, engine: str, hardware: Sequence[str] = MODULES) -> bool:
    """Whether a field means anything to an engine: a name of `ENGINES`, or `RTL` with one of these modules."""
    table = _SLOT.sub("slot", name.partition(".")[0])
    if table in (PRESET, "filters"):
        return True
    if table == HARDWARE:
        return engine == RTL
    modules = hardware if engine == RTL else [engine] if engine in MODULES else []
    if table == "shape":
        return bool(modules)
    if table in _OF_COT:
        return any(module != "cot_motion" for module in modules)
    return "cot_motion" in modules if table == "motion" else table == engine


def with_fields(tables: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Tables of a configuration with fields changed; those given stay as they are."""
    changed: dict[str, Any] = {name: dict(table) if isinstance(table, Mapping) else table for name, table in tables.items()}
    for name, value in changes.items():
        if name in (PRESET, HARDWARE):
            continue
        table, _, field = name.partition(".")
        slot = _SLOT.fullmatch(table)
        if slot is None:
            changed.setdefault(table, {})[field] = value
        else:
            slots = [dict(own) for own in changed.get("slot", [])]
            slots += [{} for _ in range(int(slot[1]) + 1 - len(slots))]
            slots[int(slot[1])][field] = value
            changed["slot"] = slots
    return changed


def nested(table: Mapping[str, Any], where: str = "") -> dict[str, Any]:
    """Fields by dotted name: TOML may have `rct.radius_px` or a table; what `axes` reads as a range is none of them."""
    found: dict[str, Any] = {}
    for key, value in table.items():
        if isinstance(value, Mapping) and not {"from", "to", "values"} & value.keys():
            found |= nested(value, f"{where}{key}.")
        else:
            found[f"{where}{key}"] = value
    return found


def limits(name: str) -> Range | None:
    """The range of a field that has one, whatever the rest of the configuration; registers in the widest shape."""
    table, _, field = name.partition(".")
    ranges: Mapping[str, Any]
    if _SLOT.sub("slot", table) in ("cot", "slot"):
        if field == "tick_us":
            return _TICK_US
        widest = Shape(**{each: high for each, (_, high, _) in SHAPE_RANGES.items()})
        low, high = REGISTERS[field].limits(widest)
        return low, high, REGISTERS[field].meaning
    if table in ("shape", "filters", "motion"):
        known: dict[str, Mapping[str, Any]] = {"shape": SHAPE_RANGES, "filters": FILTER_RANGES, "motion": MOTION_RANGES}
        ranges = known[table]
        return _TICK_US if field == "tick_us" else ranges.get(field)
    if table not in ENGINES:
        return None
    module = vars(sys.modules[type(_default(table)).__module__])
    found = [own[field] for key, own in module.items() if key.endswith("_RANGES") and field in own]
    return found[-1] if found else None


def numeric_fields(engine: str) -> dict[str, tuple[float, float, bool]]:
    """An engine's numbers that have a range: name -> lowest, highest, whether it is a whole number."""
    table = "motion" if engine in (RTL, "cot_motion") else "cot" if engine in MODULES else engine
    found = {}
    for field in sorted(_tables()[table]):
        allowed = limits(f"{table}.{field}")
        if allowed is not None:
            found[f"{table}.{field}"] = (allowed[0], allowed[1], isinstance(allowed[0], int))
    return found

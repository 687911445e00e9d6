# SPDX-License-Identifier: Apache-2.0
"""The specification of a sweep: a TOML file; docs/sweeps.md describes it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

import tomli_w

from evcot.errors import ConfigError
from evcot.hardware.contract import Shape
from evcot.hardware.modules import DEFAULT_MODULE, MODULES
from evcot.metrics import RULES
from evcot.outputs import is_plain_name, note_input
from evcot.scenes.registry import SCENES, scene_settings
from evcot.toml_file import read_toml
from evcot.trackers.engines import ENGINES

from ..lockstep.random_runs import TOP
from ..standard_streams import STANDARD_INPUT, as_file
from .axes import METHODS, RUNS_MAX, Axis, axis_from
from .fields import HARDWARE, PRESET, RTL, check_engine, nested
from .metrics import METRICS
from .places import placed
from .task import canonical

__all__ = ["FUZZED", "SHIPPED", "Fuzz", "Spec", "read_spec", "spec_from", "spec_toml"]

_FOLDER = Path(__file__).with_name("specs")
SHIPPED = tuple(sorted(path.stem for path in _FOLDER.glob("*.toml")))
"""Specifications that come with evcot, by name."""

_DIRECTIONS = ("max", "min")
FUZZED = (*MODULES, TOP)
"""What `Fuzz` can run: the trackers, and `evcot_top` around one of them."""

_FUZZ_EVENTS = 20_000


@dataclass(frozen=True)
class Fuzz:
    """Hardware against model with random registers, traffic and stalls.

    Attributes:
        modules: names of `FUZZED` -> events of each run.
        shapes: fields of `Shape` that differ from its defaults, one entry a shape.
        drawn: module -> number of random shapes, with filters, and with parameters of `evcot_top`; in place of `shapes`.
    """

    modules: Mapping[str, int]
    shapes: tuple[Mapping[str, int], ...] = ()
    drawn: Mapping[str, int] = field(default_factory=dict)

    @property
    def designs(self) -> int:
        """Shapes of all modules."""
        return sum(self.drawn.values()) if self.drawn else len(self.modules) * len(self.shapes)


@dataclass(frozen=True)
class Spec:
    """What a sweep is.

    Attributes:
        recordings: absolute paths of recordings, or of folders of them.
        scenes, scene_settings: simulated scenes, once for each of `seeds`, and what differs from their defaults.
        truth: path of a recording -> path of its truth; others have `NAME.truth.csv` or `NAME_gt.csv` beside them, if any.
        rule: of all truths; empty: by their columns.
        families: name of a group -> recordings or scenes; others are each a family of their own.
        parts: (from_us, to_us) of every recording; to_us None: to its end.
        engines: names of `ENGINES`, and `fields.RTL`.
        hardware: modules of `fields.RTL`.
        seeds: of scenes; with `stalls` also of the hardware's stall patterns.
        preset, tables: the configuration before `axes`.
        method, samples, batch, sampling_seed: how points are chosen; Optuna chooses `batch` points at a time.
        objectives: metric -> "max" or "min", the first first.
        best: number of best runs for which a page with their playback is made.
        timeout_s: time after which a run of the local scheduler is ended, 0 for none.
    """

    name: str
    recordings: tuple[str, ...] = ()
    scenes: tuple[str, ...] = ()
    scene_settings: Mapping[str, Any] = field(default_factory=dict)
    truth: Mapping[str, str] = field(default_factory=dict)
    rule: str = ""
    families: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    parts: tuple[tuple[int, int | None], ...] = ((0, None),)
    skip_damaged: bool = False
    engines: tuple[str, ...] = ("rct",)
    hardware: tuple[str, ...] = (DEFAULT_MODULE,)
    seeds: tuple[int, ...] = (1,)
    stalls: bool = False
    preset: str | None = None
    tables: Mapping[str, Any] = field(default_factory=dict)
    axes: tuple[Axis, ...] = ()
    method: str = "grid"
    samples: int = 0
    batch: int = 8
    sampling_seed: int = 1
    objectives: Mapping[str, str] = field(default_factory=dict)
    best: int = 1
    timeout_s: float = 0.0
    fuzz: Fuzz | None = None

    @property
    def has_inputs(self) -> bool:
        """Whether there is anything to run on."""
        return bool(self.recordings or self.scenes)


_TEXT, _WHOLE, _TRUTH = "text", "a whole number", "true or false"
_SCALARS = {
    "name": (str, _TEXT), "rule": (str, _TEXT), "method": (str, _TEXT), "preset": (str, _TEXT), "config": (str, _TEXT),
    "samples": (int, _WHOLE), "batch": (int, _WHOLE), "sampling_seed": (int, _WHOLE), "best": (int, _WHOLE),
    "stalls": (bool, _TRUTH), "skip_damaged": (bool, _TRUTH), "timeout_s": ((int, float), "a number"),
}  # fmt: skip
_LISTS = ("recordings", "scenes", "engines", "hardware")
_TABLES = ("truth", "families", "fields", "objectives", "scene_settings", "fuzz", "tables")
_OTHERS = ("seeds", "parts")


def read_spec(name: str) -> Spec:
    """Read a specification: a TOML file, or one of `SHIPPED`. Its paths are relative to its folder; of
    standard input, to the current one.

    Raises:
        ConfigError: it cannot be read or is not a specification; names file, field, value and rule.
    """
    path = Path(name)
    if name in SHIPPED and not path.exists():
        path = _FOLDER / f"{name}.toml"
    else:
        note_input(path)
    try:
        if path.suffix != ".toml" and not path.exists():
            raise ConfigError(f"cannot be read: No such file or directory (evcot's own are {', '.join(SHIPPED)})")
        folder = Path.cwd() if path == STANDARD_INPUT else path.absolute().parent
        return spec_from(read_toml(as_file(path)), folder, path.stem)
    except ConfigError as error:
        raise ConfigError(f"{name}: {error}") from error


def spec_from(data: Mapping[str, Any], folder: Path, name: str) -> Spec:
    """A specification of the values of its file, which are checked; paths are relative to `folder`.

    Raises:
        ConfigError: a field that is not one, or a value outside its range.
    """
    known = (*_SCALARS, *_LISTS, *_TABLES, *_OTHERS)
    for key, value in data.items():
        if key not in known:
            raise ConfigError(f"unknown field {key!r}: must be one of {', '.join(sorted(known))}")
        _check_kind(key, value)
    scalars = {key: data[key] for key in _SCALARS if key in data and key != "config"}
    recordings = tuple(placed(folder, each) for each in data.get("recordings", ()))
    spec = Spec(
        **{"name": name, **scalars, "rule": _rule(data.get("rule", ""), folder)},
        recordings=recordings,
        scenes=tuple(data.get("scenes", ())),
        scene_settings=dict(data.get("scene_settings", {})),
        truth={placed(folder, each): placed(folder, path) for each, path in data.get("truth", {}).items()},
        families={
            family: tuple(each if each in SCENES else placed(folder, each) for each in _texts(f"families.{family}", members))
            for family, members in data.get("families", {}).items()
        },
        parts=_parts(data.get("parts", [[0]])),
        engines=tuple(data.get("engines", Spec.engines)),
        hardware=tuple(data.get("hardware", Spec.hardware)),
        seeds=_seeds(data.get("seeds", [1])),
        tables=_tables(data, folder),
        axes=tuple(axis_from(field, values) for field, values in nested(data.get("fields", {})).items()),
        objectives=dict(data.get("objectives", {})),
        fuzz=_fuzz(data["fuzz"]) if "fuzz" in data else None,
    )
    _check(spec)
    return spec


def spec_toml(spec: Spec) -> str:
    """The text of a specification file with the same meaning in every folder."""
    plain = Spec(spec.name)
    values: dict[str, Any] = {"name": spec.name}
    for each in fields(Spec):
        value = getattr(spec, each.name)
        if each.name not in ("name", "axes", "fuzz", "parts") and value != getattr(plain, each.name) and value is not None:
            values[each.name] = list(value) if isinstance(value, tuple) else value
    if len(spec.seeds) > 2 and spec.seeds == tuple(range(spec.seeds[0], spec.seeds[-1] + 1)):
        values["seeds"] = {"from": spec.seeds[0], "to": spec.seeds[-1]}
    if spec.parts != plain.parts:
        values["parts"] = [[begin] if end is None else [begin, end] for begin, end in spec.parts]
    if spec.axes:
        values["fields"] = {axis.name: _axis_value(axis) for axis in spec.axes}
    if spec.fuzz is not None:
        shapes = [dict(shape) for shape in spec.fuzz.shapes]
        modules = dict(spec.fuzz.modules)
        values["fuzz"] = {"modules": list(modules), "shapes": dict(spec.fuzz.drawn) or shapes, "events": modules}
    return tomli_w.dumps({key: _lists(value) for key, value in values.items()})


def _rule(rule: str, folder: Path) -> str:
    """A rule's name, or the path of its file."""
    return rule if rule in ("", *RULES) else str(folder / rule)


def _lists(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _lists(each) for key, each in value.items()}
    return [_lists(each) for each in value] if isinstance(value, list | tuple) else value


def _axis_value(axis: Axis) -> Any:
    if axis.choices:
        return {"values": list(axis.choices)}
    more = {"log": True} if axis.log else {}
    return {"from": axis.low, "to": axis.high, **more, **({} if axis.steps is None else {"steps": axis.steps})}


def _check_kind(key: str, value: Any) -> None:
    if key in _SCALARS:
        kind, meaning = _SCALARS[key]
        if not isinstance(value, kind) or (isinstance(value, bool) and kind is not bool):  # type: ignore[arg-type]
            raise ConfigError(f"{key} = {value!r}: must be {meaning}")
    elif key in _LISTS:
        _texts(key, value)
    elif key in _TABLES and not isinstance(value, Mapping):
        raise ConfigError(f"{key} = {value!r}: must be a table")


def _texts(key: str, value: Any) -> Sequence[str]:
    if not isinstance(value, list) or not value or not all(isinstance(each, str) for each in value):
        raise ConfigError(f"{key} = {value!r}: must be a list of text, with one entry at least")
    return value


def _seeds(value: Any) -> tuple[int, ...]:
    if isinstance(value, Mapping):
        low, high = value.get("from"), value.get("to")
        if value.keys() != {"from", "to"} or not all(type(limit) is int for limit in (low, high)):
            raise ConfigError(f"seeds = {dict(value)!r}: must be {{from, to}}, both whole numbers")
        assert isinstance(low, int)
        assert isinstance(high, int)
        if not 0 <= low <= high or high - low >= RUNS_MAX:
            raise ConfigError(f"seeds: from {low} to {high}: must not be negative or empty, and at most {RUNS_MAX:,}")
        return tuple(range(low, high + 1))
    if not isinstance(value, list) or not value or not all(type(each) is int and each >= 0 for each in value):
        raise ConfigError(f"seeds = {value!r}: must be whole numbers, not negative, one at least; or {{from, to}}")
    return tuple(dict.fromkeys(value))


def _parts(value: Any) -> tuple[tuple[int, int | None], ...]:
    def good(part: Any) -> bool:
        numbers = isinstance(part, list) and 1 <= len(part) <= 2 and all(type(each) is int and each >= 0 for each in part)
        return numbers and (len(part) == 1 or part[0] < part[1])

    if not isinstance(value, list) or not value or not all(good(part) for part in value):
        raise ConfigError(f"parts = {value!r}: must be a list of [from_us, to_us] or [from_us], with from_us below to_us")
    return tuple((part[0], part[1] if len(part) > 1 else None) for part in value)


def _tables(data: Mapping[str, Any], folder: Path) -> Mapping[str, Any]:
    """The tables of the file `config`, with those of `tables` on top."""
    tables: dict[str, Any] = {}
    if "config" in data:
        path = folder / data["config"]
        note_input(path)
        try:
            tables = read_toml(path)
        except ConfigError as error:
            raise ConfigError(f"config = {data['config']!r}: {error}") from error
    for name, table in data.get("tables", {}).items():
        tables[name] = {**tables.get(name, {}), **table} if isinstance(table, Mapping) else table
    return tables


def _fuzz(value: Mapping[str, Any]) -> Fuzz:
    for key in value:
        if key not in ("modules", "shapes", "events"):
            raise ConfigError(f"fuzz: unknown field {key!r}: must be one of events, modules, shapes")
    modules = _texts("fuzz.modules", value.get("modules", list(FUZZED)))
    for module in modules:
        if module not in FUZZED:
            raise ConfigError(f"fuzz.modules: {module!r}: must be one of {', '.join(FUZZED)}")
    events = _of_each("events", value.get("events", _FUZZ_EVENTS), modules, 10**9)
    shapes = value.get("shapes", [{}])
    if isinstance(shapes, int | Mapping):
        return Fuzz(events, drawn=_of_each("shapes", shapes, modules, RUNS_MAX))
    if not isinstance(shapes, list) or not shapes or not all(isinstance(shape, Mapping) for shape in shapes):
        raise ConfigError(f"fuzz.shapes = {shapes!r}: must be a list of tables, one at least, or how many to draw")
    names = {each.name for each in fields(Shape)}
    for i, shape in enumerate(shapes):
        for key in shape:
            if key not in names:
                raise ConfigError(f"fuzz.shapes[{i}]: unknown field {key!r}: must be one of {', '.join(sorted(names))}")
        try:
            Shape(**shape)
        except ConfigError as error:
            raise ConfigError(f"fuzz.shapes[{i}]: {error}") from error
    return Fuzz(events, tuple(dict(shape) for shape in shapes))


def _of_each(field_name: str, value: Any, modules: Sequence[str], most: int) -> dict[str, int]:
    """Module -> number, of a number for all or of one for each."""
    found = dict(value) if isinstance(value, Mapping) else dict.fromkeys(modules, value)
    for module in sorted(found.keys() ^ set(modules)):
        raise ConfigError(f"fuzz.{field_name}.{module}: must be given for each of {', '.join(modules)}, and for no other")
    for module, number in found.items():
        if type(number) is not int or not 1 <= number <= most:
            raise ConfigError(f"fuzz.{field_name} = {number!r} for {module}: must be a whole number from 1 to {most}")
    return {module: found[module] for module in modules}


def _check(spec: Spec) -> None:
    if not is_plain_name(spec.name):
        raise ConfigError(f"name = {spec.name!r}: must be a name for a folder in build/sweep, without / and \\")
    if spec.fuzz is not None:
        if spec.has_inputs or spec.axes:
            raise ConfigError("fuzz: must not be given with recordings, scenes or fields")
        return
    if not spec.has_inputs:
        raise ConfigError("recordings: must be given, or scenes, or fuzz")
    for engine in spec.engines:
        check_engine(engine)
    for module in spec.hardware:
        if module not in MODULES:
            raise ConfigError(f"hardware: {module!r}: must be one of {', '.join(MODULES)}")
    for scene in spec.scenes:
        scene_settings(scene, spec.seeds[0], spec.scene_settings)
    if spec.method not in METHODS:
        raise ConfigError(f"method = {spec.method!r}: must be one of {', '.join(METHODS)}")
    if spec.method != "grid" and not 1 <= spec.samples <= RUNS_MAX:
        raise ConfigError(f"samples = {spec.samples}: must be from 1 to {RUNS_MAX:,} with method = {spec.method!r}")
    if spec.method != "grid" and not spec.axes:
        raise ConfigError(f"fields: must have one at least with method = {spec.method!r}")
    for name, low in (("batch", 1), ("best", 0), ("timeout_s", 0), ("sampling_seed", 0)):
        if getattr(spec, name) < low:
            raise ConfigError(f"{name} = {getattr(spec, name)}: must be at least {low}")
    for metric, direction in spec.objectives.items():
        if metric not in METRICS:
            raise ConfigError(f"objectives.{metric}: no such metric: must be one of {', '.join(METRICS)}")
        if direction not in _DIRECTIONS:
            raise ConfigError(f"objectives.{metric} = {direction!r}: must be max or min")
    if spec.method == "optuna" and not spec.objectives:
        raise ConfigError("objectives: must have one at least with method = 'optuna'")
    for axis in spec.axes:
        if axis.name in (PRESET, HARDWARE):
            if not axis.choices:
                raise ConfigError(f"fields.{axis.name}: must be a list of names")
            owners = {each for engine in spec.engines for each in (MODULES if engine == RTL else [engine])}
            presets = {name for engine in owners for name in ENGINES[engine].presets}
            for choice in axis.choices if axis.name == PRESET else ():
                if choice not in presets:
                    raise ConfigError(f"fields.preset: {choice!r}: must be one of {', '.join(sorted(presets))}")
            if axis.name == HARDWARE and not set(axis.choices) <= set(MODULES):
                raise ConfigError(f"fields.hardware = {list(axis.choices)}: must be of {', '.join(MODULES)}")
    names = [canonical(axis.name) for axis in spec.axes]
    if len(set(names)) < len(names):
        raise ConfigError("fields: each must be given once")
    members = {each for own in spec.families.values() for each in own}
    strangers = members - {*spec.scenes, *spec.recordings}
    if strangers:
        raise ConfigError(f"families: {sorted(strangers)[0]}: must be one of scenes or recordings")

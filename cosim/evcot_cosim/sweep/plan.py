# SPDX-License-Identifier: Apache-2.0
"""From a specification to tasks: every point on every input, with every engine and seed; each distinct run once."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from typing import Any

import numpy as np

from evcot.errors import ConfigError, RecordingError
from evcot.hardware.contract import Shape
from evcot.recordings.formats.source import Sensor
from evcot.trackers.config import RunConfig
from evcot.trackers.engines import ENGINES

from ..devices.base import check_addresses
from ..lockstep.random_runs import Design
from ..rtl.files import design_fingerprint
from .axes import RUNS_MAX, Point, grid, latin, uniform
from .execute import FAILED, INVALID
from .fields import HARDWARE, PRESET, RTL, concerns, with_fields
from .inputs import inputs_of, sensor_of
from .machine import code_fingerprint, code_of
from .spec import FUZZED, Spec
from .task import DRAWN, FUZZ, Input, Task, canonical, configuration, tables_of

__all__ = ["Invalid", "Plan", "Planner", "points_of"]


@dataclass(frozen=True)
class Invalid:
    """A run that cannot be: its settings together break a rule of the configuration, or its recording is damaged.

    Attributes:
        status: of its row.
    """

    task: Task
    error: str
    status: str = INVALID


@dataclass
class Plan:
    """Distinct runs in the order in which they are best done, and those that cannot be."""

    tasks: list[Task] = field(default_factory=list)
    invalid: list[Invalid] = field(default_factory=list)

    @property
    def designs(self) -> int:
        """Number of distinct hardware designs."""
        return len({design_of(task) for task in self.tasks if task.design})


def design_of(task: Task) -> tuple[str, str]:
    """What distinguishes the designs of tasks: module and shape."""
    tables = task.tables
    if task.engine == FUZZ:
        return task.hardware, canonical(tables)
    filters = canonical(sorted(tables.get("filters", {}))) + str(task.preset)
    size = canonical([task.input.width, task.input.height]) if task.input else ""
    return task.hardware, canonical(tables.get("shape", {})) + filters + size


def points_of(spec: Spec) -> Iterator[Point]:
    """The points that a specification names before anything has run; those of Optuna come one batch after the other."""
    if not spec.axes:
        return iter([{}])
    if spec.method == "grid":
        return grid(spec.axes)
    choose = latin if spec.method == "latin" else uniform
    return choose(spec.axes, spec.samples, spec.sampling_seed)


class Planner:
    """Makes tasks of points.

    Args:
        spec: the specification; its inputs are read.

    Raises:
        ConfigError: an input that is missing.
    """

    def __init__(self, spec: Spec) -> None:
        self.spec = spec
        self.inputs = inputs_of(spec)
        self._sensors: dict[int, Sensor] = {}
        self._damaged: dict[int, str] = {}
        for each in self.inputs:
            try:
                self._sensors[id(each)] = sensor_of(each)
            except RecordingError as error:  # other recordings are swept
                self._damaged[id(each)] = str(error)
        self._checked: dict[str, str | None] = {}

    @property
    def paths(self) -> list[str]:
        """The files that workers read."""
        rules = {each.rule for each in self.inputs if each.rule_content}
        files = {path for each in self.inputs if not each.is_scene for path in (each.name, each.truth) if path}
        return sorted(files | rules)

    def fuzz(self) -> Plan:
        """The runs of `Fuzz`: modules x shapes x seeds; each of the shapes that are drawn is another for each module.

        Raises:
            ConfigError: more than `RUNS_MAX`.
        """
        fuzz = self.spec.fuzz
        assert fuzz is not None
        _check_count(fuzz.designs * len(self.spec.seeds))
        plan = Plan()
        for module, events in fuzz.modules.items():
            common = Task(FUZZ, hardware=module, events=events, code=code_fingerprint(), design=design_fingerprint())
            for number in range(fuzz.drawn.get(module, 0)):
                design = Design.random(np.random.default_rng([number, FUZZED.index(module)]), module)
                own = replace(common, tables=design.to_tables(), settings={DRAWN: number})
                plan.tasks += [replace(own, seed=seed) for seed in self.spec.seeds]
            for shape in fuzz.shapes:
                settings = {f"shape.{name}": value for name, value in shape.items()}
                own = replace(common, tables={"shape": dict(shape)}, settings=settings)
                try:
                    own = replace(own, tables=Design.of(module, Shape(**shape)).to_tables())
                except ConfigError as error:
                    plan.invalid.append(Invalid(own, str(error)))
                    continue
                plan.tasks += [replace(own, seed=seed) for seed in self.spec.seeds]
        plan.tasks = _designs_first(plan.tasks)
        return plan

    def plan(self, points: Iterable[Point], engines: Sequence[str] | None = None, *, strict: bool = True) -> Plan:
        """The runs of points, each once.

        Args:
            engines: some of the specification's; None: all.
            strict: whether it is an error that a value, or an engine, has no run that can be.

        Raises:
            ConfigError: every run with one of the values, or every run of an engine, cannot be; the first reason. Or there are
                more than `RUNS_MAX`.
        """
        plan, seen = Plan(), set[str]()
        refused: dict[tuple[str, str], str] = {}  # (engine, field = value) -> why
        accepted: set[tuple[str, str]] = set()
        for point in points:
            for engine in self.spec.engines if engines is None else engines:
                modules = [point[HARDWARE]] if HARDWARE in point else self.spec.hardware
                named = [(engine, canonical([name, value])) for name, value in point.items() if concerns(name, engine, modules)]
                for task in self._tasks(engine, point):
                    if id(task.input) in self._damaged:
                        if task.key not in seen:
                            plan.invalid.append(Invalid(task, self._damaged[id(task.input)], FAILED))
                        seen.add(task.key)
                        continue
                    fault = self._fault(task)
                    if fault is None:
                        accepted.update([*named, (engine, "")])
                    else:
                        for each in [*named, (engine, "")]:
                            refused.setdefault(each, fault)
                    if task.key not in seen:
                        seen.add(task.key)
                        plan.tasks += [task] if fault is None else []
                        plan.invalid += [Invalid(task, fault)] if fault is not None else []
            _check_count(len(seen))
        choices = {canonical([axis.name, value]) for axis in self.spec.axes for value in axis.choices} | {""}
        for (engine, what), fault in sorted(refused.items(), key=lambda each: each[0][1]) if strict else ():
            if what in choices and (engine, what) not in accepted:
                raise ConfigError(f"no run of engine {engine} is possible{_with(what)}: {fault}")
        plan.tasks = _designs_first(plan.tasks)
        return plan

    def _tasks(self, engine: str, point: Point) -> Iterator[Task]:
        spec = self.spec
        modules: Sequence[str] = ("",)
        if engine == RTL:
            modules = (point[HARDWARE],) if HARDWARE in point else spec.hardware
        preset = point.get(PRESET, spec.preset)
        seeds: Sequence[int | None] = spec.seeds if engine == RTL and spec.stalls else (None,)
        design = design_fingerprint() if engine == RTL else ""
        for source in self.inputs:
            for module in modules:
                if PRESET in point and preset not in ENGINES[module or engine].presets:
                    continue  # it is another engine's
                own: dict[str, Any] = {name: value for name, value in point.items() if concerns(name, engine, [module])}
                tables = tables_of(with_fields(spec.tables, own), module or engine)
                for seed in (source.scene_seed,) if source.is_scene and seeds != (None,) else seeds:
                    yield Task(engine, source, preset, tables, module, seed, 0, own, code_of(engine), design)

    def _fault(self, task: Task) -> str | None:
        """Why a run cannot be; None if it can."""
        assert task.input is not None
        sensor = self._sensors[id(task.input)]
        what = canonical([task.engine, sensor, task.preset, task.tables, task.hardware])
        if what not in self._checked:
            self._checked[what] = _fault(task, sensor)
        return self._checked[what]


def _fault(task: Task, sensor: Sensor) -> str | None:
    try:
        config, _ = configuration(task.engine, sensor, task.preset, task.tables, task.hardware)
        if isinstance(config, RunConfig):
            config.device_config(*sensor)
            check_addresses(sensor, config.hardware, "the input")
    except (ConfigError, RecordingError) as error:
        return str(error)
    return None


def _check_count(runs: int) -> None:
    if runs > RUNS_MAX:
        raise ConfigError(f"a sweep of {runs:,} or more runs: must be at most {RUNS_MAX:,}")


def _with(what: str) -> str:
    return f" with {what.replace(chr(34), '')}" if what else ""


def _designs_first(tasks: Sequence[Task]) -> list[Task]:
    """One task of each design first, so that designs are built side by side; then by input, which a worker keeps."""
    first: dict[tuple[str, str], Task] = {}
    for task in tasks:
        if task.design:
            first.setdefault(design_of(task), task)
    chosen = {id(task) for task in first.values()}
    order: Mapping[str, int] = {}
    rest = [task for task in tasks if id(task) not in chosen]
    order = {_input_name(task.input): i for i, task in reversed(list(enumerate(rest)))}
    return list(chain(first.values(), sorted(rest, key=lambda task: order[_input_name(task.input)])))


def _input_name(source: Input | None) -> str:
    return "" if source is None else canonical([source.name, source.scene_seed])

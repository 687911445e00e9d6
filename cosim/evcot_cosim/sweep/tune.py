# SPDX-License-Identifier: Apache-2.0
"""Settings chosen on some recordings and validated on others: whole ones, or the end of the only one."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from evcot.errors import ConfigError
from evcot.hardware.config import MotionConfig
from evcot.hardware.modules import MODULES
from evcot.recordings.files import open_recording
from evcot.trackers.config import RunConfig

from ..lockstep.run_file import config_tables
from .axes import Axis, axis_from
from .fields import RTL, concerns, limits, numeric_fields, with_fields
from .inputs import inputs_of, sensor_of
from .metrics import METRICS
from .places import local
from .results import Group, best_first, grouped
from .run import Swept
from .spec import Spec
from .store import read_rows
from .task import canonical, configuration

__all__ = ["Tuned", "axes_from", "default_axes", "divided", "objective_from", "preset_toml", "tune"]

Sweep = Callable[[Spec, Path], Swept]
"""Does the runs of a specification in a folder."""

_FACTOR = 2.0  # of a preset's number, up and down
_KEPT = 0.5  # of the gain on the first set: with less on the second there is over-fitting
_LEAST_GAIN = 0.005  # that is worth a word


@dataclass(frozen=True)
class Tuned:
    """What was found.

    Attributes:
        settings: the chosen fields; empty where nothing that was tried is better than the preset.
        metric, way: the objective, and "max" or "min".
        chosen_on, validated_on: names of the recordings, or of the parts of the only one.
        tried: configurations.
        chosen, validated: the objective with the chosen settings, on either set.
        chosen_before, validated_before: the same with the preset.
    """

    settings: Mapping[str, Any]
    metric: str
    way: str
    chosen_on: tuple[str, ...]
    validated_on: tuple[str, ...]
    tried: int
    chosen: float
    validated: float
    chosen_before: float
    validated_before: float

    @property
    def gains(self) -> tuple[float, float]:
        """By how much the chosen settings are better than the preset: on what they were chosen on, and on the rest."""
        sign = 1 if self.way == "max" else -1
        return sign * (self.chosen - self.chosen_before), sign * (self.validated - self.validated_before)

    @property
    def warning(self) -> str:
        """A warning of over-fitting, in a line; empty if there is nothing to warn of."""
        on_chosen, on_validated = self.gains
        if on_chosen < _LEAST_GAIN and on_validated > -_LEAST_GAIN:
            return "nothing was gained: the preset is as good as the best of what was tried, or better"
        if on_validated < 0:
            return (
                f"over-fitting: {on_chosen:.3f} better than the preset on what the settings were chosen on, and "
                f"{-on_validated:.3f} WORSE on what they have not seen: use the preset, or more recordings"
            )
        if on_validated < _KEPT * on_chosen:
            return (
                f"over-fitting: of the gain of {on_chosen:.3f} on what the settings were chosen on, {on_validated:.3f} is left "
                "on what they have not seen"
            )
        return ""

    def to_dict(self) -> dict[str, Any]:
        """Plain values."""
        on_chosen, on_validated = self.gains
        return {**asdict(self), "gain_chosen": on_chosen, "gain_validated": on_validated, "warning": self.warning}


def tune(spec: Spec, share: float, folder: Path, sweep: Sweep) -> Tuned:
    """Choose settings and validate them.

    Args:
        spec: one engine, the axes, one objective, the recordings.
        share: of the recordings, or of the only one's time, for validation.
        folder: the two stores are made there.
        sweep: does the runs.

    Raises:
        ConfigError: a recording without a truth, or no setting with a score.
        RecordingError, OutputError.
    """
    first, second, names = divided(spec, share)
    for source in inputs_of(spec):
        if not source.has_truth:
            raise ConfigError(f"{source.name}: has no truth: must be given with --truth, or stand beside it as NAME.truth.csv")
    (metric, way) = next(iter(spec.objectives.items()))
    before = [_scored(_fixed(each, {}), folder / name, sweep) for each, name in ((first, "choose"), (second, "validate"))]
    groups = _groups(first, folder / "choose", sweep)
    best = best_first(groups, spec.objectives)
    if not best:
        raise ConfigError(f"objective {metric}: no setting that was tried has a score: must have one at least")
    chosen = best[0].means[metric]
    if chosen <= before[0] if way == "max" else chosen >= before[0]:
        return Tuned({}, metric, way, *names, len(groups), *before, *before)
    validated = _scored(_fixed(second, best[0].settings), folder / "validate", sweep)
    return Tuned(best[0].settings, metric, way, *names, len(groups), chosen, validated, *before)


def divided(spec: Spec, share: float) -> tuple[Spec, Spec, tuple[tuple[str, ...], tuple[str, ...]]]:
    """A specification for choosing, one for validation, and what each is called.

    Raises:
        ConfigError: a share that leaves one of them empty.
    """
    if not 0.05 <= share <= 0.95:
        raise ConfigError(f"--validate {share:g}: must be from 0.05 to 0.95")
    recordings = spec.recordings
    if len(recordings) > 1:
        count = min(max(1, round(share * len(recordings))), len(recordings) - 1)
        order = np.random.default_rng([spec.sampling_seed, 7]).permutation(len(recordings))
        later = {recordings[i] for i in order[:count]}
        sets = [tuple(each for each in recordings if (each in later) == second) for second in (False, True)]
        names = tuple(tuple(Path(each).name for each in own) for own in sets)
        specs = [replace(spec, recordings=own, truth={k: v for k, v in spec.truth.items() if k in own}) for own in sets]
        return specs[0], specs[1], (names[0], names[1])
    with open_recording(local(recordings[0])) as file:
        last_us = max(int(block.t_us[-1]) for block in file.blocks(required=True) if len(block))
        end_us = last_us - file.t0_us
    cut_us = round((1 - share) * end_us)
    if not 0 < cut_us < end_us:
        raise ConfigError(f"{recordings[0]}: lasts {end_us} us: is too short to be divided")
    name = Path(recordings[0]).name
    parts = (f"{name}, 0 to {cut_us / 1e6:.3f} s",), (f"{name}, {cut_us / 1e6:.3f} to {end_us / 1e6:.3f} s",)
    return replace(spec, parts=((0, cut_us),)), replace(spec, parts=((cut_us, None),)), parts


def _fixed(spec: Spec, settings: Mapping[str, Any]) -> Spec:
    """The same without axes, with these settings."""
    return replace(spec, axes=(), method="grid", tables=with_fields(spec.tables, settings))


def _groups(spec: Spec, folder: Path, sweep: Sweep) -> list[Group]:
    keys = sweep(spec, folder).keys
    return grouped([row for row in read_rows(folder) if row["key"] in keys], list(spec.objectives))


def _scored(spec: Spec, folder: Path, sweep: Sweep) -> float:
    """The objective of a specification with one configuration.

    Raises:
        ConfigError: a run of it was not done.
    """
    (group,) = _groups(spec, folder, sweep)
    metric = next(iter(spec.objectives))
    if metric not in group.means:
        row = next((row for row in group.rows if row["error"]), group.rows[0])
        raise ConfigError(f"{row['input']}: has no {metric}: {row['error'] or 'must have a truth with objects'}")
    return group.means[metric]


def objective_from(text: str) -> dict[str, str]:
    """An objective as METRIC, or METRIC:min.

    Raises:
        ConfigError: no such metric.
    """
    metric, colon, way = text.partition(":")
    if metric not in METRICS or (colon and way not in ("max", "min")):
        raise ConfigError(f"--objective {text}: must be METRIC or METRIC:min with a metric among {', '.join(METRICS)}")
    return {metric: way or "max"}


def axes_from(texts: Sequence[str], engine: str) -> tuple[Axis, ...]:
    """Axes as NAME=LOW..HIGH or NAME=A,B,C.

    Raises:
        ConfigError: text that is neither, or a field that the engine does not have.
    """
    axes = []
    for text in texts:
        name, equals, values = text.partition("=")
        if not equals or not values:
            raise ConfigError(f"--field {text}: must be NAME=LOW..HIGH or NAME=A,B,C")
        span = re.fullmatch(r"(.+?)\.\.(.+)", values)
        given: Any = [_value(each) for each in values.split(",")]
        if span is not None:
            given = {"from": _value(span[1]), "to": _value(span[2])}
        try:
            axes.append(axis_from(name, given))
        except ConfigError as error:
            raise ConfigError(f"--field {text}: {error}") from error
        if not concerns(name, engine):
            raise ConfigError(f"--field {text}: must be a field of engine {engine}")
    return tuple(axes)


def _value(text: str) -> Any:
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return {"true": True, "false": False}.get(text, text)


def default_axes(spec: Spec) -> tuple[Axis, ...]:
    """Every number of the engine from half to twice what the preset has; what is 0, and so off, stays.

    Raises:
        ConfigError, RecordingError: a preset or a recording that cannot be used.
    """
    (engine,) = spec.engines
    settings, _ = configuration(engine, sensor_of(inputs_of(spec)[0]), spec.preset, spec.tables, _hardware_of(spec))
    own = settings
    if isinstance(settings, RunConfig):
        hardware = settings.hardware
        own = hardware.registers if isinstance(hardware, MotionConfig) else hardware.slots[0]
    axes = []
    for name, (_, _, whole) in numeric_fields(engine).items():
        value = getattr(own, name.partition(".")[2], None)
        allowed = limits(name)
        if isinstance(value, bool) or not isinstance(value, int | float) or value <= 0 or allowed is None or name == "cot.mode":
            continue
        low, high = max(allowed[0], value / _FACTOR), min(allowed[1], value * _FACTOR)
        if whole:
            low, high = max(1, int(low)), int(high)
        if low < high:
            axes.append(Axis(name, (), low, high, log=low > 0))
    if not axes:
        raise ConfigError(f"engine {engine}: has no number to choose: must be given with --field")
    return tuple(axes)


def _hardware_of(spec: Spec) -> str:
    """The module, if the engine is the hardware."""
    return spec.hardware[0] if spec.engines == (RTL,) else ""


def preset_toml(spec: Spec, tuned: Tuned, command: str) -> str:
    """The chosen configuration, complete, as a file for `--config`; how it was found stands in its comments."""
    (engine,) = spec.engines
    tables = with_fields(spec.tables, tuned.settings)
    settings, filters = configuration(engine, sensor_of(inputs_of(spec)[0]), spec.preset, tables, _hardware_of(spec))
    if isinstance(settings, RunConfig):
        values = config_tables(settings)
        for name in ("x_w", "y_w"):  # they follow the sensor
            del values["shape"][name]
        del values["software"], values[settings.software]
        values.pop("software_filters", None)
    else:
        plain = {engine: asdict(settings), "filters": asdict(filters)}
        values = {name: {key: value for key, value in table.items() if value is not None} for name, table in plain.items()}
    usage = "evcot cosim FILE" if engine in (RTL, *MODULES) else f"evcot track FILE --engine {engine}"
    lines = [
        f"Made by `{command}`; to be used as `{usage} --config THIS`.",
        f"{tuned.metric} {tuned.chosen:.4f} on what it was chosen on ({', '.join(tuned.chosen_on)}), the preset "
        f"{tuned.chosen_before:.4f}; {tuned.tried} settings were tried.",
        f"{tuned.metric} {tuned.validated:.4f} on what it has not seen ({', '.join(tuned.validated_on)}), the preset "
        f"{tuned.validated_before:.4f}.",
        *([f"Warning: {tuned.warning}."] if tuned.warning else []),
        f"Chosen: {canonical(dict(tuned.settings))}",
    ]
    return "".join(f"# {' '.join(line.split())}\n" for line in lines) + tomli_w.dumps(values)

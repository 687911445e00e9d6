# SPDX-License-Identifier: Apache-2.0
"""The report of a sweep: one HTML file in the style of a run's, without external resources."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from importlib.resources import files
from typing import Any, NamedTuple

import numpy as np

from evcot.templating import html_templates

from ..report.pack import Column, pack
from ..report.page import inline_modules, inline_script, inline_styles
from .execute import DONE, MISMATCH
from .fields import RTL
from .folder import SPEC
from .results import Group, Level, front, module_and_shape, responses, suites_of
from .spec import Spec, spec_toml
from .task import FUZZ, canonical

__all__ = ["render"]

_SHARED = ("columns", "theme")  # of the report of a run
_MODULES = ("shades", "lines", "parallel", "scatter", "sweep")  # in the order in which they need each other
_STEPS = 65_534  # of a range, in two bytes
_LINES_MAX = 200_000
_FAULTS_MAX = 200
_ROOM = (46.0, 292.0, 10.0, 130.0)  # of a response: left, right, top, bottom
_HEIGHT, _ROW, _NAMES = 150, 16.0, 50.0  # of a response; of a row of one; what names have beside the room


def render(spec: Spec, rows: Sequence[Mapping[str, Any]], groups: Sequence[Group], summary: Mapping[str, Any]) -> str:
    """The page as text.

    Args:
        rows: all runs.
        groups: by configuration.
        summary: of `finish`.
    """
    objectives = list(spec.objectives.items())
    drawn = [group for group in groups if all(metric in group.means for metric, _ in objectives)] if objectives else []
    drawn = drawn[:_LINES_MAX]
    axes, columns = _axes(drawn, objectives)
    packed = pack(columns)
    place = {id(group): i for i, group in enumerate(drawn)}
    on_front = [place[id(group)] for group in front(drawn, spec.objectives)] if len(objectives) > 1 else []
    facts = {"count": len(drawn), "axes": axes, "front": on_front, "columns": packed.directory}
    charts = [_chart(name, levels) for name, levels in responses(drawn, objectives[0][0]).items()] if drawn else []
    by_module = sorted(rows, key=lambda row: (row["hardware"], row["task"])) if spec.fuzz is not None else []
    suites = [{"name": name, **suite.to_dict()} for name, suite in suites_of(by_module, module_and_shape).items()]
    faults = list(summary["faults"])
    left_out = list(summary["left_out"].items())
    script = inline_modules(_SHARED) + inline_modules(_MODULES, __package__ or "")
    has = {
        "best": ("Best", summary["best"]), "front": ("Front" if len(objectives) > 1 else "Results", drawn),
        "coordinates": ("Parallel coordinates", drawn), "responses": ("Responses", charts), "suites": ("Modules", suites),
        "families": ("Families", left_out), "faults": ("Not done", faults), "specification": ("Specification", True),
    }  # fmt: skip
    environment = html_templates("evcot_cosim.sweep")
    return environment.get_template("sweep.html.j2").render(
        title=spec.name,
        runs=len(rows),
        configurations=len(groups),
        states=sorted(summary["status"].items()),
        hours=_hours(sum(row["wall_s"] or 0.0 for row in rows)),
        hosts=", ".join(sorted({row["host"] for row in rows if row["host"]})) or "no machine",
        parts=[(part, name) for part, (name, there) in has.items() if there],
        mismatches=_mismatches(rows),
        objectives=objectives,
        best=summary["best"],
        drawn=bool(drawn),
        thinned="" if len(drawn) < _LINES_MAX else f"The first {_LINES_MAX:,} are drawn.",
        charts=charts,
        suites=suites,
        left_out=left_out,
        faults=faults[:_FAULTS_MAX],
        more_faults=max(0, len(faults) - _FAULTS_MAX),
        specification=f"# {SPEC}\n{spec_toml(spec)}",
        style=inline_styles("style") + (files("evcot_cosim.sweep") / "templates" / "sweep.css").read_text(encoding="utf-8"),
        **inline_script(script, facts),
        packed=packed.text,
    )


def _mismatches(rows: Sequence[Mapping[str, Any]]) -> int | None:
    """Runs in which hardware and model differ; None where there is no hardware."""
    checked = [row["status"] for row in rows if row["engine"] in (RTL, FUZZ) and row["status"] in (DONE, MISMATCH)]
    return checked.count(MISMATCH) if checked else None


def _hours(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 120 else f"{seconds / 60:.0f} min" if seconds < 7200 else f"{seconds / 3600:.1f} h"


def _axes(groups: Sequence[Group], objectives: Sequence[tuple[str, str]]) -> tuple[list[dict[str, Any]], dict[str, Column]]:
    """Axes of the page and their columns: the fields in which configurations differ, then the objectives."""
    values: dict[str, list[Any]] = {}
    for name in ("engine", "hardware", "preset"):
        values[name] = [getattr(group, name) or None for group in groups]
    for name in sorted({name for group in groups for name in group.settings}):
        values[name] = [group.settings.get(name) for group in groups]
    values = {name: own for name, own in values.items() if len({repr(value) for value in own}) > 1}
    ways: dict[str, str] = {}
    for metric, way in objectives:
        values[metric], ways[metric] = [group.means[metric] for group in groups], way
    axes, columns = [], {}
    for i, (name, own) in enumerate(values.items()):
        known = [value for value in own if value is not None]
        axis: dict[str, Any] = {"name": name, "objective": ways.get(name)}
        if all(isinstance(value, int | float) and not isinstance(value, bool) for value in known):
            low, high = float(min(known)), float(max(known))
            step = (high - low) / _STEPS or 1.0
            packed = [0 if value is None else 1 + round((value - low) / step) for value in own]
        else:
            titles = sorted({_title(value) for value in known})
            low, high = 0.0, float(max(len(titles) - 1, 1))
            axis["titles"] = titles
            of = {title: k for k, title in enumerate(titles)}
            packed = [0 if value is None else 1 + of[_title(value)] for value in own]
        axes.append(axis | {"low": low, "high": high})
        columns[f"c{i}"] = Column(np.array(packed, np.int64))
    return axes, columns


def _title(value: Any) -> str:
    return value if isinstance(value, str) else canonical(value)


class _Chart(NamedTuple):
    """A response as shapes of an SVG: grid lines, band, mean, points with bars, labels below; of names, a row each."""

    name: str
    height: int
    words: str
    ticks: list[tuple[float, str]]
    area: str
    line: str
    dots: list[tuple[float, float, float, float, str]]
    labels: list[tuple[float, str, str]]
    rows: list[tuple[float, float, float, float, str, str]]


def _chart(name: str, levels: Sequence[Level]) -> _Chart:
    if levels[0].at is None:
        return _rows(name, levels)
    left, right, top, bottom = _ROOM
    low, high = min(level.low for level in levels), max(level.high for level in levels)
    size = high - low or abs(high) or 1.0
    digits = max(0, 2 - math.floor(math.log10(size)))

    def y(value: float) -> float:
        return round(bottom - (value - low) / size * (bottom - top), 1)

    places = [round(left + 8 + (level.at or 0.0) * (right - left - 16), 1) for level in levels]
    dots = [(x, y(level.mean), y(level.low), y(level.high), _told(level)) for x, level in zip(places, levels, strict=True)]
    band = [(x, dot[3]) for x, dot in zip(places, dots, strict=True)]
    band += [(x, dot[2]) for x, dot in reversed(list(zip(places, dots, strict=True)))]
    few = levels if len(levels) <= 4 else (levels[0], levels[-1])
    anchors = {id(levels[0]): "start", id(levels[-1]): "end"}
    labels = [
        (x, level.title[:22], anchors.get(id(level), "middle"))
        for x, level in zip(places, levels, strict=True)
        if any(level is each for each in few)
    ]
    best = max(levels, key=lambda level: level.mean)
    return _Chart(
        name,
        _HEIGHT,
        f"highest at {best.title}, {best.mean:.4g}",
        [(y(value), f"{value:.{digits}f}") for value in (low, (low + high) / 2, high)],
        " ".join(f"{x},{at}" for x, at in band) if len(levels) > 2 else "",
        " ".join(f"{dot[0]},{dot[1]}" for dot in dots),
        dots,
        labels,
        [],
    )


def _rows(name: str, levels: Sequence[Level]) -> _Chart:
    """The same of values without an order."""
    left, right, top, _ = _ROOM
    left += _NAMES
    low, high = min(level.low for level in levels), max(level.high for level in levels)
    size = high - low or abs(high) or 1.0

    def x(value: float) -> float:
        return round(left + 8 + (value - low) / size * (right - left - 16), 1)

    rows = [
        (top + _ROW * (i + 0.5), x(level.mean), x(level.low), x(level.high), level.title[:22], _told(level))
        for i, level in enumerate(levels)
    ]
    ends = [(x(low), f"{low:.3g}", "start"), (x(high), f"{high:.3g}", "end")]
    height = int(top + _ROW * len(levels) + 20)
    words = f"highest at {levels[0].title}, {levels[0].mean:.4g}"
    return _Chart(name, height, words, [], "", "", [], ends, rows)


def _told(level: Level) -> str:
    counted = f"{level.count:,} configuration{'' if level.count == 1 else 's'}"
    return f"{level.title}: {level.mean:.4g}, 95 % {level.low:.4g} to {level.high:.4g}, {counted}"

# SPDX-License-Identifier: Apache-2.0
"""Two runs of one recording side by side: how their settings and their results differ."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from evcot.errors import ConfigError
from evcot.events import Recording
from evcot.metrics.quality import Quality
from evcot.tracks.compare import Agreement, compare
from evcot.tracks.log import TrackLog

from ..lockstep.cosim import NEAR_PX
from ..lockstep.verdict import Verdict, verdict_from, verdict_of
from .facts import figure, flat, percent
from .material import PAIR, Comparison, Material, Side
from .truth import Truth

__all__ = ["Run", "comparison_of"]

_SETTINGS = ("hardware", "slots", "seed")  # of the summary, beside its config


@dataclass(frozen=True)
class Run:
    """One of the runs: its name, usually the folder's, its summary and its logs."""

    name: str
    summary: Mapping[str, Any]
    hardware: TrackLog
    software: TrackLog


def comparison_of(recording: Recording, a: Run, b: Run, truth: Truth | None) -> Material:
    """The material of a page that compares two runs of a recording.

    Raises:
        ConfigError: a run that a mismatch ended.
    """
    for run in (a, b):
        if "mismatch" in run.summary:
            raise ConfigError(f"{run.name}: ended in a mismatch of hardware and model: must be a complete run")
    verdicts = tuple(_verdict(recording, run) for run in (a, b))
    sides = [Side(PAIR[0], a.hardware), Side(PAIR[1], b.hardware)]
    if not _same(a.software, b.software):
        sides += [Side("software_a", a.software), Side("software_b", b.software)]
    agreement = _agreement(recording, a, b)
    comparison = Comparison(
        (a.name, b.name),
        tuple((verdict.grade.word, verdict.headline) for verdict in verdicts),  # type: ignore[arg-type]
        _settings(a.summary, b.summary),
        [row for side in ("hardware", "software") for row in _figures(side, *(v.figures[side] for v in verdicts))],
        _same(a.hardware, b.hardware),
    )
    summary = {"name": f"{a.name} and {b.name}", "agreement": agreement.to_dict()}
    return Material(recording, summary, tuple(sides), truth, comparison)


def _verdict(recording: Recording, run: Run) -> Verdict:
    stored = run.summary.get("verdict")
    if stored is not None:
        return verdict_from(stored)
    return verdict_of(recording, {"hardware": run.hardware, "software": run.software}, run.summary)


def _agreement(recording: Recording, a: Run, b: Run) -> Agreement:
    t_us = recording.events.t_us
    slots = [run.summary.get("config", {}).get("hardware", {}).get("slots", [{}])[0] for run in (a, b)]
    reach_px = max((slot["init_radix"] + slot["radix_th"] for slot in slots if slot), default=NEAR_PX)
    return compare(
        a.hardware, b.hardware, radius_px=float(reach_px), span_us=(int(t_us[0]), int(t_us[-1])) if len(t_us) else None
    )


def _same(one: TrackLog, other: TrackLog) -> bool:
    return np.array_equal(one.records, other.records) and np.array_equal(one.owner, other.owner)


def _settings(a: Mapping[str, Any], b: Mapping[str, Any]) -> list[tuple[str, str, str]]:
    first, second = (dict(flat(_settings_of(summary))) for summary in (a, b))
    names = [*first, *(name for name in second if name not in first)]
    return [
        (name, first.get(name, "–"), second.get(name, "–")) for name in names if first.get(name, "–") != second.get(name, "–")
    ]


def _settings_of(summary: Mapping[str, Any]) -> dict[str, Any]:
    return {name: summary[name] for name in _SETTINGS if name in summary} | dict(summary.get("config", {}))


def _figures(side: str, a: Quality, b: Quality) -> list[tuple[str, str, str]]:
    rows: tuple[tuple[str, Callable[[Quality], str]], ...] = (
        ("tracks", lambda q: figure(q.tracks)),
        ("alive on average", lambda q: figure(q.alive_mean)),
        ("tracks per object alive", lambda q: figure(q.tracks_per_alive, 1)),
        ("short tracks", lambda q: f"{q.short:,}" + (f" ({percent(q.short / q.lives)})" if q.lives else "")),
        ("events in lasting tracks", lambda q: percent(q.owned_fraction)),
        ("isolated events filtered out", lambda q: percent(q.isolated_dropped_fraction)),
        ("isolated events in tracks", lambda q: percent(q.isolated_owned_fraction)),
        ("tracks mostly of isolated events", lambda q: figure(q.noise_tracks)),
    )
    return [(f"{side}: {what}", text(a), text(b)) for what, text in rows]

# SPDX-License-Identifier: Apache-2.0
"""Two runs of one recording side by side: how their settings and their results differ."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from evcot.errors import ConfigError
from evcot.events import Recording
from evcot.metrics.quality import Quality
from evcot.tracks.compare import Agreement, compare
from evcot.tracks.log import TrackLog

from ..lockstep.cosim import NEAR_PX
from ..lockstep.truth import Truth
from ..lockstep.verdict import Verdict, verdict_by, verdict_of
from .facts import METRICS, figure, flat
from .material import PAIR, Difference, Material, RunComparison, Side

__all__ = ["ComparedRun", "comparison_of"]

_SETTINGS = ("hardware", "slots", "seed")  # of the summary, beside its config


@dataclass(frozen=True)
class ComparedRun:
    """One of the runs: its name, usually the folder's, its folder as typed, its summary, and the log of its hardware."""

    name: str
    folder: str
    summary: Mapping[str, Any]
    hardware: TrackLog


def comparison_of(recording: Recording, a: ComparedRun, b: ComparedRun, truth: Truth | None) -> Material:
    """The material of a page that compares two runs of a recording.

    Raises:
        ConfigError: a run that a mismatch ended.
    """
    for run in (a, b):
        if "mismatch" in run.summary:
            raise ConfigError(f"{run.name}: ended in a mismatch of hardware and model: must be a complete run")
    sides = tuple(Side(name, run.hardware, run.folder) for name, run in zip(PAIR, (a, b), strict=True))
    summary = {"name": f"{a.name} and {b.name}", "agreement": _agreement(recording, a, b).to_dict()}
    material = Material(recording, summary, sides, truth)
    scored = material.truth.figures({side.name: side.log for side in sides}) if material.truth else None
    verdicts = [_verdict(recording, run, scored, name) for run, name in zip((a, b), PAIR, strict=True)]
    settings = [dict(flat(_settings_of(run.summary))) for run in (a, b)]
    names = list(dict.fromkeys([*settings[0], *settings[1]]))
    rows = [(name, settings[0].get(name, "–"), settings[1].get(name, "–")) for name in names]
    figures = [*_scores(scored), *_qualities(verdicts), *_speeds(a.summary, b.summary)]
    comparison = RunComparison(
        (a.name, b.name),
        _headline(verdicts, scored),
        figures,
        [row for row in rows if row[1] != row[2]],
        len(rows),
        (a.summary.get("command", ""), b.summary.get("command", "")),
        np.array_equal(a.hardware.records, b.hardware.records) and np.array_equal(a.hardware.owner, b.hardware.owner),
    )
    return Material(recording, summary | {"truth": scored}, sides, truth, comparison)


def _verdict(recording: Recording, run: ComparedRun, scored: Mapping[str, Any] | None, name: str) -> Verdict:
    """The verdict of a run's hardware, with the truth where there is one."""
    known = dict(run.summary)
    known.pop("truth", None)
    if scored is not None:
        known["truth"] = dict(scored) | {"scores": {"hardware": scored["scores"][name]}}
    stored = run.summary.get("verdict")
    if stored is not None and "hardware" in stored["figures"]:
        return verdict_by({"hardware": Quality(**stored["figures"]["hardware"])}, known)
    return verdict_of(recording, {"hardware": run.hardware}, known)


def _headline(verdicts: list[Verdict], scored: Mapping[str, Any] | None) -> str:
    if scored is not None:
        a, b = (round(scored["scores"][name]["hota"], 3) for name in PAIR)
    else:
        a, b = (float(-verdict.grade) for verdict in verdicts)
    return "A is better" if a > b else "B is better" if b > a else "A and B are as good"


def _agreement(recording: Recording, a: ComparedRun, b: ComparedRun) -> Agreement:
    t_us = recording.events.t_us
    slots = [run.summary.get("config", {}).get("hardware", {}).get("slots", [{}])[0] for run in (a, b)]
    reach_px = max((slot["init_radix"] + slot["radix_th"] for slot in slots if slot), default=NEAR_PX)
    return compare(
        a.hardware, b.hardware, radius_px=float(reach_px), span_us=(int(t_us[0]), int(t_us[-1])) if len(t_us) else None
    )


def _settings_of(summary: Mapping[str, Any]) -> dict[str, Any]:
    return {name: summary[name] for name in _SETTINGS if name in summary} | dict(summary.get("config", {}))


def _difference(title: str, a: float | None, b: float | None, digits: int, better: int) -> Difference:
    """A row of the comparison; `better`: 1 where more is better, -1 where less is, 0 where neither is."""
    texts = figure(a, digits), figure(b, digits)
    if a is None or b is None or texts[0] == texts[1]:
        return Difference(title, *texts, "" if texts[0] == texts[1] else "–", "")
    apart = f"{b - a:+,.{digits}f}".replace("-", "−")
    return Difference(title, *texts, apart, PAIR[(b - a) * better > 0] if better else "")


def _scores(scored: Mapping[str, Any] | None) -> list[Difference]:
    if scored is None:
        return []
    a, b = (scored["scores"][name] for name in PAIR)
    return [_difference(metric.title, a[metric.name], b[metric.name], metric.digits, metric.better) for metric in METRICS]


def _qualities(verdicts: list[Verdict]) -> list[Difference]:
    a, b = (verdict.figures["hardware"] for verdict in verdicts)
    rows: tuple[tuple[str, str, float, int, int], ...] = (
        ("Tracks", "tracks", 1, 0, 0),
        ("Tracks at a time", "alive_mean", 1, 1, 0),
        ("Short tracks", "short", 1, 0, -1),
        ("Tracks that merged at birth", "absorbed", 1, 0, -1),
        ("Events in lasting tracks, %", "owned_fraction", 100, 0, 1),
        ("Isolated events filtered out, %", "isolated_dropped_fraction", 100, 0, 1),
        ("Isolated events in tracks, %", "isolated_owned_fraction", 100, 0, -1),
        ("Tracks mostly of isolated events", "noise_tracks", 1, 0, -1),
    )
    return [
        _difference(title, _times(getattr(a, name), unit), _times(getattr(b, name), unit), digits, better)
        for title, name, unit, digits, better in rows
    ]


def _speeds(a: Mapping[str, Any], b: Mapping[str, Any]) -> list[Difference]:
    first, second = ((summary.get("latency_clocks") or {}).get("median") for summary in (a, b))
    return [
        _difference("Clocks per event", a.get("cycles_per_event"), b.get("cycles_per_event"), 2, -1),
        _difference("Clocks from event to record, median", first, second, 0, -1),
    ]


def _times(value: float | None, unit: float) -> float | None:
    return None if value is None else value * unit

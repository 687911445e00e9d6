# SPDX-License-Identifier: Apache-2.0
"""The tables of a report: rows of labels and formatted figures; unknown figures are marked as such."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..lockstep.verdict import Grade, Line, Verdict

__all__ = [
    "METRICS", "Check", "Metric", "agreement_rows", "checks_of", "figure", "flat", "headline", "latency_bars", "percent",
    "run_rows", "score_rows",
]  # fmt: skip

_UNKNOWN = "–"
_BARS = 16  # of a histogram of clocks, at most


class Check(NamedTuple):
    """One check of the verdict: its one-word name, its grade, and its lines, the decisive side's first."""

    name: str
    grade: str
    lines: list[Line]


def checks_of(verdict: Verdict, decisive: str) -> list[Check]:
    """The checks of a verdict in their order; a check is graded by the lines of the decisive side, and of the run."""
    found: dict[str, list[Line]] = {}
    for line in sorted(verdict.lines, key=lambda line: line.side not in ("", decisive)):
        found.setdefault("exact" if line.about == "exactness" else line.about, []).append(line)
    order = dict.fromkeys("exact" if line.about == "exactness" else line.about for line in verdict.lines)
    return [Check(name, found[name][0].grade.word, found[name]) for name in order]


def headline(verdict: Verdict, summary: Mapping[str, Any], tracked: bool) -> str:
    """The verdict in a few words."""
    if "mismatch" in summary or summary.get("exact") is False:
        return "Hardware ≠ model"
    if any(line.about == "length" for line in verdict.lines):
        return "Too short to judge"
    if not tracked:
        return "Nothing was tracked"
    return {Grade.GOOD: "Tracks look sound", Grade.FAIR: "Tracks are usable", Grade.POOR: "Tracks are poor"}[verdict.grade]


def agreement_rows(summary: Mapping[str, Any]) -> list[tuple[str, str, str, str]]:
    """Rows of (label, hardware, software, agreement)."""
    a = summary.get("agreement")
    if not a:
        return []
    return [
        ("Lifetimes", f"{a['tracks_hardware']:,}", f"{a['tracks_software']:,}",
         f"{a['tracks_paired']:,} paired, {a['tracks_corresponding']:,} of them with the same birth and end"),
        ("Merges", f"{a['merges_hardware']:,}", f"{a['merges_software']:,}", f"{a['merges_paired']:,} seen by both"),
        ("Those that could be the same", f"{a['merges_comparable_hardware']:,}", f"{a['merges_comparable_software']:,}", ""),
        ("Clusters alive, mean", figure(a["alive_mean_hardware"]), figure(a["alive_mean_software"]),
         f"the same number {percent(a['alive_equal_fraction'])} of the time"),
        ("Time with a partner", percent(a["paired_fraction_hardware"]), percent(a["paired_fraction_software"]),
         f"within {a['radius_px']:g} px of each other"),
        ("Distance of partners", "", "",
         "no partners" if a["distance_median_px"] is None
         else f"{figure(a['distance_median_px'])} px median, {figure(a['distance_p90_px'])} px at 90 %"),
    ]  # fmt: skip


class Metric(NamedTuple):
    """A score: its name, its field in `Scores`, digits, 1 where more is better and -1 where less is, and its meaning."""

    title: str
    name: str
    digits: int
    better: int
    meaning: str


METRICS = (
    Metric("HOTA", "hota", 3, 1, "found and kept, together"),
    Metric("DetA", "deta", 3, 1, "objects found"),
    Metric("AssA", "assa", 3, 1, "each kept as one track"),
    Metric("LocA", "loca", 3, 1, "placed exactly"),
    Metric("MOTA", "mota", 3, 1, "1 − misses, false outputs, switches"),
    Metric("IDF1", "idf1", 3, 1, "outputs under the right identity"),
    Metric("Switches", "idsw", 0, -1, "an object goes on under another track"),
    Metric("Interruptions", "frag", 0, -1, "an object without a track for a while"),
    Metric("Mostly tracked", "mt", 0, 1, "objects, for over 80 % of their time"),
    Metric("Mostly lost", "ml", 0, -1, "objects, tracked for under 20 % of their time"),
    Metric("Position error, median", "position_error_px_median", 2, -1, "px"),
    Metric("Position error, 90 %", "position_error_px_p90", 2, -1, "px"),
    Metric("Velocity error, median", "velocity_error_median", 1, -1, "px/s, of the displacement over 50 ms"),
    Metric("Stated velocity's error, median", "stated_velocity_error_median", 1, -1, "px/s, of what the tracker states"),
    Metric("Stated direction, median error", "stated_angle_error_deg_median", 1, -1, "degrees, against 300 ms of displacement"),
    Metric("Stated direction wrong", "stated_angle_over_45_deg_fraction", 3, -1, "share over 45 degrees off the displacement"),
    Metric("Stated velocity's relative error", "stated_relative_error_median", 3, -1, "median, against 300 ms of displacement"),
    Metric("Latency", "latency_ms", 0, -1, "ms by which tracks lag behind their objects"),
)


class ScoreRow(NamedTuple):
    """A metric, its values by side, as text, and which of them are best: none where all look the same."""

    metric: Metric
    values: list[float | None]
    texts: list[str]
    best: list[bool]


def score_rows(scores: Sequence[Mapping[str, Any]]) -> list[ScoreRow]:
    """Rows of the scores of some sides, as `Scores.to_dict` gives them."""
    rows = []
    for metric in METRICS:
        values = [of[metric.name] for of in scores]
        texts = [figure(value, metric.digits) for value in values]
        known = [round(value, metric.digits) * metric.better for value in values if value is not None]
        apart = len(set(texts)) > 1 and len(known) > 1
        best = [apart and value is not None and round(value, metric.digits) * metric.better == max(known) for value in values]
        if known:
            rows.append(ScoreRow(metric, values, texts, best))
    return rows


def run_rows(summary: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Setup and speed of the run, as rows of (label, value)."""
    rows: list[tuple[str, str]] = []
    for title, name, form in (
        ("Hardware module", "hardware", "{}"),
        ("Tracker slots", "slots", "{}"),
        ("Seed of the stalls", "seed", "{}"),
        ("Clocks", "cycles", "{:,}"),
        ("Clocks per event", "cycles_per_event", "{:.3f}"),
        ("Lock-step", "events_per_s", "{:,.0f} events/s"),
        ("Lock-step against real time", "realtime_factor", "{:.1f} ×"),
        ("Software tracker", "software_events_per_s", "{:,.0f} events/s"),
    ):
        if name in summary:
            rows.append((title, "none" if summary[name] is None else form.format(summary[name])))
    if summary.get("filters"):
        rows.append(
            ("Filters", f"{', '.join(summary['filters'])}: {percent(summary['filtered_fraction'])} of the events removed")
        )
    return rows


def flat(values: Mapping[str, Any], prefix: str = "") -> list[tuple[str, str]]:
    """Nested settings as (dotted name, value); identical slots are listed once."""
    rows: list[tuple[str, str]] = []
    for name, value in values.items():
        if isinstance(value, Mapping):
            rows += flat(value, f"{prefix}{name}.")
        elif name == "slots" and isinstance(value, (list, tuple)) and value:
            alike = all(slot == value[0] for slot in value)
            shown = {"slot[all]": value[0]} if alike else {f"slot[{i}]": slot for i, slot in enumerate(value)}
            rows += flat(shown, prefix)
        else:
            rows.append((f"{prefix}{name}", _text(value)))
    return rows


def _text(value: Any) -> str:
    """A setting as text, the same before and after a conversion through JSON."""
    if value is None:
        return "none"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, (list, tuple)):
        return ", ".join(_text(entry) for entry in value) or "none"
    return str(value)


class Bar(NamedTuple):
    """A bar of a histogram: its range as text, its height, and the share of all up to its end."""

    text: str
    records: int
    running: float


def latency_bars(summary: Mapping[str, Any]) -> list[Bar]:
    """Clocks from an event's acceptance to its record, in at most 16 bars."""
    histogram = (summary.get("latency_clocks") or {}).get("histogram")
    if not histogram:
        return []
    clocks, counts = np.array(histogram, np.int64).T
    edges = (
        clocks if len(clocks) <= _BARS else np.unique(np.geomspace(max(int(clocks[0]), 1), int(clocks[-1]), _BARS).astype(int))
    )
    edges[0] = clocks[0]
    bar = np.searchsorted(edges, clocks, "right") - 1
    sums = np.bincount(bar, weights=counts, minlength=len(edges)).astype(np.int64)
    running = np.cumsum(sums) / sums.sum()
    ends = np.append(edges[1:] - 1, clocks[-1])
    if len(clocks) <= _BARS:
        ends = edges
    texts = [str(a) if a == b else f"{a}–{b}" for a, b in zip(edges.tolist(), ends.tolist(), strict=True)]
    return [Bar(*row) for row in zip(texts, sums.tolist(), running.tolist(), strict=True)]


def figure(value: float | int | None, digits: int = 2) -> str:
    """A number for a table."""
    if value is None:
        return _UNKNOWN
    return f"{value:,}" if isinstance(value, int) else f"{value:,.{digits}f}".replace("-", "−")


def percent(value: float | None) -> str:
    """A share for a table."""
    return _UNKNOWN if value is None else f"{100 * value:.0f} %"

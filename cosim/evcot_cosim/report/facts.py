# SPDX-License-Identifier: Apache-2.0
"""The tables of a report: rows of labels and formatted figures; unknown figures are marked as such."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from evcot.metrics import Scores
from evcot.tracks.timeline import merges

from .material import Material

__all__ = ["Differences", "Place", "agreement_rows", "differences", "flat", "latency_bars", "run_rows", "score_rows"]

_UNKNOWN = "–"


@dataclass(frozen=True)
class Place:
    """A place in the playback: microseconds after the first event, the side and track to select, and a text."""

    at_us: int
    side: str
    track: str
    text: str


@dataclass(frozen=True)
class Differences:
    """Differences of hardware and software, that is merges and lifetimes without a partner; and merges of both."""

    merges: list[Place]
    lives: list[Place]
    joint_merges: list[Place]


def differences(material: Material) -> Differences | None:
    """The differences listed in the agreement section, those of the pair; None without an agreement."""
    agreement = material.summary.get("agreement")
    if not agreement:
        return None
    begin_us = material.span_us[0]
    lone_merges, lone_lives, joint = [], [], []
    partners = {pair["hardware_id"]: pair for pair in agreement["merges"]}
    for side in material.sides:
        if side.name not in material.pair:
            continue
        first = side.name == material.pair[0]
        key = "hardware" if first else "software"
        alone = set(agreement[f"merges_unpaired_{key}"])
        for row in merges(side.log):
            at_us, track, into = int(row["t_us"]) - begin_us, int(row["track_id"]), int(row["other_id"])
            text = f"into {into}"
            if track in alone:
                lone_merges.append(Place(at_us, side.name, str(track), text))
            elif first and track in partners:
                pair = partners[track]
                late_ms, apart_px = pair["time_difference_us"] / 1e3, pair["distance_px"]
                late = f"{material.pair[1]} {pair['software_id']} {late_ms:+.1f} ms, {apart_px:.1f} px"
                joint.append(Place(at_us, side.name, str(track), f"{text}; {late}"))
        births = _births(material, side.name)
        for track in agreement[f"tracks_unpaired_{key}"]:
            if track in births:
                lone_lives.append(Place(births[track] - begin_us, side.name, str(track), ""))
    for places in (lone_merges, lone_lives, joint):
        places.sort(key=lambda place: place.at_us)
    return Differences(lone_merges, lone_lives, joint)


def _births(material: Material, name: str) -> dict[int, int]:
    """Time of birth of each track of a side."""
    log = next(side.log for side in material.sides if side.name == name)
    born = log.records[log.records["kind"] == 0]
    return dict(zip(born["track_id"].tolist(), born["t_us"].tolist(), strict=True))


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


_SCORES = (
    ("HOTA", "hota", "detection and association together"),
    ("DetA", "deta", "how well objects were found"),
    ("AssA", "assa", "how well they kept one track"),
    ("LocA", "loca", "how well the positions of matched pairs fit"),
    ("MOTA", "mota", "1 minus the shares of misses, false outputs and switches"),
    ("MOTP", "motp", "similarity of matched pairs"),
    ("IDF1", "idf1", "share of outputs under the right identity"),
    ("Switches of identity", "idsw", "an object goes on under another track"),
    ("Interruptions", "frag", "an object without a track for a while"),
    ("Mostly tracked objects", "mt", "for more than 80 % of their time"),
    ("Mostly lost objects", "ml", "tracked for less than 20 % of their time"),
    ("Position error, median (px)", "position_error_px_median", ""),
    ("Position error, 90 % (px)", "position_error_px_p90", ""),
    ("Velocity error, median (px/s)", "velocity_error_median", "of a track's displacement over 50 ms"),
    ("Stated velocity's error, median (px/s)", "stated_velocity_error_median", "of the velocity that the tracker states"),
    ("Latency (ms)", "latency_ms", "shift in time after which tracks fit their objects best"),
)


def score_rows(scores: Sequence[Scores]) -> list[tuple[str, str, list[str]]]:
    """Rows of (score, meaning, one figure per side)."""
    digits = {"latency_ms": 0}
    return [
        (title, meaning, [figure(getattr(of, name), digits.get(name, 3)) for of in scores]) for title, name, meaning in _SCORES
    ]


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


@dataclass(frozen=True)
class Bars:
    """A histogram: label and height of each bar, and its quantiles as text."""

    bars: list[tuple[str, int]]
    most: int
    words: str


def latency_bars(summary: Mapping[str, Any], most_bars: int = 24) -> Bars | None:
    """Clocks from an event's acceptance to its record, in at most `most_bars` bars; None if not measured.

    Where there are more than that, the last bar has the slowest per cent: a few of them would make all others one bar.
    """
    latency = summary.get("latency_clocks")
    if not latency or not latency["histogram"]:
        return None
    bars = [(str(clocks), int(count)) for clocks, count in latency["histogram"]]
    if len(bars) > most_bars:
        clocks, counts = np.array(latency["histogram"], np.int64).T
        low, high = int(clocks[0]), max(int(latency["p99"]), int(clocks[0]))
        step = -(-(high - low + 1) // (most_bars - 1))
        slow = clocks > high
        sums = np.bincount((clocks[~slow] - low) // step, weights=counts[~slow]).astype(np.int64).tolist()
        ranges = [(low + i * step, min(low + (i + 1) * step - 1, high)) for i in range(len(sums))]
        bars = [(str(a) if a == b else f"{a}–{b}", count) for (a, b), count in zip(ranges, sums, strict=True)]
        if slow.any():
            bars.append((f"{high + 1}–{clocks[-1]}", int(counts[slow].sum())))
    words = f"median {latency['median']} clocks, 99 % within {latency['p99']}, at most {latency['max']}"
    return Bars(bars, max(count for _, count in bars), words)


def figure(value: float | int | None, digits: int = 2) -> str:
    """A number for a table."""
    if value is None:
        return _UNKNOWN
    return f"{value:,}" if isinstance(value, int) else f"{value:,.{digits}f}"


def percent(value: float | None) -> str:
    """A share for a table."""
    return _UNKNOWN if value is None else f"{100 * value:.0f} %"

# SPDX-License-Identifier: Apache-2.0
"""summary.json and the short table: all figures of a run, and everything needed to repeat it."""

from __future__ import annotations

import importlib.metadata
import json
import platform
import textwrap
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import evcot
from evcot.errors import ConfigError
from evcot.events import Recording
from evcot.metrics.quality import Quality
from evcot.outputs import written_aside
from evcot.recordings.formats.source import Sensor
from evcot.trackers.config import RunConfig
from evcot.tracks.compare import Agreement, Comparison
from evcot.tracks.log import Kind, TrackLog
from evcot.tracks.log_parts import life_lengths
from evcot.tracks.tally import Tally
from evcot.tracks.timeline import lifetimes

from ..rtl.toolchain import find_toolchain
from .cosim import CosimRun, LongRun, Measured
from .mismatch import Mismatch
from .run_file import SUMMARY, made_again
from .truth import Truth
from .verdict import Verdict, verdict_by, verdict_of

__all__ = [
    "SUMMARY",
    "read_summary",
    "summarise",
    "summarise_long",
    "summarise_mismatch",
    "table",
    "verdict_lines",
    "write_summary",
]

_LATENCY = ("median", "p99", "max", "histogram")
_LEAST_ROOM = 30  # characters of a text on a line, however narrow the terminal is


def summarise(run: CosimRun, command: str, truth: Truth | None = None) -> dict[str, Any]:
    """All figures of a run as plain values; undefined ones are None.

    Args:
        truth: the ground truth within the time of the events.
    """
    recording = run.recording
    logs = {"hardware": run.hardware, "model": run.model, "software": run.software}
    tallies = {}
    for name, log in logs.items():
        tallies[name] = Tally()
        tallies[name].add(log.records, log.owner)
    end_us = int(recording.events.t_us[-1])
    summary = _figures(
        run, recording.name, (recording.width, recording.height), recording.duration_us, tallies,
        {name: life_lengths(lifetimes(log, end_us)) for name, log in logs.items()}, run.agreement,
        exact=_identical(run.hardware, run.model),
    )  # fmt: skip
    judged = {"hardware": run.hardware, "software": run.software}
    summary |= _provenance(command) | ({"truth": truth.figures(judged)} if truth else {})
    return summary | {"verdict": verdict_of(recording, judged, summary).to_dict()}


def summarise_long(run: LongRun, comparison: Comparison, figures: Mapping[str, Quality], command: str) -> dict[str, Any]:
    """As `summarise`, of a run whose logs are in files.

    Args:
        comparison, figures: hardware against software, and the quality of both, of all parts.
    """
    tallies = {"hardware": run.hardware.tally, "software": run.software.tally}
    lengths = {name: life_lengths(own) for name, own in zip(tallies, comparison.lives, strict=True)}
    duration_us, agreement = run.end_us - run.begin_us, comparison.agreement()
    # Every chunk was compared.
    summary = _figures(run, run.name, run.sensor, duration_us, tallies, lengths, agreement, exact=True) | _provenance(command)
    return summary | {"verdict": verdict_by(figures, summary).to_dict()}


def _figures(
    run: Measured,
    name: str,
    sensor: Sensor,
    duration_us: int,
    tallies: Mapping[str, Tally],
    lengths: Mapping[str, Any],
    agreement: Agreement,
    *,
    exact: bool,
) -> dict[str, Any]:
    """What a run was, and what was counted."""
    hardware, recording_s = tallies["hardware"], duration_us / 1e6
    events = hardware.events
    return {
        "name": name,
        "exact": exact,
        "events": events,
        "records": sum(hardware.kinds.values()),
        "recording_s": recording_s,
        "wall_s": run.wall_s,
        "realtime_factor": recording_s / run.wall_s,
        "events_per_s": events / run.wall_s,
        "software_events_per_s": events / run.software_s,
        "cycles": run.cycles,
        "cycles_per_event": run.cycles / events,
        "latency_clocks": _latency(run.latency),
        "filters": [which.name.lower() for which in run.config.filters.filters],
        "filtered_fraction": hardware.filtered / events,
        "owned_fraction": {side: tally.owned / events for side, tally in tallies.items()},
        "slots": run.config.hardware.shape.n_slots,
        "births": {side: tally.kinds[Kind.BORN] for side, tally in tallies.items()},
        "merges": {side: tally.kinds[Kind.MERGED] for side, tally in tallies.items()},
        "lifetimes": dict(lengths),
        "agreement": agreement.to_dict(),
        "sensor": {"width": sensor[0], "height": sensor[1]},
        "hardware": run.config.hardware.module,
        "seed": run.seed,
        "config": run.config.to_dict(),
        "build": {"cached": run.build.cached, "build_s": run.build.build_s, "parameters": dict(run.build.parameters)},
    }


def summarise_mismatch(found: Mismatch, recording: Recording, config: RunConfig, command: str) -> dict[str, Any]:
    """The summary of a run that ended with a mismatch: not exact, its location, and how to repeat it."""
    return {
        "name": recording.name,
        "exact": False,
        "mismatch": found.to_dict(),
        "events": len(recording.events),
        "sensor": {"width": recording.width, "height": recording.height},
        "config": config.to_dict(),
        **_provenance(command),
    }


def _provenance(command: str) -> dict[str, Any]:
    tools = find_toolchain()
    return {
        "command": command,
        "versions": {
            "evcot": evcot.__version__,
            "python": platform.python_version(),
            "verilator": tools.version,
            "compiler": tools.compiler_version,
            **{name: importlib.metadata.version(name) for name in ("numpy", "numba", "pyverilator-mm")},
        },
    }


def _identical(a: TrackLog, b: TrackLog) -> bool:
    return np.array_equal(a.owner, b.owner) and np.array_equal(a.records, b.records)


def _latency(counts: NDArray[np.int64]) -> dict[str, Any]:
    """Clocks from an event's acceptance to its records: quantiles, and a histogram of [clocks, records]."""
    clocks = np.flatnonzero(counts)
    so_far = np.cumsum(counts[clocks])
    median, p99 = (int(clocks[np.searchsorted(so_far, share * so_far[-1])]) if len(clocks) else None for share in (0.5, 0.99))
    return {
        "median": median,
        "p99": p99,
        "max": int(clocks[-1]) if len(clocks) else None,
        "histogram": np.column_stack((clocks, counts[clocks])).tolist(),
    }


def write_summary(summary: dict[str, Any], path: Path) -> None:
    """Write the summary as JSON; NaN and infinity are refused."""
    with written_aside(path) as file:
        for text in json.JSONEncoder(indent=2, allow_nan=False).iterencode(summary):
            file.write(text.encode())
        file.write(b"\n")


def read_summary(path: Path) -> dict[str, Any]:
    """Read what `write_summary` wrote.

    Raises:
        ConfigError: it cannot be read, is not a summary, or lacks figures that this version has.
    """
    try:
        summary = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read: {error.strerror or error}") from error
    except ValueError as error:
        raise ConfigError(f"{path}: is not JSON: {error}") from error
    if not isinstance(summary, dict):
        raise ConfigError(f"{path}: must hold an object, as `evcot cosim` writes it")
    if isinstance(summary.get("agreement"), dict):
        _count(summary["agreement"])
    if lacking := _lacking(summary):
        more = f" and {len(lacking) - 1} more" if len(lacking) > 1 else ""
        raise ConfigError(f"{path}: lacks {lacking[0]}{more}: {made_again(path.parent)}")
    return summary


def _lacking(summary: Mapping[str, Any]) -> list[str]:
    """The dotted names of figures that a section must have, and has not; sections themselves may be missing."""
    wanted = {"latency_clocks": _LATENCY, "agreement": _names(Agreement), "verdict": _names(Verdict)}
    sections = [(section, summary[section], names) for section, names in wanted.items() if summary.get(section) is not None]
    figures = verdict.get("figures") if isinstance(verdict := summary.get("verdict"), dict) else None
    if isinstance(figures, dict):
        sides = {*figures, *(("hardware", "software") if summary.get("agreement") else ())}
        sections += [(f"verdict.figures.{side}", figures.get(side), _names(Quality)) for side in sorted(sides)]
    lacking = ["filtered_fraction"] if summary.get("filters") and "filtered_fraction" not in summary else []
    for section, values, names in sections:
        lacking += [f"{section}.{name}" for name in names if name not in values] if isinstance(values, dict) else [section]
    return lacking


def _names(of: type) -> tuple[str, ...]:
    return tuple(field.name for field in fields(of))


def _count(agreement: dict[str, Any]) -> None:
    """Add what evcot 0.1.0 did not count of the pairs, ids and merges that it listed."""
    tracks, same = agreement.get("tracks", ()), agreement.get("merges", ())
    agreement.setdefault("tracks_paired", len(tracks))
    agreement.setdefault("merges_paired", len(same))
    for side in ("hardware", "software"):
        paired = {track[f"{side}_id"] for track in tracks}
        others = sum(track_id in paired for track_id in agreement.get(f"merges_unpaired_{side}", ()))
        agreement.setdefault(f"merges_comparable_{side}", len(same) + others)


def table(summary: dict[str, Any]) -> list[tuple[str, str]]:
    """The short table printed after a run, as (label, value)."""
    agreement = summary["agreement"]
    filters = [("filtered out", f"{_percent(summary['filtered_fraction'])} of the events, by {', '.join(summary['filters'])}")]
    records = f"{summary['records']:,} records and" if summary["records"] else "no record, and"
    exact = f"exact: {records} every event's owner" if summary["exact"] else "NO"
    return [
        ("events", f"{summary['events']:,} in {summary['recording_s']:.3f} s"),
        *(filters if summary["filters"] else []),
        ("hardware = model", exact),
        ("cycles", f"{summary['cycles']:,} ({summary['cycles_per_event']:.3f} per event, {summary['slots']} slots)"),
        ("lock-step rate", f"{summary['events_per_s'] / 1e6:.2f} M events/s, {summary['realtime_factor']:.3g} x real time"),
        ("software rate", f"{summary['software_events_per_s'] / 1e6:.1f} M events/s"),
        ("", "hardware | software"),
        ("births", f"{summary['births']['hardware']} | {summary['births']['software']}"),
        ("merges", f"{summary['merges']['hardware']} | {summary['merges']['software']}, {agreement['merges_paired']} the same"),
        (
            "lifetimes",
            f"{agreement['tracks_hardware']} | {agreement['tracks_software']}, {agreement['tracks_paired']} paired, "
            f"{agreement['tracks_corresponding']} with the same birth and end",
        ),
        (
            "alive",
            f"{_figure(agreement['alive_mean_hardware'])} | {_figure(agreement['alive_mean_software'])} on average, "
            f"the same number {_percent(agreement['alive_equal_fraction'])} of the time",
        ),
        ("distance of pairs", _distance(agreement)),
    ]


def _distance(agreement: dict[str, Any]) -> str:
    if agreement["distance_median_px"] is None:
        return "no pair"
    return f"{agreement['distance_median_px']:.2f} px median, {agreement['distance_p90_px']:.2f} px at 90 %"


def verdict_lines(verdict: Verdict, columns: int | None = None) -> list[str]:
    """The verdict as text: the headline, then each finding, and what to do about it.

    Args:
        columns: width of the terminal, to which the texts are wrapped; None: one line each.
    """
    width = max(len(f"{line.about} {line.side}".strip()) for line in verdict.lines) if verdict.lines else 0
    lines = [f"verdict: {verdict.headline}"]
    for line in verdict.lines:
        lines += _wrapped(f"  {line.grade.word:4}  {f'{line.about} {line.side}'.strip():{width}}  ", line.text, columns)
        if line.advice:
            lines += _wrapped(f"  {'':4}  {'':{width}}  -> ", line.advice, columns)
    return lines


def _wrapped(head: str, text: str, columns: int | None) -> list[str]:
    if columns is None:
        return [head + text]
    room = max(columns - len(head), _LEAST_ROOM)
    first, *others = textwrap.wrap(text, room, break_long_words=False, break_on_hyphens=False) or [""]
    return [head + first, *(" " * len(head) + other for other in others)]


def _figure(value: float | None) -> str:
    return "none" if value is None else f"{value:.2f}"


def _percent(value: float | None) -> str:
    return "none" if value is None else f"{100 * value:.0f} %"

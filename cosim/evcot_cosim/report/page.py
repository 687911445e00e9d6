# SPDX-License-Identifier: Apache-2.0
"""The HTML file: rendered templates with inlined style sheet and modules, without external resources."""

from __future__ import annotations

import base64
import hashlib
import json
import re
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Template

from evcot.metrics.quality import Quality
from evcot.outputs import written_aside
from evcot.templating import html_templates
from evcot.tracks.log import Kind

from ..lockstep.verdict import ENOUGH_S, Verdict, verdict_by, verdict_of
from .collect import Collected, collect
from .facts import checks_of, flat, headline, latency_bars, percent, run_rows, score_rows
from .heat_maps import heat_maps
from .material import Material
from .objects import TRUTH
from .pack import EVENTS_MAX, LIVES_MAX, RECORDS_MAX, Packed, pack

__all__ = ["MODULES", "SCREEN", "hash_of", "inline_modules", "inline_script", "inline_styles", "render", "write_report"]

# What the pages of a run and of a live tracker share: the picture, the colours, and the window's panes.
SCREEN = ("surface", "stage", "theme", "panes")
# In the order in which they need each other.
MODULES = ("columns", *SCREEN, "tracks", "clock", "timeline", "list", "agreement", "main")

_TEXT_MAX = 3_700_000  # characters of packed columns
_GOING = 0.15  # of the recording: after that there is something to see
_PLAYING_S = 10  # that the whole recording takes at first, at least
_SPEEDS = (0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0)
_PEAK_US = 10_000  # over which the highest event rate is measured
_IMPORT = re.compile(r"^import\s[^;]*;\n", re.MULTILINE)
_EXPORT = re.compile(r"^export (?=async |class |const |function |let )", re.MULTILINE)


def write_report(material: Material, path: Path, *, force: bool = False, events_max: int = EVENTS_MAX) -> None:
    """Write the report, with at most `events_max` events; the file appears under its name only when it is complete.

    Raises:
        OutputError: the file exists (without `force`), or cannot be written.
        TrackLogError: log and truth have different time bases.
    """
    text = render(material, events_max)
    with written_aside(path, force=force) as file:
        file.write(text.encode())


def render(material: Material, events_max: int = EVENTS_MAX) -> str:
    """The page as text, with at most so many events."""
    collected, packed = _fitting(material, events_max)
    scored = _scored(material)
    known = {**material.summary, "truth": scored} if scored else material.summary
    verdict = _verdict(material, known)
    decisive = "hardware" if "hardware" in verdict.figures else next(iter(verdict.figures), "")
    engines = [side for side in collected.facts["sides"] if side["name"] != TRUTH]
    tracked = any(side["ids"] for side in engines)
    judged = tracked and not any(line.about == "length" for line in verdict.lines)
    score_sides = [side for side in engines if scored and side["name"] in scored["scores"]]
    context: dict[str, Any] = {
        "title": material.summary.get("name", material.recording.name),
        "material": material,
        "summary": material.summary,
        "comparison": material.comparison,
        "duration_s": _duration_us(material) / 1e6,
        "mismatch_us": _mismatch_us(material),
        "speed": _default_speed(_duration_us(material)),
        "sides": collected.facts["sides"],
        "engines": engines,
        "run": next((side.run for side in material.sides if side.run), None),
        "looks": {side["name"]: side["look"] for side in engines},
        "verdict": verdict,
        "checks": [] if material.comparison else checks_of(verdict, decisive),
        "headline": material.comparison.headline if material.comparison else headline(verdict, material.summary, tracked),
        "judged": judged,
        "tracked": tracked,
        "classified": any(side["labels"] for side in engines),
        "notes": _notes(material, collected),
        "shown": collected.shown,
        "absorbed": {name: paths.absorbed for name, paths in collected.paths.items() if paths.absorbed},
        "scored": scored,
        "score_sides": score_sides,
        "scores": score_rows([scored["scores"][side["name"]] for side in score_sides]) if scored else [],
        "agreement": material.summary.get("agreement") if len(engines) > 1 else None,
        "heats": heat_maps(material),
        "run_rows": run_rows(material.summary),
        "engine_rows": [(side.name, side.log.engine) for side in material.sides],
        "peak_per_s": _peak_per_s(material),
        "config_rows": flat(material.summary.get("config", {})),
        "versions": material.summary.get("versions", {}),
        "latency": latency_bars(material.summary),
        "needs": _needs(material, tracked=tracked, scored=scored is not None),
        "marks": {"good": "✓", "fair": "!", "poor": "✗"},
    }
    facts = collected.facts | {
        "columns": packed.directory,
        "start": _start_us(material),
        "mismatch": _mismatch_us(material),
        "merged": [[pair["hardware_id"], pair["software_id"]] for pair in (context["agreement"] or {}).get("merges", [])],
    }
    return _template().render(
        **context,
        tabs=_tabs(material, context),
        style=inline_styles("style", "screen"),
        **inline_script(inline_modules(MODULES), facts),
        packed=packed.text,
    )


@cache
def _template() -> Template:
    """The page's template, compiled once: a long run has a page for each part."""
    environment = html_templates("evcot_cosim.report")
    environment.filters |= {"percent": percent}
    return environment.get_template("report.html.j2")


def _tabs(material: Material, context: Mapping[str, Any]) -> list[tuple[str, str]]:
    """The tabs that have content, as (name, title), the most urgent first."""
    mismatch, two_runs = "mismatch" in material.summary, material.comparison is not None
    tabs = (
        ("mismatch", "Mismatch", mismatch),
        ("missing", "What is missing", not context["judged"] and not mismatch and not two_runs),
        ("differences", "Differences", two_runs),
        ("objects", "Objects", any(side["ids"] for side in context["sides"])),
        ("scores", "Scores", bool(context["scores"])),
        ("agreement", "Agreement", context["agreement"] is not None and context["judged"]),
        ("timing", "Timing", "cycles_per_event" in material.summary),
        ("heat", "Heat maps", True),
        ("run", "Runs" if two_runs else "Run", True),
    )
    return [(name, title) for name, title, there in tabs if there]


def _scored(material: Material) -> dict[str, Any] | None:
    """Scores of all sides: those that the summary has, or made here."""
    stored: dict[str, Any] | None = material.summary.get("truth")
    if stored and set(stored["scores"]) == {side.name for side in material.sides}:
        return stored
    if material.truth is None or "mismatch" in material.summary:
        return None
    return material.truth.figures({side.name: side.log for side in material.sides})


def _verdict(material: Material, known: Mapping[str, Any]) -> Verdict:
    """The verdict of the figures that the summary has; of logs alone they are made here."""
    stored = material.summary.get("verdict")
    if stored is not None and set(stored["figures"]) == {side.name for side in material.sides}:
        return verdict_by({side: Quality(**values) for side, values in stored["figures"].items()}, known)
    known = {"recording_s": _duration_us(material) / 1e6, **known}
    return verdict_of(material.recording, {side.name: side.log for side in material.sides}, known)


def _needs(material: Material, *, tracked: bool, scored: bool) -> list[tuple[bool, str, str]]:
    """What a judgement of tracks needs: whether it is there, the need, and what the run has."""
    length_ms, enough_ms = _duration_us(material) / 1e3, ENOUGH_S * 1e3
    return [
        (len(material.events) > 0, "Events", f"{len(material.events):,}"),
        (length_ms >= enough_ms, f"A recording of {enough_ms:g} ms at least, with moving objects", f"{length_ms:,.3g} ms"),
        (tracked, "A track that became visible", "yes" if tracked else "none"),
        (scored, "A truth, for scores", "yes" if scored else "none"),
    ]


def _peak_per_s(material: Material) -> float:
    """The highest event rate over 10 ms."""
    t_us = material.events.t_us
    if not len(t_us):
        return 0.0
    edges_us = np.arange(t_us[0], t_us[-1] + _PEAK_US + 1, _PEAK_US)
    return float(np.diff(np.searchsorted(t_us, edges_us)).max(initial=0) * (1e6 / _PEAK_US))


def inline_modules(names: tuple[str, ...], package: str = "evcot_cosim.report") -> str:
    """Concatenate modules in one scope, without their imports and exports, in order of their dependencies."""
    return "\n".join(_EXPORT.sub("", _IMPORT.sub("", _source(f"{name}.js", package))) for name in names)


def inline_script(script: str, facts: Mapping[str, Any]) -> dict[str, str]:
    """What a template needs of its script: `script`, `script_hash`, see `hash_of`, and `facts`, the data for the script."""
    data = json.dumps(facts, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    return {"script": script, "script_hash": hash_of(script), "facts": data}


def hash_of(script: str) -> str:
    """The hash by which a page's content security policy allows its script."""
    return base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()


def inline_styles(*names: str) -> str:
    """The report's style sheets: `style` for documents, with `screen` for pages that fill the window."""
    return "\n".join(_source(f"{name}.css") for name in names)


def _source(name: str, package: str = "evcot_cosim.report") -> str:
    return (files(package) / "templates" / name).read_text(encoding="utf-8")


def _fitting(material: Material, events_max: int) -> tuple[Collected, Packed]:
    """The collected data and its packed text, with as many events as fit."""
    while True:
        collected = collect(material, events_max)
        packed = pack(collected.columns)
        if len(packed.text) <= _TEXT_MAX or not collected.shown:
            return collected, packed
        events_max = int(min(collected.shown, events_max) * min(0.98 * _TEXT_MAX / len(packed.text), 0.9))


def _notes(material: Material, collected: Collected) -> list[str]:
    """Notes about data that the page leaves out."""
    notes = []
    if collected.shown < len(material.events):
        notes.append(
            f"{collected.shown:,} of {len(material.events):,} events are drawn, evenly chosen; figures, curves and maps "
            "count every one. A report of a shorter part, with --from and --to, draws all of its events."
        )
    for name, paths in collected.paths.items():
        if len(paths.lives) < paths.all_lives:
            notes.append(f"Of {paths.all_lives:,} {name} tracks the {LIVES_MAX:,} longest are drawn.")
        elif len(paths.points) < paths.all_points:
            notes.append(f"Of {paths.all_points:,} {name} positions {RECORDS_MAX:,} are drawn, evenly chosen.")
    decided, all_events = len(material.events), len(material.recording.events)
    if decided < all_events:
        notes.append(f"The run ended after {decided:,} of {all_events:,} events.")
    return notes


def _start_us(material: Material) -> int:
    """Start time of the playback: the mismatch, else a merge, else a birth, after the start of the recording."""
    mismatch_us = _mismatch_us(material)
    if mismatch_us is not None:
        return mismatch_us
    for kind in (Kind.MERGED, Kind.BORN):
        for side in material.sides:
            times_us = side.log.of_kind(kind)["t_us"] - material.span_us[0]
            if len(times_us):
                later = int(np.searchsorted(times_us, _GOING * _duration_us(material)))
                return int(times_us[min(later, len(times_us) - 1)])
    return _duration_us(material) // 2


def _mismatch_us(material: Material) -> int | None:
    found: dict[str, Any] | None = material.summary.get("mismatch")
    t_us = material.events.t_us
    if not found or not len(t_us):
        return None
    return int(t_us[min(max(found["event_index"], 0), len(t_us) - 1)]) - material.span_us[0]


def _duration_us(material: Material) -> int:
    return material.span_us[1] - material.span_us[0]


def _default_speed(duration_us: int) -> float:
    """The fastest speed at which the whole playback still takes long enough to follow."""
    return max((speed for speed in _SPEEDS if duration_us / 1e6 / speed >= _PLAYING_S), default=_SPEEDS[0])

# SPDX-License-Identifier: Apache-2.0
"""The HTML file: rendered templates with inlined style sheet and modules, without external resources."""

from __future__ import annotations

import base64
import hashlib
import json
import math
import re
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Template

from evcot.outputs import written_aside
from evcot.templating import templates
from evcot.tracks.log import DROPPED, Kind

from ..lockstep.verdict import Grade, Verdict, verdict_from, verdict_of
from .collect import Collected, collect
from .facts import Differences, agreement_rows, differences, flat, latency_bars, run_rows, score_rows
from .heat_maps import heat_maps
from .material import Material
from .pack import Packed, pack
from .subsample import EVENTS_MAX, LIVES_MAX, RECORDS_MAX

__all__ = ["MODULES", "inline_modules", "render", "write_report"]

# In the order in which they need each other.
MODULES = (
    "unpack", "search", "surface", "stage", "pointer", "clock", "tracks", "present", "recording", "steps", "axis", "lives",
    "curves", "places", "timeline", "theme", "hover", "layers", "transport", "keys", "links", "main",
)  # fmt: skip

_TEXT_MAX = 9_000_000  # characters of packed columns
_LISTED_MAX = 5_000  # of a list of places
_WHEN_BINS = 160  # of a list's histogram over time
_DECAY_US = 10_000  # of events, at first
_GOING = 0.15  # of the recording: after that there is something to see
_PLAYING_S = 10  # that the whole recording takes at first, at least
_SPEEDS = (0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0)
# Of the curves, in pixels: known before they are drawn, so that nothing jumps.
_HEIGHTS = {"rate": 44, "alive": 64, "size": 64, "nev": 64, "quiet": 64}
_LANES_HEIGHT = 440  # of all lifetimes, at most, as long as a lane has its least
_LANE = (3, 14)  # height of a lane: least, most
_LANES_LEAST = 2  # of a side
_LANES_GAP = 22  # below a side's lanes, where crowded merges are counted
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
    found = differences(material)
    scores = [(side.name, of) for side in material.sides if material.truth and (of := material.truth.scores(side.log))]
    script = inline_modules(MODULES)
    facts = collected.facts | {
        "columns": packed.directory,
        "start": _start_us(material),
        "mismatch": _mismatch_us(material),
        "lists": _lists(material, found),
    }
    verdict = _verdict(material) if material.comparison is None else Verdict(Grade.GOOD, "", ())
    return _template().render(
        title=material.summary.get("name", material.recording.name),
        material=material,
        summary=material.summary,
        begin_us=material.span_us[0],
        duration_s=_duration_us(material) / 1e6,
        mismatch_us=_mismatch_us(material),
        speed=_default_speed(_duration_us(material)),
        decay=round(math.log10(_DECAY_US), 2),
        trail=round(math.log10(min(max(0.1 * _duration_us(material), 1e3), 1e6)), 2),
        heights=_HEIGHTS | {"lives": _lives_height(collected)},
        hints={"difference": f"next place where {material.pair[0]} and {material.pair[1]}, or hardware and model, differ"},
        sides=collected.facts["sides"],
        paths=collected.paths,
        notes=_notes(material, collected),
        agreement=agreement_rows(material.summary),
        differences=found,
        verdict=verdict,
        decisive="hardware" if "hardware" in verdict.figures else next(iter(verdict.figures), ""),
        marks={"good": "✓", "fair": "!", "poor": "✗"},
        compared=found is not None or "mismatch" in material.summary,
        has_hardware=any(side.is_hardware for side in material.sides),
        rings=any(side["ring"] for side in collected.facts["sides"]),
        arrows=any(side["moving"] for side in collected.facts["sides"]),
        score_sides=[name for name, _ in scores],
        scores=score_rows([of for _, of in scores]),
        heats=heat_maps(material),
        run_rows=run_rows(material.summary),
        config_rows=flat(material.summary.get("config", {})),
        versions=material.summary.get("versions", {}),
        latency=latency_bars(material.summary),
        filtered=any((side.log.owner == DROPPED).any() for side in material.sides),
        style=_source("style.css"),
        script=script,
        script_hash=base64.b64encode(hashlib.sha256(script.encode()).digest()).decode(),
        facts=json.dumps(facts, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c"),
        packed=packed.text,
    )


@cache
def _template() -> Template:
    """The page's template, compiled once: a long run has a page for each part."""
    environment = templates("evcot_cosim.report", autoescape=True, trim_blocks=True, lstrip_blocks=True)
    environment.filters |= {"ms": _ms}
    return environment.get_template("report.html.j2")


def _verdict(material: Material) -> Verdict:
    """What the run has in its summary; of logs alone it is made here."""
    stored = material.summary.get("verdict")
    if stored is not None and set(stored["figures"]) == {side.name for side in material.sides}:
        return verdict_from(stored)
    return verdict_of(material.recording, {side.name: side.log for side in material.sides}, material.summary)


def _lists(material: Material, found: Differences | None) -> dict[str, Any]:
    """The lists of places by name: rows of [time, side, track, more], and how many there are in each part of the time."""
    if found is None:
        return {}
    lists = {"merges": found.merges, "lives": found.lives, "joint": found.joint_merges}
    edges_us = np.linspace(0, max(_duration_us(material), 1), _WHEN_BINS + 1)
    return {
        name: {
            "rows": [[place.at_us, place.side, place.track, place.text] for place in places[:_LISTED_MAX]],
            "when": {
                side: np.histogram([place.at_us for place in places if place.side == side], edges_us)[0].tolist()
                for side in sorted({place.side for place in places})
            },
        }
        for name, places in lists.items()
    }


def inline_modules(names: tuple[str, ...], package: str = "evcot_cosim.report") -> str:
    """Concatenate modules in one scope, without their imports and exports, in order of their dependencies."""
    return "\n".join(_EXPORT.sub("", _IMPORT.sub("", _source(f"{name}.js", package))) for name in names)


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
            notes.append(f"Of {paths.all_lives:,} {name} lifetimes the {LIVES_MAX:,} longest are drawn.")
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
    return 0


def _mismatch_us(material: Material) -> int | None:
    found: dict[str, Any] | None = material.summary.get("mismatch")
    t_us = material.events.t_us
    if not found or not len(t_us):
        return None
    return int(t_us[min(max(found["event_index"], 0), len(t_us) - 1)]) - material.span_us[0]


def _lives_height(collected: Collected) -> int:
    """Height of the lifetimes panel: all lanes, and a gap between the sides."""
    lanes = sum(max(int(paths.lanes.max(initial=-1)) + 1, _LANES_LEAST) for paths in collected.paths.values())
    lane = min(max(_LANES_HEIGHT // max(lanes, 1), _LANE[0]), _LANE[1])
    return max(lanes, _LANES_LEAST) * lane + _LANES_GAP * len(collected.paths)


def _duration_us(material: Material) -> int:
    return material.span_us[1] - material.span_us[0]


def _default_speed(duration_us: int) -> float:
    """The fastest speed at which the whole playback still takes long enough to follow."""
    return max((speed for speed in _SPEEDS if duration_us / 1e6 / speed >= _PLAYING_S), default=_SPEEDS[0])


def _ms(at_us: int) -> str:
    return f"{at_us / 1e3:,.3f} ms"

# SPDX-License-Identifier: Apache-2.0
"""How good a run is, in a few lines with figures: exactness, tracks, events, noise, agreement, and what to do about each.

The terminal, summary.json and the report show these lines. Where there is a ground truth, it decides how good the tracks are.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from enum import IntEnum
from typing import Any

from evcot.events import Recording
from evcot.metrics.quality import Quality, isolated, quality_of
from evcot.tracks.log import TrackLog

__all__ = ["ENOUGH_S", "Grade", "Line", "Verdict", "verdict_by", "verdict_from", "verdict_of"]

ENOUGH_S = 0.05
"""Length of a recording from which on its tracks can be judged: a birth takes up to 20 ms."""


class Grade(IntEnum):
    """How good something is; the order is that of `max` for the worst."""

    GOOD = 0
    FAIR = 1
    POOR = 2

    @property
    def word(self) -> str:
        """Its name in texts and in JSON."""
        return self.name.lower()


_GRADES = {grade.word: grade for grade in Grade}
_SOUND = "The tracks look sound."
_FAULTY = {Grade.FAIR: "The tracks are usable, but", Grade.POOR: "The tracks are poor:"}
# figure: (fair from, poor from); of `owned`, `paired` and `merged` below instead
_SHORT = (0.25, 0.5)
_NOISE_TIME = (0.1, 0.3)
_NOISE_TRACKS = 0.3  # share of tracks from which on noise is no longer good
_HOTA = (0.65, 0.4)
_LOST = 0.25  # share of the objects: from more on that are mostly lost, births are too hard, else tracks are unsteady
_NOISE_OWNED = 0.3  # share of the isolated events in tracks from which on noise is no longer good, if it is no rarity
_NOISE_RARE = 0.05  # share of all events
_OWNED = (0.7, 0.5)
_PAIRED = (0.7, 0.4)
_MERGED = (0.7, 0.4)
_BY_TRUTH = ("exactness", "tracks")  # lines that decide where there is a truth
_FEW = 5  # a share of fewer short tracks makes nothing poor; a share of fewer merges says nothing
# Window of the activity filter that is advised. On 10 draws of traffic_outbound (validation) it raises HOTA from 0.782 to 0.792
# and puts 28 % of the isolated events into tracks instead of 41 %; on hand_dvs128 18 % instead of 32 %. With 5 ms, HOTA falls
# to 0.769.
_ACTIVITY_US = 20_000


@dataclass(frozen=True)
class Line:
    """One finding, graded by the worst of its figures.

    Attributes:
        side: whose it is; empty: of the run.
        advice, fault: what to do, and what is wrong in a few words for the headline; empty where it is good.
    """

    about: str
    side: str
    grade: Grade
    text: str
    advice: str = ""
    fault: str = ""


@dataclass(frozen=True)
class Verdict:
    """The verdict of a run.

    Attributes:
        grade, headline: of all of it; the hardware's tracks decide, or those of the software where it ran alone, and of
            their lines exactness and the truth, where there is one.
        figures: the figures of `Quality` by side.
    """

    grade: Grade
    headline: str
    lines: tuple[Line, ...]
    figures: Mapping[str, Quality] = field(default_factory=dict)

    def to_dict(self) -> dict[str, Any]:
        """Plain values, as summary.json stores them."""
        lines = [asdict(line) | {"grade": line.grade.word} for line in self.lines]
        figures = {side: quality.to_dict() for side, quality in self.figures.items()}
        return {"grade": self.grade.word, "headline": self.headline, "lines": lines, "figures": figures}


def verdict_from(stored: Mapping[str, Any]) -> Verdict:
    """What `Verdict.to_dict` wrote."""
    lines = tuple(Line(**(line | {"grade": _GRADES[line["grade"]]})) for line in stored["lines"])
    figures = {side: Quality(**values) for side, values in stored["figures"].items()}
    return Verdict(_GRADES[stored["grade"]], stored["headline"], lines, figures)


def verdict_of(recording: Recording, logs: Mapping[str, TrackLog], summary: Mapping[str, Any]) -> Verdict:
    """The verdict of the logs of one recording.

    Args:
        logs: by side: hardware, model, or any other name for software.
        summary: what else is known, as in summary.json; `exact`, `records`, `mismatch`, `agreement`, `truth` and `config` are
            used where they are there.
    """
    n = min((len(log.owner) for log in logs.values()), default=0)
    events = recording.events[:n]
    alone = isolated(events, (recording.width, recording.height))
    return verdict_by({side: quality_of(log, events, alone) for side, log in logs.items()}, summary)


def verdict_by(figures: Mapping[str, Quality], summary: Mapping[str, Any]) -> Verdict:
    """The verdict of figures by side; `summary` as of `verdict_of`."""
    lines = _exactness(summary)
    length_s = summary.get("recording_s")
    if length_s is not None and length_s < ENOUGH_S and "mismatch" not in summary and summary.get("exact", True):
        text = f"{length_s * 1e3:.3g} ms: must be {ENOUGH_S * 1e3:g} ms with moving objects at least, for tracks to be judged"
        lines.append(Line("length", "", Grade.FAIR, text, "record longer: half a second is enough for most scenes"))
        return Verdict(Grade.FAIR, "Too short to judge the tracks.", tuple(lines), figures)
    for side, quality in figures.items():
        lines += [_tracks(side, quality, summary), _events(side, quality, summary), _noise(side, quality, summary)]
    lines += _agreement(summary)
    decisive = "hardware" if "hardware" in figures else next(iter(figures), "")
    decided = [line for line in lines if line.side in (decisive, "")]
    if decisive in (summary.get("truth") or {}).get("scores", {}):
        decided = [line for line in decided if line.about in _BY_TRUTH]
    grade = max(map(_counted, decided), default=Grade.GOOD)
    faults = [line.fault for line in decided if line.fault and _counted(line) is grade]
    return Verdict(grade, _headline(grade, faults, summary), tuple(lines), figures)


def _counted(line: Line) -> Grade:
    """Where hardware and software disagree, either may be wrong: that alone makes no run useless."""
    return min(line.grade, Grade.FAIR) if line.about == "agreement" else line.grade


def _headline(grade: Grade, faults: list[str], summary: Mapping[str, Any]) -> str:
    if "mismatch" in summary:
        return "Hardware and model differ: the run ended there."
    if summary.get("exact") is False:
        return "Hardware and model differ."
    return f"{_FAULTY[grade]} {', and '.join(faults)}." if grade else _SOUND


def _exactness(summary: Mapping[str, Any]) -> list[Line]:
    if "mismatch" in summary:
        found = summary["mismatch"]
        text = f"hardware and model differ at event {found['event_index']:,}: {found['field']}"
        return [Line("exactness", "", Grade.POOR, text)]
    if "exact" not in summary:
        return []
    if not summary["exact"]:
        return [Line("exactness", "", Grade.POOR, "hardware and model differ")]
    if summary.get("records") == 0:
        text = "hardware = model in the owner of every event; no record was there to compare"
        return [Line("exactness", "", Grade.FAIR, text, fault="no record was there to compare")]
    text = f"hardware = model in all {summary.get('records', 0):,} records and in the owner of every event"
    return [Line("exactness", "", Grade.GOOD, text)]


def _tracks(side: str, found: Quality, summary: Mapping[str, Any]) -> Line:
    if not found.tracks:
        return Line(
            "tracks",
            side,
            Grade.POOR,
            "no track became visible",
            _easier_birth(side, summary),
            "none became visible",
        )
    text = _counted_tracks(found.tracks)
    if found.found_again:
        text += f", found again {found.found_again:,} time{'' if found.found_again == 1 else 's'} after a loss"
    truth = summary.get("truth") or {}
    text += f", about {found.alive_mean:.2g} at a time"
    if truth:
        text += f" for {truth['alive_mean']:.2g} objects"
    if found.absorbed:
        text += f", and {found.absorbed:,} that merged into another in the moment of their birth"
    scores = truth.get("scores", {}).get(side)
    if scores is not None:
        return _scored(side, text, found, truth["objects"], scores, summary)
    share = found.short / found.lives
    what = "of their lives " if found.found_again else ""
    text += f"; {_percent(share)} {what}are short: gone within {found.short_us / 1e6:.2g} s, close to where they began"
    if found.short and found.short_time_fraction is not None:
        text += f", and {_percent(found.short_time_fraction)} of the time of all"
    grade = min(_above(share, _SHORT), Grade.POOR if found.short >= _FEW else Grade.FAIR)
    return _line("tracks", side, grade, text, _steadier(side, found, summary), f"{_percent(share)} {what}are short")


def _scored(side: str, text: str, found: Quality, objects: int, scores: Mapping[str, Any], summary: Mapping[str, Any]) -> Line:
    """The line of tracks that a ground truth judges."""
    hota, lost, switches = scores["hota"], scores["ml"], scores["idsw"]
    text += f"; HOTA {hota:.3f}: {scores['mt']:,} of {objects:,} objects mostly tracked, {lost:,} mostly lost, "
    text += f"{switches:,} switch{'' if switches == 1 else 'es'} of identity"
    advice = _easier_birth(side, summary) if lost > _LOST * objects else _steadier(side, found, summary)
    return _line("tracks", side, _below(hota, _HOTA), text, advice, f"they score HOTA {hota:.3f}")


def _events(side: str, found: Quality, summary: Mapping[str, Any]) -> Line:
    if found.owned_fraction is None:
        return Line("events", side, Grade.GOOD, "no event with a neighbour reached the tracker")
    share = _percent(found.owned_fraction)
    text = f"{share} of the events that are neither filtered out nor isolated belong to lasting tracks"
    advice = f"objects are missed, or lost in between; {_easier_birth(side, summary)}"
    return _line("events", side, _below(found.owned_fraction, _OWNED), text, advice, f"lasting ones have {share} of the events")


def _noise(side: str, found: Quality, summary: Mapping[str, Any]) -> Line:
    if not found.isolated_fraction:
        return Line("noise", side, Grade.GOOD, "no event is isolated")
    dropped, owned = found.isolated_dropped_fraction or 0, found.isolated_owned_fraction or 0
    text = f"{_percent(found.isolated_fraction)} of all events are isolated: {_percent(dropped)} of them filtered out, "
    text += f"{_percent(owned)} in tracks"
    grade, fault = _above(found.noise_time_fraction or 0, _NOISE_TIME), "many are on noise"
    if owned > _NOISE_OWNED and found.isolated_fraction > _NOISE_RARE and not grade:
        grade, fault = Grade.FAIR, f"{_percent(owned)} of the isolated events enter them"
    if found.noise_tracks:
        verb = "consists" if found.noise_tracks == 1 else "consist"
        of = f"{found.lives:,} lives of tracks" if found.found_again else _counted_tracks(found.tracks)
        text += f"; {found.noise_tracks:,} of {of} {verb} mostly of them"
        if found.noise_tracks > _NOISE_TRACKS * found.lives:
            grade, fault = max(grade, Grade.FAIR), "many are on noise"
    return _line("noise", side, grade, text, _quieter(summary), fault)


def _agreement(summary: Mapping[str, Any]) -> list[Line]:
    found = summary.get("agreement")
    if not found:
        return []
    shares = [found["paired_fraction_hardware"], found["paired_fraction_software"]]
    if None in shares:
        text = "hardware or software has no track to compare"
        return [Line("agreement", "", Grade.POOR, text, fault="hardware or software has none")]
    same, hardware, software = found["merges_paired"], found["merges_hardware"], found["merges_software"]
    comparable = found["merges_comparable_hardware"], found["merges_comparable_software"]
    most = max(comparable)
    merged = _below(same / most, _MERGED) if most >= _FEW else Grade.GOOD
    text = (
        f"hardware tracks have a software track within {found['radius_px']:g} px for {_percent(shares[0])} of their time, and "
        f"software tracks a hardware track for {_percent(shares[1])}"
    )
    if hardware or software:
        text += f"; of {hardware:,} merges in hardware and {software:,} in software, {comparable[0]:,} and {comparable[1]:,} "
        text += f"could be the same, and {same:,} {'is' if same == 1 else 'are'}"
    advice = "every difference, with its moment, is listed under Agreement in report.html"
    if merged and most >= 2 * min(comparable):
        more = "hardware" if comparable[0] == most else "software"
        advice = f"{more} merges more often, so there parts of one object have tracks of their own; {advice}"
    grade = max(_below(min(shares), _PAIRED), merged)
    return [_line("agreement", "", grade, text, advice, "hardware and software disagree")]


def _steadier(side: str, found: Quality, summary: Mapping[str, Any]) -> str:
    """What to do about many short tracks, by how they end."""
    if 2 * found.noise_tracks > found.lives:
        return f"clusters on noise: {_quieter(summary)}"
    if found.short_merged >= found.short_lost:
        what = "they merge into a neighbouring track: parts of one object start tracks of their own"
        return (
            f"{what}; {_register(side, summary, 'detect_ticks', 'allow less time to collect the events of a birth', 'below')}"
        )
    what = "they end for lack of events: tracks are given up too early, or begin with too few events"
    return f"{what}; {_register(side, summary, 'max_ticks', 'let tracks live longer without events', 'above')}"


def _easier_birth(side: str, summary: Mapping[str, Any]) -> str:
    """What to do about objects without a track."""
    hardware = _hardware(summary)
    if side in ("hardware", "model") and hardware.get("module") == "cot_motion":
        now = hardware.get("registers", {}).get("detect_ticks")
        how = f"detect_ticks in [motion] of run.toml above {now}, then `evcot cosim --config run.toml`"
        return f"allow more time for the first events of a faint object ({how})"
    return _register(side, summary, "clust_nev", "require fewer events for a birth", "below")


def _register(side: str, summary: Mapping[str, Any], name: str, what: str, way: str) -> str:
    """A register of the hardware to change, or the default hardware where it was not used."""
    if side not in ("hardware", "model"):
        return "try other settings, or another engine"
    hardware = _hardware(summary)
    if hardware.get("module") == "cot_motion":
        return f"{what}{_motion_register(hardware.get('registers', {}), name)}"
    slots = hardware.get("slots")
    set_it = f"{what} ({name} in run.toml {way} {slots[0][name]}, then `evcot cosim --config run.toml`)" if slots else what
    return f"take cot_motion, whose boxes follow the objects (`--hardware cot_motion`), or {set_it}"


def _motion_register(registers: Mapping[str, Any], name: str) -> str:
    """Which register of cot_motion to change for one of cot_array, to what; on traffic_outbound two thirds of `detect_ticks`
    left 3 of 5 short tracks, on pendulum_dvs128 twice `life_ticks` left 2 of 6 losses."""
    field = {"max_ticks": "life_ticks"}.get(name, name)
    if field not in registers:
        return " ([motion] in run.toml: docs/motion.md)"
    now = registers[field]
    value = 2 * now // 3 if field == "detect_ticks" else min(2 * now, registers.get("coast_ticks", 2 * now))
    return f": set {field} = {value} (now {now}) in [motion] of run.toml, then `evcot cosim --config run.toml`"


def _hardware(summary: Mapping[str, Any]) -> Mapping[str, Any]:
    """The configuration of the hardware in a summary, as plain values; empty in one of software alone."""
    found = summary.get("config", {}).get("hardware", {})
    return found if isinstance(found, Mapping) else {}


def _quieter(summary: Mapping[str, Any]) -> str:
    """The noise filter; where it is at work already, more of it."""
    window_us = summary.get("config", {}).get("filters", {}).get("activity_us", 0)
    if not 0 < window_us <= _ACTIVITY_US:
        return f"drop events without a recent neighbour: run again with `--activity {_ACTIVITY_US // 1000}`"
    both = f"--activity {window_us / 1e3:g} --activity-support 2"
    return f"drop events without two recent neighbours: run again with `{both}`"


def _line(about: str, side: str, grade: Grade, text: str, advice: str, fault: str) -> Line:
    """A line that needs advice and fault only where it is not good."""
    return Line(about, side, grade, text, advice, fault) if grade else Line(about, side, grade, text)


def _above(share: float, limits: tuple[float, float]) -> Grade:
    return Grade((share > limits[0]) + (share > limits[1]))


def _below(share: float, limits: tuple[float, float]) -> Grade:
    return Grade((share < limits[0]) + (share < limits[1]))


def _counted_tracks(n: int) -> str:
    return f"{n:,} track" if n == 1 else f"{n:,} tracks"


def _percent(share: float) -> str:
    """Whole percent, but neither 0 % of some nor 100 % of not quite all."""
    if 0 < share < 0.005:
        return "under 1 %"
    if 0.995 <= share < 1:
        return "over 99 %"
    return f"{100 * share:.0f} %"

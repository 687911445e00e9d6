# SPDX-License-Identifier: Apache-2.0
"""Quality of the hardware tracker's tracks with its presets for traffic and discs; hardware and golden model must be equal.

Recordings: the real motorway as a whole and in halves, of which the first tuned the preset (validation); simulated motorways
and discs of other seeds (test). The preset for the sensor, which nobody tuned, and the software tracker are scored as well.
`python benchmarks/cot_quality.py` prints the tables of docs/defaults.md.

`what_if` gives the limits of a tracker: its HOTA if one kind of error were corrected and all others remained. Pairs are those
that CLEAR matches at HOTA's lowest threshold. Each figure bounds what mending that one thing could bring.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from evcot.events import Recording
from evcot.filters.config import FilterConfig
from evcot.filters.hot_pixels import learn_hot_pixels
from evcot.filters.run import apply
from evcot.hardware.contract import RECORD
from evcot.hardware.golden import to_track_records
from evcot.hardware.golden import track as track_model
from evcot.metrics import Scores, evaluate, load_rule, read_truth
from evcot.metrics.frames import Frames, line_up
from evcot.metrics.mot import THRESHOLDS, clear, hota
from evcot.metrics.rule import Rule
from evcot.metrics.truth import GroundTruth, ground_truth_of
from evcot.recordings.files import read_recording
from evcot.scenes.registry import simulate_scene
from evcot.trackers.config import RunConfig
from evcot.trackers.presets import fit, for_sensor, preset
from evcot.trackers.rct.tracker import track
from evcot.tracks.log import TrackLog
from evcot.tracks.log_parts import sampled
from evcot_cosim.devices.device import build_device
from evcot_cosim.lockstep.lockstep import Lockstep, chunks
from measure import Result, heading, line
from shared import SHARED

__all__ = ["ENGINES", "WHAT_IF", "Case", "between", "cases", "cot_log", "measure", "score", "simulated", "what_if"]

WHAT_IF = ("as it is", "every track on its object's centre", "no switch", "no false track", "no object missed")

_Pair = tuple[NDArray[np.int64], NDArray[np.int64]]


def what_if(frames: Frames) -> dict[str, float]:
    """HOTA for each of `WHAT_IF`."""
    pairs = list(_pairs(frames))
    variants = (frames, _placed(frames, pairs), _named(frames, pairs), _true(frames, pairs), _complete(frames, pairs))
    return {name: hota(variant).hota for name, variant in zip(WHAT_IF, variants, strict=True)}


def _pairs(frames: Frames) -> Iterator[_Pair]:
    """Per instant, the rows of matched objects and the columns of their tracks."""
    matches = clear(frames, float(THRESHOLDS[0])).matches
    cuts = np.searchsorted(matches.frame, np.arange(1, len(frames.truth)))
    of_frames = zip(np.split(matches.truth, cuts), np.split(matches.track, cuts), strict=True)
    for objects, tracks, (own_objects, own_tracks) in zip(frames.truth, frames.tracks, of_frames, strict=True):
        yield _places(objects, own_objects), _places(tracks, own_tracks)


def _places(numbers: NDArray[np.int64], wanted: NDArray[np.int64]) -> NDArray[np.int64]:
    order = np.argsort(numbers)
    return np.asarray(order[np.searchsorted(numbers, wanted, sorter=order)], np.int64)


def _placed(frames: Frames, pairs: list[_Pair]) -> Frames:
    similarity = tuple(one.copy() for one in frames.similarity)
    for one, pair in zip(similarity, pairs, strict=True):
        one[pair] = 1
    return replace(frames, similarity=similarity)


def _named(frames: Frames, pairs: list[_Pair]) -> Frames:
    """Tracks have their object's number while they are matched, and their own, moved up, while they are not."""
    tracks = tuple(own + frames.n_truth for own in frames.tracks)
    for own, objects, (row, column) in zip(tracks, frames.truth, pairs, strict=True):
        own[column] = objects[row]
    return replace(frames, tracks=tracks, n_tracks=frames.n_tracks + frames.n_truth)


def _true(frames: Frames, pairs: list[_Pair]) -> Frames:
    columns = [np.sort(column) for _, column in pairs]
    return replace(
        frames,
        tracks=tuple(own[column] for own, column in zip(frames.tracks, columns, strict=True)),
        similarity=tuple(one[:, column] for one, column in zip(frames.similarity, columns, strict=True)),
    )


def _complete(frames: Frames, pairs: list[_Pair]) -> Frames:
    """Objects do not count where nobody tracks them."""
    rows = [np.sort(row) for row, _ in pairs]
    return replace(
        frames,
        truth=tuple(own[row] for own, row in zip(frames.truth, rows, strict=True)),
        similarity=tuple(one[row] for one, row in zip(frames.similarity, rows, strict=True)),
    )


def cot_log(recording: Recording, config: RunConfig, *, rtl: bool = True) -> TrackLog:
    """The hardware tracker's log of a recording of at least one event; without `rtl`, that of the golden model alone.

    Raises:
        MismatchError: hardware and model differ.
    """
    cot = config.device_config(recording.width, recording.height)
    if not rtl:
        return track_model(recording, cot)
    events = recording.events
    with Lockstep(cot, model=build_device(cot, waves=False)) as lockstep:
        steps = [lockstep.feed(run).hardware for run in chunks(events)]
    raw = np.concatenate([np.empty(0, RECORD), *(step.records for step in steps)])
    records = to_track_records(raw, cot, events.t_us, 0, int(events.t_us[0]))
    return TrackLog(cot.module, records, np.concatenate([step.owner for step in steps]))


_TRUTH_STEP_US = 20_000
_SEEDS = (11, 12, 13)  # the presets were tuned on others
_SCENES: dict[str, tuple[str, str, dict[str, object]]] = {
    "motorway, simulated": ("traffic", "highway", {}),
    "discs that cross": ("discs", "discs", {}),
    "discs in lanes": ("discs", "discs", {"ways": "separate"}),
}


@dataclass(frozen=True, eq=False)
class Case:
    """A recording, its truth, how that is scored, and the preset for its kind."""

    name: str
    preset: str
    recording: Recording
    truth: GroundTruth
    rule: Rule


Engine = Callable[[Case], TrackLog]


def _configured(config: RunConfig, case: Case) -> RunConfig:
    """For the recording's sensor, with its hot pixels masked."""
    sensor = case.recording.width, case.recording.height
    hot = learn_hot_pixels(case.recording.events, sensor)
    return replace(fit(config, *sensor), filters=replace(config.filters, hot_pixels=hot))


def _hardware(case: Case) -> TrackLog:
    return cot_log(case.recording, _configured(preset(case.preset), case))


def _untuned(case: Case) -> TrackLog:
    return cot_log(case.recording, _configured(for_sensor(case.recording.width), case), rtl=False)


def _software(case: Case) -> TrackLog:
    config = _configured(preset(case.preset), case)
    _, keep = apply(case.recording, FilterConfig(hot_pixels=config.filters.hot_pixels))
    return track(case.recording, config.rct, keep)


ENGINES: Mapping[str, Engine] = {"hardware": _hardware, "hardware, untuned": _untuned, "software": _software}


def between(truth: GroundTruth, from_us: int, to_us: int) -> GroundTruth:
    """The truth at the instants in [from_us, to_us)."""
    begin, end = np.searchsorted(truth.instants_us, (from_us, to_us))
    objects = truth.objects[(truth.objects["frame"] >= begin) & (truth.objects["frame"] < end)].copy()
    objects["frame"] -= begin
    return GroundTruth(truth.instants_us[begin:end], objects, truth.ids)


def cases(quick: bool = False) -> Iterator[list[Case]]:
    """Groups of recordings whose scores are averaged; the real one only where it is at hand."""
    path = SHARED / "traffic_outbound.aedat4"
    if path.is_file():
        rule, recording = load_rule("traffic"), read_recording(path)
        truth = read_truth(SHARED / "traffic_outbound_gt.csv", rule)
        begin_us, end_us = (int(t_us) for t_us in recording.events.t_us[[0, -1]])
        middle_us = (begin_us + end_us) // 2
        case = Case("motorway, real", "traffic", recording, truth, rule)
        yield [case]
        yield [replace(case, name="its first half", truth=between(truth, begin_us, middle_us))]
        yield [replace(case, name="its second half", truth=between(truth, middle_us, end_us))]
    for name, (preset_name, scene, settings) in _SCENES.items():
        yield [simulated(name, preset_name, scene, settings, seed) for seed in (_SEEDS[:1] if quick else _SEEDS)]


def simulated(name: str, preset_name: str, scene: str, settings: Mapping[str, object], seed: int) -> Case:
    """A scene, scored as scenes are."""
    of, rule = simulate_scene(scene, seed, {"truth_step_us": _TRUTH_STEP_US, **settings}), load_rule("scene")
    return Case(name, preset_name, of.recording, ground_truth_of(of.truth, rule), rule)


def measure(_folder: Path, quick: bool) -> Iterator[Result]:
    """HOTA of the hardware; the reference is the preset for the sensor."""
    for group in cases(quick):
        tuned, untuned = (_mean(group, engine, "hota") for engine in (_hardware, _untuned))
        name = group[0].name.replace(",", "").replace(" ", "_")
        how = f"preset {group[0].preset}, hot pixels masked; hardware and model the same bits"
        yield Result(f"cot_hota_{name}", tuned, "HOTA", untuned, "untuned", how=how)


def _mean(group: list[Case], engine: Engine, figure: str) -> float:
    return float(np.mean([getattr(score(case, engine), figure) for case in group]))


def score(case: Case, engine: Engine) -> Scores:
    """All scores of one engine."""
    return evaluate(engine(case), case.truth, case.rule)


# field of `Scores` -> (heading, format)
_COLUMNS = {
    "hota": ("HOTA", ".3f"),
    "deta": ("DetA", ".3f"),
    "assa": ("AssA", ".3f"),
    "loca": ("LocA", ".3f"),
    "mota": ("MOTA", ".3f"),
    "idf1": ("IDF1", ".3f"),
    "idsw": ("switches", ".1f"),
    "fp": ("false", ".0f"),
    "fn": ("missed", ".0f"),
    "truth_ids": ("objects", ".0f"),
    "track_ids": ("tracks", ".0f"),
    "position_error_px_median": ("error, px", ".1f"),
}


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="one simulated recording of each kind")
    groups = list(cases(parser.parse_args().quick))
    heading("", "engine", *(title for title, _ in _COLUMNS.values()))
    bounds: dict[str, list[str]] = {}
    for group in groups:
        for name, engine in ENGINES.items():
            logs = [engine(case) for case in group]
            scores = [evaluate(log, case.truth, case.rule) for log, case in zip(logs, group, strict=True)]
            cells = [
                format(float(np.mean([getattr(one, field) for one in scores])), form) for field, (_, form) in _COLUMNS.items()
            ]
            line([group[0].name, name, *cells])
            if engine is _hardware:
                bounds[group[0].name] = _bounds(list(zip(logs, group, strict=True)))
    print("\nHOTA of the hardware, if one kind of mistake were made good:\n")
    heading("", *WHAT_IF)
    for name, cells in bounds.items():
        line([name, *cells])


def _bounds(runs: list[tuple[TrackLog, Case]]) -> list[str]:
    found = [what_if(_frames(log, case)) for log, case in runs]
    return [f"{np.mean([one[name] for one in found]):.3f}" for name in found[0]]


def _frames(log: TrackLog, case: Case) -> Frames:
    outputs = sampled(log.record_runs(), case.truth.instants_us, case.rule.max_age_us)
    return line_up(outputs, case.truth, case.rule)[0]


if __name__ == "__main__":
    main()

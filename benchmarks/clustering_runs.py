# SPDX-License-Identifier: Apache-2.0
"""Cases of `clustering`: recordings with their truth, each method with a range of sizes, and the results."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evcot.events import Events, Recording
from evcot.filters.config import FilterConfig
from evcot.filters.hot_pixels import learn_hot_pixels
from evcot.filters.run import apply
from evcot.metrics import GroundTruth, Rule, evaluate, load_rule, read_truth
from evcot.metrics.frames import line_up
from evcot.recordings.files import read_recording
from evcot.scenes import simulate_scene
from evcot.trackers.frame_based import presets as frame_presets
from evcot.trackers.frame_based.config import FrameConfig
from evcot.trackers.frame_based.stream import DetectionTracker
from evcot.trackers.frame_based.tracker import FrameTracker
from evcot.trackers.mean_shift import presets as shift_presets
from evcot.trackers.mean_shift.config import MeanShiftConfig
from evcot.trackers.mean_shift.tracker import MeanShiftTracker
from evcot.tracks.log import TrackLog
from evcot.tracks.tracking import track_recording
from evcot.tracks.windows import sampled
from measure import timed
from shared import SHARED

__all__ = ["EVENTS", "FRAMES", "PIPELINE", "Case", "Outcome", "as_written", "cases", "outcomes"]


EVENTS, FRAMES, PIPELINE = "mean shift, events", "mean shift, frames", "median, components"

_PACKETS = (150, 300, 600, 1_200, 2_400)
_FRAMES_US = (2_500, 5_000, 10_000, 20_000, 40_000)
_ROUNDS = 3
_WRITTEN_US = 240_000
_VISIBLE_US = 20_000  # how long an object is detected before it is believed, whatever the size

# Per evaluation: 4 differences, 4 squares, 3 sums, 1 comparison; the exponential's 27 (scale 1, series 19, squarings 6,
# weight 1); 1 sum of weights; 4 weighted sums of 2 operations each.
_EVALUATION = 12 + 27 + 1 + 8
# Per pixel of a frame: clearing, labelling in two passes of about 4, counting.
_PIXEL = 10


@dataclass(frozen=True, eq=False)
class Case:
    """A recording of events that stay, what is known about it, and the preset for it."""

    name: str
    recording: Recording
    preset: str
    truth: GroundTruth | None = None
    rule: Rule | None = None

    @property
    def seconds(self) -> float:
        return self.recording.duration_us * 1e-6

    @property
    def rate_hz(self) -> float:
        return len(self.recording.events) / self.seconds


@dataclass(frozen=True)
class Outcome:
    """One method with one size on one case; costs per second of recording, None where they do not apply.

    `off` is the mean absolute difference of the numbers of tracks and of objects over time, `right` the part of the time at
    which they are the same; `clusters_off`, `clusters_right` the same of what was found in single packets, not yet followed.
    """

    method: str
    size: int
    cpu: float
    evaluations: float | None
    operations: float
    hota: float | None = None
    position_px: float | None = None
    off: float | None = None
    right: float | None = None
    clusters_off: float | None = None
    clusters_right: float | None = None

    @property
    def label(self) -> str:
        return f"{self.size} events" if self.method == EVENTS else f"{self.size / 1000:g} ms"


def cases(folder: Path, quick: bool) -> Iterator[Case]:
    seconds = 1 if quick else 4
    for name, preset, more in (
        ("discs", "discs", {"count": 4, "duration_us": seconds * 1_000_000}),
        ("boxes", "discs", {}),
        ("highway", "traffic", {"duration_us": seconds * 1_000_000}),
    ):
        scene = simulate_scene(name, 1, {"truth_step_us": 5_000, **more})
        folder.mkdir(parents=True, exist_ok=True)
        scene.truth.save(folder / f"{name}.truth.csv")
        rule = load_rule("scene")
        truth = read_truth(folder / f"{name}.truth.csv", rule)
        yield Case(name, _without_hot_pixels(scene.recording), preset, truth, rule)
    if (SHARED / "traffic_outbound.aedat4").is_file():
        rule = load_rule("traffic")
        recording = read_recording(SHARED / "traffic_outbound.aedat4")
        truth = _second_half(read_truth(SHARED / "traffic_outbound_gt.csv", rule), recording)
        yield Case("traffic", _without_hot_pixels(recording), "traffic", truth, rule)
    for name, file in (("hand", "hand_dvs128.aedat4"), ("pendulum", "pendulum_dvs128.aedat")):
        if (SHARED / file).is_file():
            yield Case(name, _without_hot_pixels(read_recording(SHARED / file)), "discs")


def _without_hot_pixels(recording: Recording) -> Recording:
    pixels = learn_hot_pixels(recording.events, (recording.width, recording.height))
    return apply(recording, FilterConfig(hot_pixels=pixels))[0]


def _second_half(truth: GroundTruth, recording: Recording) -> GroundTruth:
    """What the presets were not chosen on."""
    first = int(np.searchsorted(truth.instants_us, recording.events.t_us[0] + recording.duration_us // 2))
    objects = truth.objects[truth.objects["frame"] >= first].copy()
    objects["frame"] -= first
    return replace(truth, instants_us=truth.instants_us[first:], objects=objects)


def outcomes(case: Case, quick: bool) -> Iterator[Outcome]:
    packets, frames_us = (_PACKETS[1::2], _FRAMES_US[::2]) if quick else (_PACKETS, _FRAMES_US)
    for size in packets:
        yield _shifted(case, EVENTS, size, _packets(case, size))
    for size in frames_us:
        yield _shifted(case, FRAMES, size, _frames(case, size))
    for size in frames_us:
        config = replace(frame_presets.PRESETS[case.preset], frame_us=size, **_patience(size))
        done = _follow(case, lambda config=config: FrameTracker(config))  # type: ignore[misc]
        yield _outcome(case, PIPELINE, size, done, None, _pipeline_operations(case, config))


def _shifted(case: Case, method: str, size: int, config: MeanShiftConfig) -> Outcome:
    trackers: list[MeanShiftTracker] = []

    def make() -> MeanShiftTracker:
        trackers.append(MeanShiftTracker(config))
        return trackers[-1]

    done = _follow(case, make)
    evaluations = trackers[-1].cost.evaluations
    return _outcome(case, method, size, done, evaluations, evaluations * _EVALUATION)


def _packets(case: Case, events: int) -> MeanShiftConfig:
    base = shift_presets.PRESETS[case.preset]
    fewest = max(4, round(base.points_min * (events / base.packet_events) ** 0.5))
    length_us = round(1e6 * events / case.rate_hz)
    return replace(base, packet_events=events, points_min=fewest, **_patience(length_us))


def _frames(case: Case, frame_us: int) -> MeanShiftConfig:
    """With as many points for a cluster as a packet of as many events would ask for."""
    alike = _packets(case, max(1, round(case.rate_hz * frame_us * 1e-6)))
    return replace(alike, source="frames", frame_us=frame_us)


def _patience(length_us: int) -> dict[str, Any]:
    """The same time for every size: to be believed, and to be seen again until then."""
    return {"visible_hits": max(2, round(_VISIBLE_US / length_us)), "candidate_us": max(_VISIBLE_US, round(2.5 * length_us))}


@dataclass(frozen=True, eq=False)
class Followed:
    """A log, how many objects were found in each packet, by the packet's last event, and how long it took."""

    log: TrackLog
    t_us: NDArray[np.int64]
    found: NDArray[np.int64]
    cpu_s: float


def _follow(case: Case, make: Callable[[], DetectionTracker]) -> Followed:
    rounds = [_once(case, make()) for _ in range(_ROUNDS)]
    return replace(rounds[-1], cpu_s=median(done.cpu_s for done in rounds))


def _once(case: Case, tracker: DetectionTracker) -> Followed:
    times, counts = [np.empty(0, np.int64)], [np.empty(0, np.int64)]
    detect = tracker.detect

    def counting(events: Events, frames: NDArray[np.void]) -> NDArray[np.void]:
        found = detect(events, frames)
        times.append(events.t_us[frames["end"] - 1])
        counts.append(frames["found_end"] - frames["found"])
        return found

    tracker.detect = counting
    logs: list[TrackLog] = []
    took = timed(lambda: logs.append(track_recording("clustering", tracker, case.recording)))
    return Followed(logs[0], np.concatenate(times), np.concatenate(counts), took.cpu_s)


def _outcome(case: Case, method: str, size: int, done: Followed, evaluations: int | None, operations: float) -> Outcome:
    a_second = Outcome(
        method,
        size,
        done.cpu_s / case.seconds,
        None if evaluations is None else evaluations / case.seconds,
        operations / case.seconds,
    )
    if case.truth is None or case.rule is None:
        return a_second
    scores = evaluate(done.log, case.truth, case.rule)
    outputs = sampled(done.log.record_runs(), case.truth.instants_us, case.rule.max_age_us)
    frames, _, _ = line_up(outputs, case.truth, case.rule)
    objects, tracks = (np.array([len(own) for own in which]) for which in (frames.truth, frames.tracks))
    latest = np.searchsorted(done.t_us, case.truth.instants_us, "right") - 1
    clusters = np.where(latest >= 0, done.found[latest], 0)
    # Where the rule ignores regions, what is found there cannot be told from the rest before it is followed.
    known = not case.rule.ignore
    return replace(
        a_second,
        hota=scores.hota,
        position_px=scores.position_error_px_median,
        off=float(np.abs(tracks - objects).mean()),
        right=float((tracks == objects).mean()),
        clusters_off=float(np.abs(clusters - objects).mean()) if known else None,
        clusters_right=float((clusters == objects).mean()) if known else None,
    )


def _pipeline_operations(case: Case, config: FrameConfig) -> float:
    """Sums of both passes of the median and maxima of both passes of the link, a line of pixels each, and `_PIXEL`."""
    filters = 2 * config.median_px + 1 + 2 * (config.link_px + 1)
    frames = case.recording.duration_us / config.frame_us
    return frames * case.recording.width * case.recording.height * (filters + _PIXEL)


def as_written(case: Case, one: Outcome) -> float | None:
    """Evaluations per second of every shift against every point, nothing folded; None where there is no kernel.

    Over `_WRITTEN_US` in the middle of the recording: without shortcuts it takes long.
    """
    if one.method == PIPELINE:
        return None
    config = (_packets if one.method == EVENTS else _frames)(case, one.size)
    tracker = MeanShiftTracker(replace(config, fold_px=0.0))
    begin_us = case.recording.duration_us // 2
    track_recording("clustering", tracker, case.recording.window(begin_us, begin_us + _WRITTEN_US))
    return tracker.cost.pairs / (_WRITTEN_US * 1e-6)

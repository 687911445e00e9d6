# SPDX-License-Identifier: Apache-2.0
"""Cases of `clustering`: recordings with their truth, each method with a range of sizes, and the results."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import median

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
from evcot.trackers.detections.identity import Identities
from evcot.trackers.detections.stream import DetectionTracker
from evcot.trackers.frame_based import config as frame_presets
from evcot.trackers.frame_based.config import FrameConfig
from evcot.trackers.frame_based.tracker import FrameTracker, candidate_us
from evcot.trackers.mean_shift import config as shift_presets
from evcot.trackers.mean_shift.clusters import POLARITY_PX
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
_VISIBLE_US = 20_000  # how long an object is detected before it is visible


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

    `right` is the part of the time at which the numbers of tracks and of objects are the same.
    """

    method: str
    size: int
    cpu: float
    evaluations: float | None
    hota: float | None = None
    position_px: float | None = None
    right: float | None = None

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
        yield _shifted(case, EVENTS, size)
    for size in frames_us:
        yield _shifted(case, FRAMES, size)
    for size in frames_us:
        config = replace(frame_presets.PRESETS[case.preset], frame_us=size, visible_hits=_hits(size))
        yield _outcome(case, PIPELINE, size, *_follow(case, lambda config=config: FrameTracker(config)))  # type: ignore[misc]


class _PixelShift(MeanShiftTracker):
    """Mean shift on frames: each pixel with events is one point of x, y and mean polarity."""

    def __init__(self, config: MeanShiftConfig, frame_us: int) -> None:
        super().__init__(config)
        self._frames = FrameTracker(FrameConfig(frame_us=frame_us))
        self._identities = Identities(config, candidate_us(frame_us))

    def frame_ends(self, t_us: NDArray[np.int64]) -> NDArray[np.int64]:
        return self._frames.frame_ends(t_us)

    def points(self, events: Events) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        address = events.y.astype(np.int64) << 16 | events.x
        pixels, of_event, count = np.unique(address, return_inverse=True, return_counts=True)
        polarity = POLARITY_PX * np.bincount(of_event, events.p) / count
        points = np.stack((pixels & 0xFFFF, pixels >> 16, polarity, np.zeros(len(pixels))))
        return points, np.full(len(pixels), float((events.t_us - events.t_us[0]).mean()))


def _tracker(case: Case, method: str, size: int) -> MeanShiftTracker:
    """A cluster has a minimum number of points that grows with the square root of the events."""
    base = shift_presets.PRESETS[case.preset]
    events = size if method == EVENTS else max(1, round(case.rate_hz * size * 1e-6))
    fewest = max(4, round(base.points_min * (events / base.packet_events) ** 0.5))
    hits = _hits(round(1e6 * events / case.rate_hz))
    config = replace(base, packet_events=events, points_min=fewest, visible_hits=hits)
    return MeanShiftTracker(config) if method == EVENTS else _PixelShift(config, size)


def _hits(length_us: int) -> int:
    """The same time for every size until an object is visible."""
    return max(2, round(_VISIBLE_US / length_us))


def _shifted(case: Case, method: str, size: int) -> Outcome:
    trackers: list[MeanShiftTracker] = []

    def make() -> MeanShiftTracker:
        trackers.append(_tracker(case, method, size))
        return trackers[-1]

    return _outcome(case, method, size, *_follow(case, make), trackers[-1].evaluations)


def _follow(case: Case, make: Callable[[], DetectionTracker]) -> tuple[TrackLog, float]:
    """The log, and CPU seconds: the median of `_ROUNDS`."""
    logs, cpu_s = [], []
    for _ in range(_ROUNDS):
        tracker = make()
        took = timed(lambda tracker=tracker: logs.append(track_recording("clustering", tracker, case.recording)))  # type: ignore[misc]
        cpu_s.append(took.cpu_s)
    return logs[-1], median(cpu_s)


def _outcome(case: Case, method: str, size: int, log: TrackLog, cpu_s: float, evaluations: int | None = None) -> Outcome:
    a_second = None if evaluations is None else evaluations / case.seconds
    outcome = Outcome(method, size, cpu_s / case.seconds, a_second)
    if case.truth is None or case.rule is None:
        return outcome
    scores = evaluate(log, case.truth, case.rule)
    outputs = sampled(log.record_runs(), case.truth.instants_us, case.rule.max_age_us)
    frames, _, _ = line_up(outputs, case.truth, case.rule)
    objects, tracks = (np.array([len(own) for own in which]) for which in (frames.truth, frames.tracks))
    right = float((tracks == objects).mean())
    return replace(outcome, hota=scores.hota, position_px=scores.position_error_px_median, right=right)


def as_written(case: Case, one: Outcome) -> float | None:
    """Evaluations per second of every shift with every point, nothing joined; None where there is no kernel.

    Over `_WRITTEN_US` in the middle of the recording: without shortcuts it takes long.
    """
    if one.method == PIPELINE:
        return None
    tracker = _tracker(case, one.method, one.size)
    tracker.fold_px = 0.0
    begin_us = case.recording.duration_us // 2
    track_recording("clustering", tracker, case.recording.window(begin_us, begin_us + _WRITTEN_US))
    return tracker.pairs / (_WRITTEN_US * 1e-6)

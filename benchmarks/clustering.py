# SPDX-License-Identifier: Apache-2.0
"""Cost and quality of clustering: mean shift on packets of events and on frames, and the classical pipeline.

Run on its own it prints tables and draws docs/images/clustering.png. Each method is run with a range of packet or frame sizes.
At equal quality means: the target is the lower of the two best HOTA that mean shift reaches on events and on frames, less
`_SLACK`; of each method, the cheapest size that reaches it is compared. Cost counts per second of recording:

- evaluations of the kernel, as made; and as the equations are written, every point against every point without shortcuts;
- CPU seconds of one thread, all included.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import median

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray

import streams
from evcot.events import Events, Recording
from evcot.filters.config import FilterConfig
from evcot.filters.hot_pixels import learn_hot_pixels
from evcot.filters.run import apply
from evcot.metrics import GroundTruth, Rule, evaluate, load_rule, read_truth
from evcot.metrics.frames import line_up
from evcot.recordings.files import read_recording
from evcot.scenes import simulate_scene
from evcot.trackers import frame_based as frame_presets
from evcot.trackers.detections import DetectionTracker, Identities
from evcot.trackers.frame_based import FrameConfig, FrameTracker, candidate_us
from evcot.trackers.mean_shift import tracker as shift_presets
from evcot.trackers.mean_shift.tracker import POLARITY_PX, PRESETS, MeanShiftConfig, MeanShiftTracker
from evcot.tracks.log import TrackLog
from evcot.tracks.log_parts import sampled
from evcot.tracks.tracking import track_recording
from measure import Goal, Result, Timing, heading, line, take_turns, timed
from shared import SHARED

__all__ = ["EVENTS", "FRAMES", "PIPELINE", "Case", "Outcome", "as_written", "cases", "measure", "outcomes"]


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


_PICTURE = Path(__file__).parents[1] / "docs" / "images" / "clustering.png"

_TICKS = (0.03, 0.1, 0.3, 1.0)

_SLACK = 0.02
_HEAD = ("data", "method", "size", "HOTA", "position, px", "evaluations/s", "as written", "CPU s/s", "number right")

# The paper's comparison, as far as it says: packets of a few hundred events, and frames at a camera's usual rate.
_CUSTOMARY = ((EVENTS, 300), (FRAMES, 40_000), (PIPELINE, 40_000))


def measure(folder: Path, quick: bool) -> Iterator[Result]:
    """mean_shift_rate; then clustering_* for each case: event-based over frame-based cost at equal quality."""
    yield _rate(quick)
    for case in cases(folder, quick):
        by_events, by_frames, _ = _equal(list(outcomes(case, quick)))
        if by_events is None or by_frames is None:
            continue
        how = f"at {_quality(by_events)} ({by_events.label}) and {_quality(by_frames)} ({by_frames.label})"
        for what in ("evaluations", "cpu"):
            ours, theirs = getattr(by_events, what), getattr(by_frames, what)
            unit = "/s" if what == "evaluations" else "s/s"
            yield Result(f"clustering_{what}_{case.name}", ours, unit, theirs, "frames", how=how)


def _rate(quick: bool) -> Result:
    """Events per second on the stream of four discs."""
    events, config = streams.joined(300_000 if quick else 2_000_000, 4), PRESETS["discs"]
    live: list[int] = []

    def once() -> Timing:
        tracker = MeanShiftTracker(config)

        def work() -> None:
            for begin in range(0, len(events), 1 << 16):
                tracker.feed(events[begin : begin + (1 << 16)])
                live.append(sum(track.track_id >= 0 for track in tracker.tracks()))

        return timed(work)

    rate = len(events) / take_turns({"rate": once}, 3 if quick else 7).seconds("rate") / 1e6
    how = f"{config.packet_events} events a packet, {np.mean(live):.1f} visible tracks; CPU time"
    return Result("mean_shift_rate", rate, "M events/s", 1.0, "goal", goal=Goal(1), how=how)


def _equal(every: Sequence[Outcome]) -> tuple[Outcome | None, ...]:
    """Of each method the cheapest that reaches the target, None where none does; without truth, the cheapest."""
    by_method = {name: [one for one in every if one.method == name] for name in (EVENTS, FRAMES, PIPELINE)}
    best = [max(one.hota or 0.0 for one in by_method[name]) for name in (EVENTS, FRAMES)]
    target = min(best) - _SLACK
    reached = ([one for one in own if one.hota is None or one.hota >= target] for own in by_method.values())
    return tuple(
        min(own, key=lambda one: one.cpu if one.evaluations is None else one.evaluations, default=None) for own in reached
    )


def _of_size(own: Sequence[Outcome], method: str, size: int) -> Outcome:
    return next(one for one in own if (one.method, one.size) == (method, size))


def _quality(one: Outcome) -> str:
    return "unknown quality" if one.hota is None else f"HOTA {one.hota:.2f}, {one.position_px:.2f} px"


def main() -> None:
    """Measure, print, draw."""
    parser = argparse.ArgumentParser(description="Cost and quality of clustering; tables in Markdown")
    parser.add_argument("--quick", action="store_true", help="fewer sizes, shorter scenes, no picture")
    quick = parser.parse_args().quick
    done: dict[str, list[Outcome]] = {}
    cost, customary = [], []
    for case in cases(Path("build") / "bench", quick):
        done[case.name] = list(outcomes(case, quick))
        chosen = _equal(done[case.name])
        cost += _cost_rows(case, chosen)
        customary += _cost_rows(case, [_of_size(done[case.name], *which) for which in _CUSTOMARY])
        print(case.name, flush=True)
    _table("At equal quality", _HEAD, cost)
    _table("300 events and 40 ms", _HEAD, customary)
    if not quick:
        _draw(done)
        print(_PICTURE)


def _cost_rows(case: Case, chosen: Sequence[Outcome | None]) -> list[tuple[str, ...]]:
    rows: list[tuple[str, ...]] = []
    first: tuple[float, ...] | None = None
    for one, name in zip(chosen, (EVENTS, FRAMES, PIPELINE), strict=True):
        if one is None:
            rows.append((case.name, name, "none reaches it", *[""] * 6))
            continue
        costs = (one.evaluations, as_written(case, one), one.cpu)
        shown = [("" if value is None else f"{value:.2g}" if value < 1 else f"{value:.2e}") for value in costs]
        right = _or(one.right, ".0%")
        rows.append((case.name, name, one.label, _or(one.hota, ".3f"), _or(one.position_px, ".2f"), *shown, right))
        if name == EVENTS:
            first = costs  # type: ignore[assignment]
        elif name == FRAMES and first is not None:
            less = [f"{1 - ours / theirs:.0%}" for ours, theirs in zip(first, costs, strict=True)]  # type: ignore[operator]
            rows.append((case.name, "saved by events", "", "", "", *less, ""))
    return rows


def _or(value: float | None, form: str) -> str:
    return "" if value is None else format(value, form)


def _table(title: str, head: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    print(f"\n{title}\n")
    heading(*head)
    for row in rows:
        line(row)


def _draw(done: Mapping[str, Sequence[Outcome]]) -> None:
    with_truth = {name: own for name, own in done.items() if own[0].hota is not None}
    figure, axes = plt.subplots(1, len(with_truth), figsize=(3.2 * len(with_truth), 3.4), layout="constrained", squeeze=False)
    for axis, (name, own) in zip(axes[0], with_truth.items(), strict=True):
        for method, marker in ((EVENTS, "o"), (FRAMES, "s"), (PIPELINE, "^")):
            of_method = [one for one in own if one.method == method]
            places = [one.cpu for one in of_method], [one.hota for one in of_method]
            axis.plot(*places, marker=marker, linewidth=1, markersize=4, label=method)
            for one in (of_method[0], of_method[-1]):
                axis.annotate(one.label, (one.cpu, one.hota or 0.0), (3, 3), textcoords="offset points", fontsize=6)
        axis.set(title=name, xlabel="CPU seconds per second", xscale="log")
        axis.minorticks_off()
        axis.set_xticks(_TICKS, [f"{tick:g}" for tick in _TICKS])
        axis.grid(linewidth=0.3)
    axes[0][0].set_ylabel("HOTA")
    figure.legend(*axes[0][0].get_legend_handles_labels(), loc="outside lower center", ncols=3, fontsize="small")
    figure.savefig(_PICTURE, dpi=90)


if __name__ == "__main__":
    main()

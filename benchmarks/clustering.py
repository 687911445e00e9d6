# SPDX-License-Identifier: Apache-2.0
"""What clustering costs and how good it is: mean shift on packets of events, the same on frames, and the classical pipeline.

Run on its own it prints tables and draws docs/images/clustering.png. Each method is run with a range of packet or frame sizes.
At equal quality means: the target is the lower of the two best HOTA that mean shift reaches on events and on frames, less
`_SLACK`; of each method, the cheapest size that reaches it is compared. Cost counts per second of recording:

- evaluations of the kernel, as made; and as the equations are written, every point against every point without shortcuts;
- arithmetic operations: `_EVALUATION` for each evaluation; for the classical pipeline `_PIXEL` and its filters for each pixel
  of the frame;
- CPU seconds of one thread, all included.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import median
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray

import streams
from evcot.events import Events, Recording
from evcot.files import read_recording
from evcot.filters.config import FilterConfig
from evcot.filters.hot_pixels import learn_hot_pixels
from evcot.filters.run import apply
from evcot.frame_based import presets as frame_presets
from evcot.frame_based.config import FrameConfig
from evcot.frame_based.stream import DetectionTracker, run
from evcot.frame_based.tracker import FrameTracker
from evcot.mean_shift import presets as shift_presets
from evcot.mean_shift.config import MeanShiftConfig
from evcot.mean_shift.tracker import MeanShiftTracker
from evcot.metrics import GroundTruth, Rule, evaluate, load_rule, read_truth
from evcot.metrics.frames import line_up
from evcot.metrics.sampling import expiring
from evcot.scenes import simulate_scene
from evcot.tracklog import TrackLog
from measure import Goal, Result, Timing, take_turns, timed

__all__ = ["measure"]

_SHARED = Path(__file__).parents[2] / "shared" / "data"
_PICTURE = Path(__file__).parents[1] / "docs" / "images" / "clustering.png"

_SLACK = 0.02
_PACKETS = (150, 300, 600, 1_200, 2_400)
_FRAMES_US = (2_500, 5_000, 10_000, 20_000, 40_000)
_ROUNDS = 3
_VISIBLE_US = 20_000  # how long an object is detected before it is believed, whatever the size

# Per evaluation: 4 differences, 4 squares, 3 sums, 1 comparison; the exponential's 27 (scale 1, series 19, squarings 6,
# weight 1); 1 sum of weights; 4 weighted sums of 2 operations each.
_EVALUATION = 12 + 27 + 1 + 8
# Per pixel of a frame: clearing, labelling in two passes of about 4, counting.
_PIXEL = 10

_HEAD = ("data", "method", "size", "HOTA", "position, px", "evaluations/s", "as written", "operations/s", "CPU s/s")

EVENTS, FRAMES, PIPELINE = "mean shift, events", "mean shift, frames", "median, components"
# The paper's comparison, as far as it says: packets of a few hundred events, and frames at a camera's usual rate.
_CUSTOMARY = ((EVENTS, 300), (FRAMES, 40_000), (PIPELINE, 40_000))


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


def measure(folder: Path, quick: bool) -> Iterator[Result]:
    """mean_shift_rate; then clustering_* for each case: event-based over frame-based cost at equal quality."""
    yield _rate(quick)
    for case in _cases(folder, quick):
        outcomes = list(_outcomes(case, quick))
        by_events, by_frames, _ = _equal(outcomes)
        if by_events is None or by_frames is None:
            continue
        how = f"at {_quality(by_events)} ({by_events.label}) and {_quality(by_frames)} ({by_frames.label})"
        for what in ("evaluations", "cpu"):
            ours, theirs = getattr(by_events, what), getattr(by_frames, what)
            unit = "/s" if what == "evaluations" else "s/s"
            yield Result(f"clustering_{what}_{case.name}", ours, unit, theirs, "frames", how=how)


def _rate(quick: bool) -> Result:
    """Events per second on the stream of four discs."""
    events, config = streams.joined(300_000 if quick else 2_000_000, 4), shift_presets.preset("discs")
    live: list[int] = []

    def once() -> Timing:
        tracker = MeanShiftTracker(config)

        def work() -> None:
            for begin in range(0, len(events), 1 << 16):
                tracker.feed(events[begin : begin + (1 << 16)])
                live.append(int(np.count_nonzero(tracker.tracks()["track_id"] >= 0)))

        return timed(work)

    rate = len(events) / take_turns({"rate": once}, 3 if quick else 7).seconds("rate") / 1e6
    how = f"{config.packet_events} events a packet, {np.mean(live):.1f} visible tracks; CPU time"
    return Result("mean_shift_rate", rate, "M events/s", 1.0, "goal", goal=Goal(1), how=how)


def _cases(folder: Path, quick: bool) -> Iterator[Case]:
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
    if (_SHARED / "traffic_outbound.aedat4").is_file():
        rule = load_rule("traffic")
        recording = read_recording(_SHARED / "traffic_outbound.aedat4")
        truth = _second_half(read_truth(_SHARED / "traffic_outbound_gt.csv", rule), recording)
        yield Case("traffic", _without_hot_pixels(recording), "traffic", truth, rule)
    for name, file in (("hand", "hand_dvs128.aedat4"), ("pendulum", "pendulum_dvs128.aedat")):
        if (_SHARED / file).is_file():
            yield Case(name, _without_hot_pixels(read_recording(_SHARED / file)), "discs")


def _without_hot_pixels(recording: Recording) -> Recording:
    pixels = learn_hot_pixels(recording.events, (recording.width, recording.height))
    return apply(recording, FilterConfig(hot_pixels=pixels))[0]


def _second_half(truth: GroundTruth, recording: Recording) -> GroundTruth:
    """What the presets were not chosen on."""
    first = int(np.searchsorted(truth.instants_us, recording.events.t_us[0] + recording.duration_us // 2))
    objects = truth.objects[truth.objects["frame"] >= first].copy()
    objects["frame"] -= first
    return replace(truth, instants_us=truth.instants_us[first:], objects=objects)


def _outcomes(case: Case, quick: bool) -> Iterator[Outcome]:
    packets, frames_us = (_PACKETS[1::2], _FRAMES_US[::2]) if quick else (_PACKETS, _FRAMES_US)
    for size in packets:
        yield _shifted(case, EVENTS, size, _packets(case, size))
    for size in frames_us:
        yield _shifted(case, FRAMES, size, _frames(case, size))
    for size in frames_us:
        config = replace(frame_presets.preset(case.preset), frame_us=size, **_patience(size))
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
    base = shift_presets.preset(case.preset)
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
    logs: list[TrackLog] = []
    trackers = [make() for _ in range(_ROUNDS)]
    took = [timed(lambda tracker=tracker: logs.append(run("", tracker, case.recording))).cpu_s for tracker in trackers]  # type: ignore[misc]
    t_us, found = _counted(case, make())
    return Followed(logs[-1], t_us, found, median(took))


def _counted(case: Case, tracker: DetectionTracker) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    times, counts = [np.empty(0, np.int64)], [np.empty(0, np.int64)]
    detect = tracker.detect

    def counting(events: Events, frames: NDArray[np.void]) -> NDArray[np.void]:
        found = detect(events, frames)
        times.append(events.t_us[frames["end"] - 1])
        counts.append(frames["found_end"] - frames["found"])
        return found

    tracker.detect = counting
    run("", tracker, case.recording)
    return np.concatenate(times), np.concatenate(counts)


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
    frames, _, _ = line_up(expiring(done.log, case.rule.max_age_us), case.truth, case.rule)
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


def _equal(outcomes: Sequence[Outcome]) -> tuple[Outcome | None, ...]:
    """Of each method the cheapest that reaches the target, None where none does; without truth, the cheapest."""
    by_method = {name: [one for one in outcomes if one.method == name] for name in (EVENTS, FRAMES, PIPELINE)}
    best = [max(one.hota or 0.0 for one in by_method[name]) for name in (EVENTS, FRAMES)]
    target = min(best) - _SLACK
    reached = ([one for one in own if one.hota is None or one.hota >= target] for own in by_method.values())
    return tuple(min(own, key=lambda one: one.operations, default=None) for own in reached)


def _of_size(outcomes: Sequence[Outcome], method: str, size: int) -> Outcome:
    return next(one for one in outcomes if (one.method, one.size) == (method, size))


def _quality(one: Outcome) -> str:
    return "unknown quality" if one.hota is None else f"HOTA {one.hota:.2f}, {one.position_px:.2f} px"


def _as_written(case: Case, config: MeanShiftConfig) -> float:
    """Evaluations per second of every shift against every point, nothing folded, over the first second."""
    tracker = MeanShiftTracker(replace(config, fold_px=0.0))
    first = case.recording.window(0, 1_000_000)
    run("", tracker, first)
    return tracker.cost.pairs / (first.duration_us * 1e-6)


def main() -> None:
    """Measure, print, draw."""
    parser = argparse.ArgumentParser(description="Cost and quality of clustering; tables in Markdown")
    parser.add_argument("--quick", action="store_true", help="fewer sizes, shorter scenes, no picture")
    quick = parser.parse_args().quick
    outcomes: dict[str, list[Outcome]] = {}
    cost, customary, numbers = [], [], []
    for case in _cases(Path("build") / "bench", quick):
        outcomes[case.name] = list(_outcomes(case, quick))
        chosen = _equal(outcomes[case.name])
        cost += _cost_rows(case, chosen)
        customary += _cost_rows(case, [_of_size(outcomes[case.name], *which) for which in _CUSTOMARY])
        numbers += [_number_row(case.name, one) for one in chosen if one is not None and one.hota is not None]
        print(case.name, flush=True)
    _table(
        "data", "method", "size", "HOTA", "position, px", "evaluations/s", "as written", "operations/s", "CPU s/s", rows=cost
    )
    _table("data", "method", "size", "tracks off", "right", "clusters off", "right", rows=numbers)
    if not quick:
        _draw(outcomes)
        print(_PICTURE)


def _cost_rows(case: Case, chosen: Sequence[Outcome | None]) -> list[tuple[str, ...]]:
    rows: list[tuple[str, ...]] = []
    first: tuple[float, ...] | None = None
    for one, name in zip(chosen, (EVENTS, FRAMES, PIPELINE), strict=True):
        if one is None:
            rows.append((case.name, name, "none reaches it", *[""] * 6))
            continue
        written = None
        if name != PIPELINE:
            written = _as_written(case, (_packets if name == EVENTS else _frames)(case, one.size))
        costs = (one.evaluations, written, one.operations, one.cpu)
        shown = [("" if value is None else f"{value:.2g}" if value < 1 else f"{value:.2e}") for value in costs]
        rows.append((case.name, name, one.label, _or(one.hota, ".3f"), _or(one.position_px, ".2f"), *shown))
        if name == EVENTS:
            first = costs  # type: ignore[assignment]
        elif name == FRAMES and first is not None:
            less = [f"{1 - ours / theirs:.0%}" for ours, theirs in zip(first, costs, strict=True)]  # type: ignore[operator]
            rows.append((case.name, "saved by events", "", "", "", *less))
    return rows


def _number_row(name: str, one: Outcome) -> tuple[str, ...]:
    share = [_or(value, ".0%") for value in (one.right, one.clusters_right)]
    return name, one.method, one.label, _or(one.off, ".2f"), share[0], _or(one.clusters_off, ".2f"), share[1]


def _or(value: float | None, form: str) -> str:
    return "" if value is None else format(value, form)


def _table(*head: str, rows: Sequence[Sequence[str]]) -> None:
    print()
    for row in (head, ["---"] * len(head), *rows):
        print("| " + " | ".join(row) + " |")
    print()


def _draw(outcomes: Mapping[str, Sequence[Outcome]]) -> None:
    with_truth = {name: own for name, own in outcomes.items() if own[0].hota is not None}
    figure, axes = plt.subplots(1, len(with_truth), figsize=(3.2 * len(with_truth), 3.4), layout="constrained", squeeze=False)
    for axis, (name, own) in zip(axes[0], with_truth.items(), strict=True):
        for method, marker in ((EVENTS, "o"), (FRAMES, "s"), (PIPELINE, "^")):
            line = [one for one in own if one.method == method]
            axis.plot(
                [one.cpu for one in line], [one.hota for one in line], marker=marker, linewidth=1, markersize=4, label=method
            )
            for one in line:
                axis.annotate(one.label, (one.cpu, one.hota or 0.0), (3, 3), textcoords="offset points", fontsize=5)
        axis.set(title=name, xlabel="CPU seconds per second", xscale="log")
        axis.grid(linewidth=0.3)
    axes[0][0].set_ylabel("HOTA")
    axes[0][0].legend(fontsize="x-small", loc="lower left")
    figure.savefig(_PICTURE, dpi=90)


if __name__ == "__main__":
    main()

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
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import streams
from clustering_runs import EVENTS, FRAMES, PIPELINE, Case, Outcome, as_written, cases, outcomes
from evcot.trackers.mean_shift.config import PRESETS
from evcot.trackers.mean_shift.tracker import MeanShiftTracker
from measure import Goal, Result, Timing, take_turns, timed

__all__ = ["measure"]

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
    for row in (head, ["---"] * len(head), *rows):
        print("| " + " | ".join(row) + " |")


def _draw(done: Mapping[str, Sequence[Outcome]]) -> None:
    with_truth = {name: own for name, own in done.items() if own[0].hota is not None}
    figure, axes = plt.subplots(1, len(with_truth), figsize=(3.2 * len(with_truth), 3.4), layout="constrained", squeeze=False)
    for axis, (name, own) in zip(axes[0], with_truth.items(), strict=True):
        for method, marker in ((EVENTS, "o"), (FRAMES, "s"), (PIPELINE, "^")):
            line = [one for one in own if one.method == method]
            axis.plot(
                [one.cpu for one in line], [one.hota for one in line], marker=marker, linewidth=1, markersize=4, label=method
            )
            for one in (line[0], line[-1]):
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

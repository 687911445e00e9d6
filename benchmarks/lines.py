# SPDX-License-Identifier: Apache-2.0
"""Lines in Hough space: errors and ids of bars that turn, speed; and circles, against the tracker on the events themselves.

Bars of random length, width, contrast and direction turn three quarters of a turn about a random place, in front of a
texture, with noise. `VALIDATION` are the seeds on which the follower was tuned, `TEST` those on which nothing was.

    python benchmarks/lines.py [validation | FILE]
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

import evcot
from evcot.hough.contract import HoughConfig
from evcot.hough.transform import HoughTransform
from evcot.ranges import setting
from evcot.scenes.shapes import quadrangles
from evcot.scenes.stage import StageSettings, SteadyStage, film, texture
from evcot.scenes.truth import TRUTH
from measure import Goal, Result, timed

__all__ = ["measure"]

VALIDATION = (1, 2, 3, 4, 5)
TEST = tuple(range(101, 111))
SPEEDS_RAD_S = (1.0, 2.0, 5.0, 10.0)
TURNS = 0.75
ERROR_DEG, ERROR_PX, EVENTS_PER_S = 1.5, 0.5, 2.5e6  # the goals
STEP_PX = 4  # of an angle, where a tracker follows spikes
RADIUS_PX, DIRECTIONS = 9.0, 32  # of the circles
CIRCLE_LEAK_LOG2 = {1: 5, 4: 6}  # by number of discs: the better of 5, 6, 7 on the validation seeds


@dataclass(frozen=True)
class Bars(StageSettings):
    """Bars that turn; where two overlap, one hides the other."""

    NAME: ClassVar[str] = "bars"

    count: int = setting(1, 1, 16, "how many bars")
    turn_rad_s: float = setting(1.0, 0.1, 100.0, "turning speed")


class BarStage(SteadyStage):
    """Bars at angles that grow or fall evenly."""

    def __init__(self, settings: Bars) -> None:
        rng, count = np.random.default_rng(settings.seed), settings.count
        self._length, self._width, self._first = (rng.uniform(*span, count) for span in ((100, 200), (2, 5), (0, np.pi)))
        self._x = settings.width / 2 + rng.uniform(-40, 40, count)
        self._y = settings.height / 2 + rng.uniform(-25, 25, count)
        self._turn = settings.turn_rad_s * rng.choice([-1, 1], count)
        self._intensity = np.exp(-rng.uniform(0.5, 1.2, count) * rng.choice([-1, 1], count))
        self._middle = (settings.width - 1) / 2, (settings.height - 1) / 2
        self.background = texture(settings, np.random.default_rng(settings.seed), 3.0, 0.05)

    def _angle(self, t_us: float | NDArray[np.int64]) -> NDArray[np.float64]:
        angle: NDArray[np.float64] = self._first + self._turn * np.asarray(t_us)[..., None] * 1e-6
        return angle

    def shapes(self, t_us: float | NDArray[np.int64]) -> NDArray[np.float64]:
        """See `Stage`."""
        cosine, sine = np.cos(self._angle(t_us)), np.sin(self._angle(t_us))
        along, across = np.array([1, 1, -1, -1]) / 2, np.array([1, -1, -1, 1]) / 2
        length, width = self._length[:, None] * along, self._width[:, None] * across
        x = self._x[:, None] + length * cosine[..., None] - width * sine[..., None]
        y = self._y[:, None] + length * sine[..., None] + width * cosine[..., None]
        return quadrangles(np.arange(len(self._x)), x, y, self._intensity)

    def objects(self, t_us: float | NDArray[np.int64]) -> NDArray[np.void]:
        """See `Stage`."""
        objects = np.zeros(self._angle(t_us).shape, TRUTH)
        objects["object_id"] = np.arange(len(self._x))
        objects["x"], objects["y"], objects["width"], objects["height"] = self._x, self._y, self._length, self._length
        return objects

    def truth(self, t_us: NDArray[np.int64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Angle of the normal in radians and rho in pixels of each bar, (n, bars)."""
        normal = self._angle(t_us) + np.pi / 2
        x, y = self._x - self._middle[0], self._y - self._middle[1]
        return normal, x * np.cos(normal) + y * np.sin(normal)


class Found(NamedTuple):
    """How well one bar was followed: median errors, the 90th percentile, the ids."""

    error_deg: float
    error_px: float
    error_deg_90: float
    ids: int


def bars(seed: int, turn_rad_s: float) -> tuple[BarStage, evcot.Recording]:
    """One bar through three quarters of a turn."""
    settings = Bars(seed=seed, turn_rad_s=turn_rad_s, duration_us=int(TURNS * 2e6 * np.pi / turn_rad_s))
    return BarStage(settings), film(BarStage(settings), settings).recording


def errors(
    stage: BarStage, t_us: NDArray[np.int64], angle: NDArray[np.float64], rho_px: NDArray[np.float64], ids: NDArray[Any]
) -> Found:
    """Compare measurements of one bar, angles in radians, with the truth."""
    if not len(t_us):
        return Found(90.0, 999.0, 90.0, 0)
    normal, rho = (part[:, 0] for part in stage.truth(t_us))
    half_turns = np.round((angle - normal) / np.pi)
    error_deg = np.degrees(abs(angle - normal - np.pi * half_turns))
    error_px = abs(rho_px * np.where(half_turns % 2, -1, 1) - rho)
    return Found(*map(float, (np.median(error_deg), np.median(error_px), np.quantile(error_deg, 0.9))), len(np.unique(ids)))


def by_follower(stage: BarStage, recording: evcot.Recording, angles: int = 16) -> Found:
    """`evcot.lines`."""
    lines = evcot.lines(recording, HoughConfig(recording.width, recording.height, angles))
    return errors(stage, lines["t_us"], np.radians(lines["angle_deg"]), lines["rho_px"], lines["line_id"])


def by_tracker(stage: BarStage, recording: evcot.Recording) -> Found:
    """The default tracker on the spikes, whose plane is (angle, rho)."""
    config, events = HoughConfig(recording.width, recording.height), recording.events
    spikes = HoughTransform(config).feed(events.x, events.y)
    x = STEP_PX * spikes["angle"].astype(np.uint16) + STEP_PX // 2
    plane = evcot.Events(events.t_us[spikes["event"]], x, spikes["rho"].astype(np.uint16), events.p[spikes["event"]])
    log = evcot.track(evcot.Recording(plane, STEP_PX * config.angles, 1 << config.rho_w), filters=evcot.FilterConfig())
    moves = log.records[log.records["kind"] != evcot.Kind.LOST]
    angle = (moves["x"] - STEP_PX / 2) / STEP_PX * np.pi / config.angles
    return errors(stage, moves["t_us"], angle, moves["y"] + 0.5 - (1 << config.rho_w) / 2, moves["track_id"])


@njit(cache=True)
def _circles(x, y, ring, cells, leak_log2, spikes):  # type: ignore[no-untyped-def]
    """Cells on the centre of a circle of known radius, by the rule of the lines; returns the number of spikes."""
    height, width = cells.shape
    count = 0
    for i in range(len(x)):
        period, fires = i >> leak_log2, -1
        for k in range(len(ring)):
            cx, cy = x[i] + ring[k, 0], y[i] + ring[k, 1]
            if 0 <= cx < width and 0 <= cy < height:
                cells[cy, cx] = max(cells[cy, cx], period) + 1
                if cells[cy, cx] - period >= 8 and fires < 0:
                    fires = k
        if fires >= 0:
            spikes[count, 0], spikes[count, 1], spikes[count, 2] = i, x[i] + ring[fires, 0], y[i] + ring[fires, 1]
            count += 1
            for k in range(len(ring)):
                cx, cy = x[i] + ring[k, 0], y[i] + ring[k, 1]
                if 0 <= cx < width and 0 <= cy < height:
                    cells[cy, cx] = period
    return count


def circle_scores(count: int, seed: int, transform: bool) -> tuple[float, float]:
    """HOTA of the default tracker on the spikes of a circle transform or on the events, and its median error in pixels."""
    scene = evcot.simulate("discs", seed=seed, count=count, radius_px=RADIUS_PX)
    recording, filters = scene.recording, None
    if transform:
        recording, filters = _centres(recording, CIRCLE_LEAK_LOG2[count]), evcot.FilterConfig()
    log, samples = evcot.track(recording, filters=filters), scene.truth.samples
    moves = log.records[log.records["kind"] == evcot.Kind.MOVED]
    times, places = samples["t_us"][::count], np.stack([samples["x"], samples["y"]], 1).reshape(-1, count, 2)
    now = places[np.clip(np.searchsorted(times, moves["t_us"]), 0, len(times) - 1)]
    off = np.hypot(now[:, :, 0] - moves["x"][:, None], now[:, :, 1] - moves["y"][:, None]).min(1)
    return evcot.evaluate(log, scene.truth).hota, float(np.median(off)) if len(off) else RADIUS_PX


def _centres(recording: evcot.Recording, leak_log2: int) -> evcot.Recording:
    """The spikes of the circle transform as events."""
    turn, events = np.arange(DIRECTIONS) * 2 * np.pi / DIRECTIONS, recording.events
    ring = np.rint(RADIUS_PX * np.stack([np.cos(turn), np.sin(turn)], 1)).astype(np.int64)
    cells, spikes = np.zeros((recording.height, recording.width), np.int64), np.empty((len(events), 3), np.int64)
    count = _circles(events.x.astype(np.int64), events.y.astype(np.int64), ring, cells, leak_log2, spikes)
    event, x, y = spikes[:count].T
    found = evcot.Events(events.t_us[event], x.astype(np.uint16), y.astype(np.uint16), events.p[event])
    return evcot.Recording(found, recording.width, recording.height)


def measure(_folder: Path, quick: bool) -> Iterator[Result]:
    """Medians over seeds and speeds on the test seeds; quick: on two of them."""
    seeds = TEST[:2] if quick else TEST
    runs = [bars(seed, speed) for seed in seeds for speed in SPEEDS_RAD_S]
    found = [by_follower(*run) for run in runs]
    worst = max(found, key=lambda each: each.error_deg)
    least = Goal(1, at_most=True)
    median = {name: float(np.median([getattr(each, name) for each in found])) for name in ("error_deg", "error_px")}
    yield Result("lines_error", median["error_deg"], "degrees", ERROR_DEG, "goal", goal=least, how="median of bars")
    yield Result("lines_error_worst_bar", worst.error_deg, "degrees", ERROR_DEG, "goal", goal=least)
    yield Result("lines_error_px", median["error_px"], "px", ERROR_PX, "goal", goal=least, how="median of bars")
    yield Result("lines_ids", float(np.mean([each.ids for each in found])), "ids per bar", 1.0, "goal", goal=least)
    tracked = [by_tracker(*run) for run in runs]
    yield Result("lines_by_tracker", float(np.median([each.error_deg for each in tracked])), "degrees", how="default tracker")
    for angles in (16, 32):
        yield _speed(runs[0][1], angles)
    for count in (1, 4):
        for name, transform in (("events", False), ("transform", True)):
            hota = float(np.mean([circle_scores(count, seed, transform)[0] for seed in seeds]))
            yield Result(f"circles_{count}_{name}", hota, "HOTA")


def _speed(recording: evcot.Recording, angles: int) -> Result:
    """The transform alone, median of seven."""
    events, config = recording.events, HoughConfig(recording.width, recording.height, angles)
    times = [timed(lambda: HoughTransform(config).feed(events.x, events.y)).cpu_s for _ in range(8)][1:]
    value = len(events) / float(np.median(times))
    return Result(f"lines_speed_{angles}", value, "events/s", EVENTS_PER_S, "goal", goal=Goal(1))


def print_bars(seeds: Sequence[int]) -> None:
    """A line per turning speed: medians over the bars, with the worst bar."""
    print("rad/s  degrees  worst  90 %   px    worst  ids   | default tracker: degrees  px    ids  | 32 angles: degrees  px")
    for speed in SPEEDS_RAD_S:
        runs = [bars(seed, speed) for seed in seeds]
        found, tracked, fine = (np.array([way(*run) for run in runs]) for way in (by_follower, by_tracker, _by_32))
        middle, worst = np.median(found, axis=0), found.max(axis=0)
        other, finer = np.median(tracked, axis=0), np.median(fine, axis=0)
        print(
            f"{speed:5g}  {middle[0]:7.2f}  {worst[0]:5.2f}  {middle[2]:4.2f}  {middle[1]:4.2f}  {worst[1]:5.2f}"
            f"  {found[:, 3].mean():4.2f}  | {other[0]:24.2f}  {other[1]:4.2f}  {tracked[:, 3].mean():4.1f} "
            f"| {finer[0]:18.2f}  {finer[1]:4.2f}"
        )


def _by_32(stage: BarStage, recording: evcot.Recording) -> Found:
    return by_follower(stage, recording, 32)


def print_circles(seeds: Sequence[int]) -> None:
    """Scores of the tracker on the events and on the spikes of the circle transform, with standard errors."""
    for count in (1, 4):
        for name, transform in (("events", False), ("circle transform", True)):
            scores = np.array([circle_scores(count, seed, transform) for seed in seeds])
            (hota, error_px), (hota_se, error_se) = scores.mean(0), scores.std(0, ddof=1) / len(seeds) ** 0.5
            print(f"{count} discs, {name}: HOTA {hota:.3f} +- {hota_se:.3f}, {error_px:.2f} +- {error_se:.2f} px")


def print_lines(path: str) -> None:
    """The longest lines of a recording."""
    recording = evcot.filter(evcot.read(path), refractory_us=1_000, activity_us=5_000)
    lines = evcot.lines(recording)
    first_us = recording.events.t_us[0]
    ids, counts = np.unique(lines["line_id"], return_counts=True)
    print(f"{path}: {len(ids)} lines\n   id  entries  from s  to s   angle (10, 50, 90 %)   rho px, first and last")
    for line_id in ids[np.argsort(-counts)][:12]:
        line = lines[lines["line_id"] == line_id]
        low, middle, high = np.quantile(line["angle_deg"], (0.1, 0.5, 0.9))
        begin, end = (line["t_us"][[0, -1]] - first_us) * 1e-6
        print(
            f"{line_id:5}  {len(line):7}  {begin:6.2f}  {end:5.2f}  {low:6.1f} {middle:6.1f} {high:6.1f}"
            f"   {line['rho_px'][0]:6.1f} {line['rho_px'][-1]:6.1f}"
        )


def main() -> None:
    """Print tables: of bars and circles on the test seeds, or on the validation seeds; or of a file."""
    word = "".join(sys.argv[1:])
    if word not in ("", "validation"):
        print_lines(word)
        return
    seeds = VALIDATION if word else TEST
    print(f"{'validation' if word else 'test'}, seeds {seeds[0]} to {seeds[-1]}")
    print_bars(seeds)
    print_circles(seeds)


if __name__ == "__main__":
    main()

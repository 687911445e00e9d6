# SPDX-License-Identifier: Apache-2.0
"""The Rectangular Cluster Tracker against naive implementations of its rules on random traffic: record for record without
options, and owner for owner with options of the search."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import pytest

from evcot.events import Events, Recording
from evcot.trackers.rct.config import RctConfig
from evcot.trackers.rct.motion import EXTENT_QUANTILE
from evcot.trackers.rct.tracker import RctTracker, track
from evcot.tracks.log import Kind

from .stories import events_of, object_at, together, tracked

STEP = 0.02  # of the sides of the extent, in half windows


@dataclass
class Naive:
    """A cluster of the naive tracker."""

    x: float
    y: float
    t: int
    slot: int
    events: int = 1
    taken: int = 1
    track_id: int | None = None
    vx: float = 0.0
    vy: float = 0.0
    wide: float = 0.0
    high: float = 0.0
    step: float = 0.0
    measured: tuple[float, float, int] | None = None


def naive_track(events: Events, config: RctConfig) -> tuple[list[tuple[object, ...]], list[int], list[tuple[float, float]]]:
    """The algorithm as its description reads, packet by packet, with the log put in order at the end.

    Returns records, owners, and the velocities of the clusters that are left.
    """
    t, xs, ys = events.t_us.tolist(), events.x.tolist(), events.y.tolist()
    radius, alpha = config.radius_px, config.alpha
    clusters: list[Naive] = []
    log: list[tuple[tuple[int, int, int], tuple[object, ...]]] = []
    owner: list[int] = []
    births = 0

    def write(kind: Kind, t_us: int, index: int, c: Naive, other: int = -1) -> None:
        box = max(2 * c.wide, 1.0), max(2 * c.high, 1.0), 0.0
        evidence = c.events / config.visible_events
        known = *box, c.vx, c.vy, evidence / (evidence + 1)
        row = (t_us, index, int(kind), c.track_id, c.slot, c.x, c.y, radius, *known, c.taken, c.events, other)
        log.append(((index, 0, t_us) if kind == Kind.LOST else (index, 1, 0), row))

    def show_if_due(c: Naive, index: int) -> None:
        nonlocal births
        if c.track_id is None and c.events >= config.visible_events:
            c.track_id = births
            births += 1
            write(Kind.BORN, t[index], index, c)

    def remove(now: int) -> None:
        for c in list(clusters):
            end = c.t + config.lifetime_us
            if end <= now:
                clusters.remove(c)
                if c.track_id is not None:
                    write(Kind.LOST, end, int(np.searchsorted(events.t_us, end, "left")), c)

    def measure(c: Naive, now: int) -> None:
        if c.measured is not None:
            x, y, before = c.measured
            k, seconds = config.velocity_alpha, 1e-6 * (now - before)
            c.vx = (1 - k) * c.vx + k * ((c.x - x) / seconds)
            c.vy = (1 - k) * c.vy + k * ((c.y - y) / seconds)
        c.measured = (c.x, c.y, now)

    def merge(index: int, now: int) -> None:
        while True:
            pairs = itertools.combinations(clusters, 2)
            overlap = next(((a, b) for a, b in pairs if abs(a.x - b.x) <= 2 * radius and abs(a.y - b.y) <= 2 * radius), None)
            if overlap is None:
                return
            a, b = overlap
            if b.track_id is not None and (a.track_id is None or b.track_id < a.track_id):
                a, b = b, a
            if b.track_id is not None:
                assert a.track_id is not None
                write(Kind.MERGED, t[index], index, b, a.track_id)
            total = a.events + b.events
            a.x = (a.x * a.events + b.x * b.events) / total
            a.y = (a.y * a.events + b.y * b.events) / total
            a.wide = min(max(abs(a.x - b.x) + b.wide, a.wide), radius)
            a.high = min(max(abs(a.y - b.y) + b.high, a.high), radius)
            a.vx = (a.vx * a.events + b.vx * b.events) / total
            a.vy = (a.vy * a.events + b.vy * b.events) / total
            a.measured = (a.x, a.y, now)
            a.events, a.taken, a.t = total, a.taken + b.taken, max(a.t, b.t)
            show_if_due(a, index)
            clusters.remove(b)

    packet_of = [(time - t[0]) // config.packet_us for time in t]
    for e in range(len(t)):
        holding = [c for c in clusters if max(abs(xs[e] - c.x), abs(ys[e] - c.y)) <= radius]
        if holding:
            c = min(holding, key=lambda c: max(abs(xs[e] - c.x), abs(ys[e] - c.y)))
            c.wide = max(c.wide + c.step * (float(abs(xs[e] - c.x) > c.wide) - 2 * EXTENT_QUANTILE), 0.0)
            c.high = max(c.high + c.step * (float(abs(ys[e] - c.y) > c.high) - 2 * EXTENT_QUANTILE), 0.0)
            c.x = (1 - alpha) * c.x + alpha * xs[e]
            c.y = (1 - alpha) * c.y + alpha * ys[e]
            c.t, c.events, c.taken = t[e], c.events + 1, c.taken + 1
        elif len(clusters) < config.max_clusters:
            c = Naive(float(xs[e]), float(ys[e]), t[e], min(set(range(config.max_clusters)) - {c.slot for c in clusters}))
            c.step = max(STEP, 0.1) * radius
            clusters.append(c)
        else:
            owner.append(-1)
            c = None
        if c is not None:
            owner.append(c.slot)
            show_if_due(c, e)
        last = e + 1 == len(t)
        if last or packet_of[e + 1] != packet_of[e]:
            packet_end = t[0] + (packet_of[e] + 1) * config.packet_us
            remove(t[e] if last else packet_end)
            for c in clusters:
                if c.taken:
                    measure(c, packet_end)
            merge(e, packet_end)
            for c in clusters:
                if c.taken and c.track_id is not None:
                    write(Kind.MOVED, t[e], e, c)
                if c.taken:
                    c.step = max(STEP, min(0.1, 1 / c.events)) * radius
                c.taken = 0
            if not last:
                remove(t[0] + packet_of[e + 1] * config.packet_us)
    return [row for _, row in sorted(log, key=lambda entry: entry[0])], owner, [(c.vx, c.vy) for c in clusters]


def traffic(seed: int, n: int, noise: float) -> Events:
    """Blobs on crossing orbits that fall silent in turn, noise, bursts of equal times and long pauses."""
    rng = np.random.default_rng(seed)
    t_us = np.cumsum(np.where(rng.random(n) < 0.002, rng.integers(0, 4_000, n), rng.integers(0, 20, n)))
    blob = (rng.integers(0, 4, n) + t_us // 9_000) % 6
    phase = t_us * 2e-4 + blob
    x = 64 + 45 * np.cos(phase) + rng.uniform(-4, 4, n)
    y = 64 + 45 * np.sin(2 * phase) + rng.uniform(-4, 4, n)
    stray = rng.random(n) < noise
    x, y = np.where(stray, rng.uniform(0, 128, n), x), np.where(stray, rng.uniform(0, 128, n), y)
    return Events(t_us.astype(np.int64) + 10**9, x.astype(np.uint16), y.astype(np.uint16), np.ones(n, np.uint8))


CONFIGS = {
    "roomy": RctConfig(max_clusters=16, radius_px=6.0, lifetime_us=3_000, packet_us=500),
    "crowded": RctConfig(max_clusters=3, radius_px=5.5, alpha=0.1, lifetime_us=1_500, packet_us=300),
    "life shorter than a packet": RctConfig(max_clusters=8, radius_px=7.0, alpha=0.05, lifetime_us=700, packet_us=4_000),
    "packets of one microsecond": RctConfig(max_clusters=8, radius_px=4.0, lifetime_us=2_000, packet_us=1, visible_events=2),
    "one packet": RctConfig(max_clusters=8, radius_px=8.0, lifetime_us=2_000, packet_us=10**9),
}


@pytest.mark.parametrize("noise", [0.0, 0.2])
@pytest.mark.parametrize("name", CONFIGS)
def test_record_for_record_like_the_naive_tracker(name: str, noise: float) -> None:
    config = CONFIGS[name]
    for seed in range(3):
        events = traffic(seed, 4_000, noise)
        tracker = RctTracker(config)
        records, owner = tracker.feed(events)
        rows, naive_owner, velocities = naive_track(events, config)
        assert owner.tolist() == naive_owner
        assert [*records.tolist(), *tracker.finish().tolist()] == rows
        assert tracker.clusters()[["velocity_x", "velocity_y"]].tolist() == velocities
        assert len(rows) > 5


@pytest.mark.parametrize(
    ("radius_px", "alpha", "max_clusters", "blobs"),
    [(6.0, 0.01, 200, 90), (40.0, 0.2, 64, 20), (9.5, 1.0, 30, 10), (400.0, 0.5, 3, 10), (12.0, 0.05, 80, 5)],
)
def test_like_the_naive_tracker_over_a_wide_sensor(radius_px: float, alpha: float, max_clusters: int, blobs: int) -> None:
    """Ways over many of the lookup's cells and beyond their end, more clusters than a word holds, windows wider than all."""
    config = RctConfig(max_clusters=max_clusters, radius_px=radius_px, alpha=alpha, lifetime_us=20_000, packet_us=700)
    rng = np.random.default_rng(5)
    n = 3_000
    t_us = np.cumsum(rng.integers(0, 80, n))
    blob = rng.integers(0, blobs, n)
    ways = rng.uniform(0, [1280, 720], (blobs, 2)) + rng.uniform(-2_000, 2_000, (blobs, 2)) * t_us[:, None, None] * 1e-6
    x, y = np.abs(ways[np.arange(n), blob] + rng.uniform(-5, 5, (n, 2))).T
    events = Events(t_us, x.astype(np.uint16), y.astype(np.uint16), np.ones(n, np.uint8))
    tracker = RctTracker(config)
    records, owner = tracker.feed(events)
    rows, naive_owner, _ = naive_track(events, config)
    assert owner.tolist() == naive_owner
    assert [*records.tolist(), *tracker.finish().tolist()] == rows


def test_the_traffic_exercises_every_kind_of_record_and_keeps_the_log_in_order() -> None:
    events = traffic(0, 4_000, 0.2)
    records = track(Recording(events, 128, 128), CONFIGS["roomy"]).records
    assert (np.bincount(records["kind"], minlength=4) > 10).all()
    assert (np.diff(records["t_us"]) >= 0).all()
    assert (np.diff(records["event_index"]) >= 0).all()
    caused = records[records["kind"] != Kind.LOST]
    assert (events.t_us[caused["event_index"]] == caused["t_us"]).all()


@pytest.mark.parametrize("name", CONFIGS)
def test_the_log_does_not_depend_on_where_the_stream_is_cut(name: str) -> None:
    config = CONFIGS[name]
    events = traffic(7, 6_000, 0.1)
    whole = track(Recording(events, 128, 128), config)
    rng = np.random.default_rng(8)
    for cuts in (np.arange(1, 6_000), np.sort(rng.integers(0, 6_000, 40)), np.array([6_000])):
        tracker = RctTracker(config)
        runs = [tracker.feed(events[begin:end]) for begin, end in zip([0, *cuts], [*cuts, 6_000], strict=True)]
        records = np.concatenate([*(run[0] for run in runs), tracker.finish()])
        np.testing.assert_array_equal(records, whole.records)
        np.testing.assert_array_equal(np.concatenate([run[1] for run in runs]), whole.owner)


def test_shifting_the_recording_in_time_shifts_the_log() -> None:
    events = traffic(3, 4_000, 0.1)
    later = Events(events.t_us + 123_456_789, events.x, events.y, events.p)
    a = track(Recording(events, 128, 128), CONFIGS["roomy"]).records
    b = track(Recording(later, 128, 128), CONFIGS["roomy"]).records.copy()
    b["t_us"] -= 123_456_789
    np.testing.assert_array_equal(a, b)


# Nothing merges and nothing ends, so that owners tell of the search alone.
ALONE = RctConfig(max_clusters=8, radius_px=10.0, alpha=0.1, merge_overlap=2.0, lifetime_us=10**9)


def naive_owners(rows: list[tuple[int, int, int]], config: RctConfig) -> list[int]:
    """The rules of the search, with places mixed by alpha."""
    clusters: list[list[float]] = []  # x, y
    owners = []
    for _, x, y in rows:

        def off(c: list[float], x: int = x, y: int = y) -> tuple[float, float]:
            return abs(x - c[0]), abs(y - c[1])

        half_x, half_y = config.radius_px, config.radius_px * config.aspect
        holding = [c for c in clusters if off(c)[0] <= half_x and off(c)[1] <= half_y]
        near = [c for c in clusters if off(c)[0] <= config.surround * half_x and off(c)[1] <= config.surround * half_y]
        if holding:
            c = holding[0] if config.assign == "first" else min(holding, key=lambda c: max(off(c)))
            c[0], c[1] = (1 - config.alpha) * c[0] + config.alpha * x, (1 - config.alpha) * c[1] + config.alpha * y
            owners.append(next(i for i, other in enumerate(clusters) if other is c))
        elif near or len(clusters) == config.max_clusters:
            owners.append(-1)
        else:
            clusters.append([x, y])
            owners.append(len(clusters) - 1)
    return owners


@pytest.mark.parametrize(
    "options",
    [{}, {"assign": "first"}, {"surround": 1.7}, {"aspect": 0.5}, {"aspect": 3.0, "surround": 1.2, "assign": "first"}],
    ids=str,
)
def test_owner_for_owner_like_the_naive_search(options: dict[str, object]) -> None:
    config = replace(ALONE, **options)  # type: ignore[arg-type]
    rng = np.random.default_rng(3)
    n = 4_000
    rows = list(zip(range(n), *rng.integers(0, 50, (2, n)).tolist(), strict=True))
    owners = naive_owners(rows, config)
    assert tracked(events_of(rows), config)[1].tolist() == owners
    assert len(set(owners)) >= 4


def test_full_options_do_not_depend_on_where_the_stream_is_cut() -> None:
    events = together(
        object_at((100, 100), (300, 50)), object_at((300, 200), (-200, 20), seed=2), object_at((600, 600), seed=3)
    )
    config = RctConfig(
        radius_px=14.0, box_quantile=0.05, dynamic_size=True, path_points=12, predict=1.0, surround=1.5, visible_rate_hz=1e3,
        birth_spread_px=1.0, merge_overlap=0.3, coast_us=30_000, aspect=1.1, vanishing_y_px=-500.0, reference_y_px=300.0,
    )  # fmt: skip
    whole = tracked(events, config)[0]
    tracker = RctTracker(config, 1000, 1000)
    cuts = [0, 1, 2, *np.sort(np.random.default_rng(4).integers(3, len(events), 50)).tolist(), len(events)]
    parts = [tracker.feed(events[a:b])[0] for a, b in pairwise(cuts)]
    np.testing.assert_array_equal(np.concatenate([*parts, tracker.finish()]), whole)
    assert len(whole) > 1_000


SEATS = 64  # of a tracker with few clusters
CONFIG = RctConfig(max_clusters=8, radius_px=10.0, lifetime_us=1_500, surround=1.7)


def strays(n: int) -> list[tuple[int, int, int]]:
    """Single events, a millisecond apart, at distant positions: each takes a seat and is soon removed."""
    return [(1_000 * k, 700, 90 * (k % 11)) for k in range(n)]


@pytest.mark.parametrize("assign", ["nearest", "first"])
def test_an_old_cluster_keeps_its_window_and_its_surround_in_which_nothing_is_seeded(assign: str) -> None:
    short = tracked(events_of([(0, 100, 100), (1, 114, 100), (2, 116, 100)]), replace(ALONE, surround=1.5))[1]
    assert short.tolist() == [0, -1, 1]
    rows = [row for t, x, y in strays(5 * SEATS) for row in ((t, 300, 300), (t + 1, 300, 312), (t + 2, x, y))]
    owners = tracked(events_of(rows), replace(CONFIG, assign=assign))[1].reshape(-1, 3)
    assert (owners[:, :2] == (0, -1)).all()
    assert set(owners[:, 2].tolist()) == {1, 2}

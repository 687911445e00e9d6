# SPDX-License-Identifier: Apache-2.0
"""Which cluster takes an event, with options: against a naive implementation, and as stories."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from evcot.trackers.rct.config import RctConfig
from evcot.trackers.rct.tracker import RctTracker

from .stories import events_of, object_at, together, tracked

# Nothing merges and nothing ends, so that owners tell of the search alone.
ALONE = RctConfig(max_clusters=8, radius_px=10.0, alpha=0.1, merging=False, lifetime_us=10**9)


def naive_owners(rows: list[tuple[int, int, int, int]], config: RctConfig) -> list[int]:
    """The rules of the search, with places mixed by alpha."""
    clusters: list[list[float]] = []  # x, y, polarity
    owners = []
    for _, x, y, p in rows:
        if config.polarity in ("on", "off") and p != (config.polarity == "on"):
            owners.append(-1)
            continue

        def off(c: list[float], x: int = x, y: int = y) -> tuple[float, float]:
            return abs(x - c[0]), abs(y - c[1])

        half_x, half_y = config.radius_px, config.radius_px * config.aspect
        far = {
            "chebyshev": lambda c: max(off(c)),
            "manhattan": lambda c: sum(off(c)),
            "euclidean": lambda c: float(np.hypot(*off(c))),
        }[config.distance]
        mine = [c for c in clusters if config.polarity != "separate" or c[2] == p]
        holding = [c for c in mine if off(c)[0] <= half_x and off(c)[1] <= half_y]
        near = [c for c in mine if off(c)[0] <= config.surround * half_x and off(c)[1] <= config.surround * half_y]
        if holding:
            c = holding[0] if config.assign == "first" else min(holding, key=far)
            c[0], c[1] = (1 - config.alpha) * c[0] + config.alpha * x, (1 - config.alpha) * c[1] + config.alpha * y
            owners.append(next(i for i, other in enumerate(clusters) if other is c))
        elif near or len(clusters) == config.max_clusters or not config.seeding:
            owners.append(-1)
        else:
            clusters.append([x, y, p])
            owners.append(len(clusters) - 1)
    return owners


@pytest.mark.parametrize(
    "options",
    [
        {"distance": "manhattan"},
        {"distance": "euclidean"},
        {"assign": "first"},
        {"surround": 1.7},
        {"aspect": 0.5, "distance": "manhattan"},
        {"aspect": 3.0, "surround": 1.2, "assign": "first"},
        {"polarity": "on"},
        {"polarity": "off"},
        {"polarity": "separate", "surround": 1.3},
        {"seeding": False},
    ],
    ids=str,
)
def test_owner_for_owner_like_the_naive_search(options: dict[str, object]) -> None:
    config = replace(ALONE, **options)  # type: ignore[arg-type]
    rng = np.random.default_rng(3)
    n = 4_000
    rows = list(zip(range(n), *rng.integers(0, 50, (2, n)).tolist(), rng.integers(0, 2, n).tolist(), strict=True))
    owners = naive_owners(rows, config)
    events = events_of([row[:3] for row in rows], [row[3] for row in rows])
    assert tracked(events, config)[1].tolist() == owners
    assert len(set(owners)) >= (4 if config.seeding else 1)


def test_the_distances_differ_where_they_should() -> None:
    """Off by (6, 6) and by (8, 0): Chebyshev takes the first, Manhattan the second; (6, 6) is also the longer way as a line."""
    rows = [(0, 106, 106), (1, 92, 100), (2, 100, 100)]
    owners = {
        name: tracked(events_of(rows), replace(ALONE, distance=name))[1][2] for name in ("chebyshev", "manhattan", "euclidean")
    }
    assert owners == {"chebyshev": 0, "manhattan": 1, "euclidean": 1}


def test_an_event_in_the_surround_seeds_nothing() -> None:
    rows = [(0, 100, 100), (1, 114, 100), (2, 116, 100)]
    assert tracked(events_of(rows), replace(ALONE, surround=1.5))[1].tolist() == [0, -1, 1]


def test_without_seeding_only_clusters_set_up_by_hand_live() -> None:
    tracker = RctTracker(replace(ALONE, seeding=False))
    assert tracker.place(50.0, 60.0, 0) == 0
    _, owner = tracker.feed(events_of([(1, 52, 60), (2, 200, 200), (3, 48, 62)]))
    assert owner.tolist() == [0, -1, 0]
    (cluster,) = tracker.clusters()
    assert cluster["events"] == 2
    assert cluster["x"] == pytest.approx(0.9 * (0.9 * 50 + 0.1 * 52) + 0.1 * 48)


def test_objects_of_either_polarity_on_the_same_place_are_two() -> None:
    rows = [(i, 100, 100) for i in range(10)]
    owner = tracked(events_of(rows, [0, 1] * 5), replace(ALONE, polarity="separate", merging=True))[1]
    assert owner.tolist() == [0, 1] * 5


def test_a_turned_window_holds_what_lies_along_it() -> None:
    """A thin diagonal: once its cluster has turned, the corners of an upright window no longer belong to it."""
    rng = np.random.default_rng(1)
    along = rng.uniform(-20, 20, 6_000)
    bar = events_of([(10 * i, round(200 + a), round(200 + a)) for i, a in enumerate(along)])
    config = RctConfig(
        max_clusters=1, radius_px=22.0, visible_events=100, size="deviation", size_ratio=2.5, angle=True, free_aspect=True
    )
    tracker = RctTracker(config)
    tracker.feed(bar)
    (cluster,) = tracker.clusters()
    assert cluster["angle"] % np.pi == pytest.approx(np.pi / 4, abs=0.02)
    assert cluster["half_width"] == pytest.approx(2.5 * 10 * np.sqrt(2), rel=0.1)
    assert cluster["half_height"] == config.radius_min_px
    _, owner = tracker.feed(events_of([(60_001, 218, 218), (60_002, 215, 185), (60_003, 185, 185)]))
    assert owner.tolist() == [0, -1, 0]


def test_full_options_do_not_depend_on_where_the_stream_is_cut() -> None:
    events = together(
        object_at((100, 100), (300, 50)), object_at((300, 200), (-200, 20), seed=2), object_at((600, 600), seed=3)
    )
    config = RctConfig(
        radius_px=14.0, centre="box", size="quantile", size_ratio=1.4, free_aspect=True, velocity="regression", path_points=12,
        predict=1.0, friction_tau_us=10_000.0, surround=1.5, visibility="mass", birth_spread_px=1.0, merge_overlap=0.3,
        merge_angle_deg=60.0, coast_us=30_000, split_share=0.02, border_share=0.5, support_rate_hz=10.0,
    )  # fmt: skip
    whole = tracked(events, config)[0]
    tracker = RctTracker(config, 1000, 1000)
    cuts = [0, 1, 2, *np.sort(np.random.default_rng(4).integers(3, len(events), 50)).tolist(), len(events)]
    parts = [tracker.feed(events[a:b])[0] for a, b in pairwise(cuts)]
    np.testing.assert_array_equal(np.concatenate([*parts, tracker.finish()]), whole)
    assert len(whole) > 1_000

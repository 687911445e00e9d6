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


def test_an_event_in_the_surround_seeds_nothing() -> None:
    rows = [(0, 100, 100), (1, 114, 100), (2, 116, 100)]
    assert tracked(events_of(rows), replace(ALONE, surround=1.5))[1].tolist() == [0, -1, 1]


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
def test_an_old_cluster_keeps_its_window_and_its_surround(assign: str) -> None:
    rows = [row for t, x, y in strays(5 * SEATS) for row in ((t, 300, 300), (t + 1, 300, 312), (t + 2, x, y))]
    owners = tracked(events_of(rows), replace(CONFIG, assign=assign))[1].reshape(-1, 3)
    assert (owners[:, :2] == (0, -1)).all()
    assert set(owners[:, 2].tolist()) == {1, 2}

# SPDX-License-Identifier: Apache-2.0
"""Records have the object's box, velocity and confidence."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from evcot.trackers.rct.config import RctConfig
from evcot.tracks.log import Kind

from .stories import events_of, object_at, of_kind, still, together, tracked

PLAIN = RctConfig(radius_px=24.0, max_clusters=1)
BOXED = replace(PLAIN, box_quantile=0.05)


@pytest.mark.parametrize("half", [(5.0, 5.0), (20.0, 6.0), (4.0, 18.0)])
@pytest.mark.parametrize("config", [PLAIN, BOXED, replace(PLAIN, surround=1.5)], ids=["plain", "box", "options"])
def test_the_box_is_the_events_extent_and_not_the_window(half: tuple[float, float], config: RctConfig) -> None:
    """Evenly full: nine tenths of the events lie within nine tenths of each side."""
    records = tracked(object_at((200, 200), half=half), config)[0][-100:]
    assert float(records["width"].mean()) == pytest.approx(0.9 * 2 * half[0], rel=0.15)
    assert float(records["height"].mean()) == pytest.approx(0.9 * 2 * half[1], rel=0.15)
    assert (records["angle"] == 0).all()


@pytest.mark.parametrize("config", [PLAIN, BOXED], ids=["plain", "box"])
def test_an_outline_has_the_box_around_it(config: RctConfig) -> None:
    records = tracked(object_at((200, 200), half=(10, 8), hollow=True), config)[0][-100:]
    assert float(records["width"].mean()) == pytest.approx(20, abs=2)


def test_the_box_goes_with_a_fast_object() -> None:
    records = tracked(object_at((100, 500), (600, 0), half=(8, 5)), replace(PLAIN, alpha=0.1))[0][-100:]
    assert float(records["width"].mean()) == pytest.approx(0.9 * 16, rel=0.25)
    assert float(records["height"].mean()) == pytest.approx(0.9 * 10, rel=0.25)


def test_a_young_box_grows_quickly() -> None:
    """After a millisecond with 20 events it is more than half as large as the object."""
    records = tracked(object_at((200, 200), half=(12, 12)), PLAIN)[0]
    first = of_kind(records, Kind.MOVED)[1]
    assert min(first["width"], first["height"]) > 12


def test_a_box_has_at_least_a_pixel() -> None:
    records = tracked(events_of(still(50, 60, n=40, step_us=100)), PLAIN)[0]
    assert set(records["width"]) == set(records["height"]) == {1.0}


def test_the_velocity_is_0_until_it_is_known_and_then_the_clusters() -> None:
    records, _, (cluster,) = tracked(object_at((200, 200), (150, -90), half=(6, 6)), replace(PLAIN, velocity_alpha=0.01))
    assert of_kind(records, Kind.BORN)[["vx", "vy"]].tolist() == [(0.0, 0.0)]
    assert records[-1][["vx", "vy"]].item() == cluster[["velocity_x", "velocity_y"]].item()
    assert records[-1]["vx"] == pytest.approx(150, abs=15)


def test_the_merged_box_covers_both_within_the_window() -> None:
    """40 px apart, half the sides of the windows are 22 px."""
    parts = object_at((200, 200), half=(3, 3)), object_at((240, 200), half=(3, 3), us=(100_000, 1_000_000), seed=2)
    config = RctConfig(radius_px=22.0, merge_overlap=0.0, max_clusters=2)
    records = tracked(together(*parts), config)[0]
    merged = of_kind(records, Kind.MERGED)[0]
    after = records[(records["event_index"] == merged["event_index"]) & (records["kind"] == Kind.MOVED)]
    assert after["width"].tolist() == pytest.approx([44.0])
    assert after["height"][0] < 12


def test_confidence_is_one_half_where_a_cluster_becomes_visible_and_rises() -> None:
    confidence = tracked(object_at((200, 200), rate_hz=100_000), replace(PLAIN, visible_events=40))[0]["confidence"]
    assert confidence[0] == 0.5
    assert (np.diff(confidence) >= 0).all()
    assert 0.95 < confidence[-1] < 1


def test_confidence_by_rate_falls_with_the_rate() -> None:
    rates = (40_000.0, 4_000.0)
    parts = [object_at((200, 200), us=(i * 400_000, (i + 1) * 400_000), rate_hz=r, seed=i) for i, r in enumerate(rates)]
    config = replace(PLAIN, visible_rate_hz=4_000.0)
    records = tracked(together(*parts), config)[0]
    high, low = (
        float(records["confidence"][(records["t_us"] > b) & (records["t_us"] < b + 200_000)].mean()) for b in (2e5, 6e5)
    )
    assert high == pytest.approx(40 / 44, abs=0.03)
    assert low == pytest.approx(0.5, abs=0.05)

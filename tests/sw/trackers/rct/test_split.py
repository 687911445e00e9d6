# SPDX-License-Identifier: Apache-2.0
"""A cluster whose events form two groups is split."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.trackers.rct.config import RctConfig
from evcot.tracks.log import Kind

from .stories import object_at, of_kind, together, tracked

CONFIG = RctConfig(
    radius_px=20.0, size="deviation", size_ratio=2.0, free_aspect=True, radius_max_px=40.0, split_share=0.05, merge_overlap=0.1,
    alpha=0.02, visible_events=50,
)  # fmt: skip


def parting(axis: tuple[float, float]) -> tuple[NDArray[np.void], NDArray[np.void]]:
    """Two objects that are one for 200 ms and then go apart at 60 px/s each; what the tracker makes of them."""
    vx, vy = 40 * axis[0], 40 * axis[1]
    one = object_at((300, 300), half=(5, 5), us=(0, 200_000))
    back, fore = (300 - 0.2 * vx, 300 - 0.2 * vy), (300 + 0.2 * vx, 300 + 0.2 * vy)
    parts = [object_at(fore, (-vx, -vy), half=(5, 5), us=(200_000, 900_000), seed=2),
             object_at(back, (vx, vy), half=(5, 5), us=(200_000, 900_000), seed=3)]  # fmt: skip
    records, _, clusters = tracked(together(one, *parts), CONFIG)
    return records, clusters


@pytest.mark.parametrize("axis", [(1.0, 0.0), (0.0, 1.0)])
def test_two_that_part_become_two_and_the_older_keeps_its_track(axis: tuple[float, float]) -> None:
    records, clusters = parting(axis)
    assert of_kind(records, Kind.BORN)["track_id"].tolist() == [0, 1]
    assert len(of_kind(records, Kind.LOST)) == len(of_kind(records, Kind.MERGED)) == 0
    way = 40 * 0.7
    ends = sorted((float(c["x"]), float(c["y"])) for c in clusters)
    expected = sorted((300 + sign * way * axis[0], 300 + sign * way * axis[1]) for sign in (-1, 1))
    assert np.array(ends) == pytest.approx(np.array(expected), abs=3)
    assert (clusters["half_width"] < 15).all()


@pytest.mark.parametrize("ahead", [1, -1])
@pytest.mark.parametrize("seed", [1, 2])
def test_the_group_ahead_keeps_the_track(ahead: int, seed: int) -> None:
    """Two edges, one 18 px behind the other, at 100 px/s; they are taken for two when the velocity has settled."""
    edges = object_at((500, 300), (100 * ahead, 0), half=(9, 5), us=(0, 240_000), hollow=True, seed=seed)
    settled = replace(CONFIG, velocity_alpha=0.005, split_packets=200, split_share=0.15, radius_min_px=12.0)
    _, _, clusters = tracked(edges, settled)
    places = {int(c["track_id"]): float(c["x"]) for c in clusters}
    assert places == pytest.approx({0: 500 + 33 * ahead, 1: 500 + 15 * ahead}, abs=2)


def test_a_full_object_stays_one() -> None:
    records, _, clusters = tracked(object_at((300, 300), half=(14, 5)), CONFIG)
    assert len(of_kind(records, Kind.BORN)) == len(clusters) == 1


def test_it_must_last() -> None:
    records, _, _ = tracked(object_at((300, 300), half=(9, 5), hollow=True, us=(0, 100_000)), CONFIG)
    assert len(of_kind(records, Kind.BORN)) == 2
    patient = replace(CONFIG, split_packets=1_000)
    assert len(of_kind(tracked(object_at((300, 300), half=(9, 5), hollow=True, us=(0, 100_000)), patient)[0], Kind.BORN)) == 1

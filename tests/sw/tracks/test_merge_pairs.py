# SPDX-License-Identifier: Apache-2.0
"""Merges paired run by run are paired as all at once, whatever the runs."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.tracks import merge_pairs
from evcot.tracks.merge_pairs import pair_merges
from evcot.tracks.pairing import closest_pairs
from evcot.tracks.timeline import MERGE

RADIUS_PX, TOLERANCE_US = 6.0, 500


def random_merges(rng: np.random.Generator, count: int) -> NDArray[np.void]:
    merges = np.zeros(count, MERGE)
    merges["t_us"] = np.sort(rng.integers(0, 100 * count, count))
    merges["track_id"] = rng.permutation(count)
    merges["x"], merges["y"] = rng.random((2, count)) * 12
    return merges


def all_at_once(hw: NDArray[np.void], sw: NDArray[np.void]) -> list[tuple[int, int]]:
    late_us = sw["t_us"] - hw["t_us"][:, None]
    distance_px = np.hypot(sw["x"] - hw["x"][:, None], sw["y"] - hw["y"][:, None])
    i, j = np.nonzero((np.abs(late_us) <= TOLERANCE_US) & (distance_px <= RADIUS_PX))
    chosen = closest_pairs(i, j, np.abs(late_us[i, j]) / TOLERANCE_US + distance_px[i, j] / RADIUS_PX)
    return list(zip(i[chosen].tolist(), j[chosen].tolist(), strict=True))


@pytest.mark.parametrize("run", [1, 7, 1 << 14])
@pytest.mark.parametrize("seed", range(4))
def test_runs_do_not_matter(seed: int, run: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(merge_pairs, "_RUN", run)
    rng = np.random.default_rng(seed)
    hw, sw = (random_merges(rng, count) for count in rng.integers(60, 120, 2))
    wanted = all_at_once(hw, sw)
    assert 10 < len(wanted) < min(len(hw), len(sw))
    found = pair_merges(hw, sw, RADIUS_PX, TOLERANCE_US, None)
    assert list(zip(found.pairs["i"].tolist(), found.pairs["j"].tolist(), strict=True)) == wanted
    assert found.count == len(wanted)
    assert found.pairs["hardware_id"].tolist() == [hw["track_id"][i] for i, _ in wanted]
    assert found.pairs["software_id"].tolist() == [sw["track_id"][j] for _, j in wanted]
    assert found.hardware_alone.tolist() == np.delete(hw["track_id"], [i for i, _ in wanted]).tolist()
    assert found.software_alone.tolist() == np.delete(sw["track_id"], [j for _, j in wanted]).tolist()
    first = pair_merges(hw, sw, RADIUS_PX, TOLERANCE_US, 5)
    assert first.count == len(wanted)
    assert np.array_equal(first.pairs, found.pairs[:5])
    assert first.hardware_alone.tolist() == found.hardware_alone[:5].tolist()
    assert first.software_alone.tolist() == found.software_alone[:5].tolist()


def test_a_side_without_merges_leaves_the_other_alone() -> None:
    merges, none = random_merges(np.random.default_rng(1), 9), np.empty(0, MERGE)
    assert pair_merges(none, merges, RADIUS_PX, TOLERANCE_US, None).software_alone.tolist() == merges["track_id"].tolist()
    assert pair_merges(merges, none, RADIUS_PX, TOLERANCE_US, None).hardware_alone.tolist() == merges["track_id"].tolist()

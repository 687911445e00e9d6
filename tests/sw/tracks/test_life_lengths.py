# SPDX-License-Identifier: Apache-2.0
"""The median of lengths that are read run by run is that of all of them, to the last digit."""

from __future__ import annotations

import numpy as np
import pytest

from evcot.tracks import column
from evcot.tracks.life_lengths import life_lengths
from evcot.tracks.log import Kind
from evcot.tracks.track_pairs import ROW


@pytest.mark.parametrize("count", [1, 2, 7, 50])
@pytest.mark.parametrize("longest_us", [0, 5, 1 << 16, 3_000_000, 1 << 44])
def test_they_are_those_of_numpy(count: int, longest_us: int) -> None:
    rng = np.random.default_rng(count + longest_us)
    lives = column.HeldColumn(ROW)
    lives.append(np.zeros(0, ROW))
    for _ in range(3):
        part = np.zeros(count, ROW)
        part["birth_us"] = rng.integers(0, 1_000, count)
        part["end_us"] = part["birth_us"] + rng.integers(0, longest_us + 1, count)
        part["ended"] = rng.integers(-1, 4, count)
        lives.append(part)
    rows = lives[:]
    lengths_s = (rows["end_us"] - rows["birth_us"]) / 1e6
    assert life_lengths(lives) == {
        "tracks": 3 * count,
        "lost": int((rows["ended"] == Kind.LOST).sum()),
        "median_s": float(np.median(lengths_s)),
        "longest_s": float(lengths_s.max()),
    }


def test_without_a_life_nothing_is_known() -> None:
    assert life_lengths(column.HeldColumn(ROW)) == {"tracks": 0, "lost": 0, "median_s": None, "longest_s": None}

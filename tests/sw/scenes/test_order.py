# SPDX-License-Identifier: Apache-2.0
"""Keys are converted to events in a unique order, independent of their input order."""

from __future__ import annotations

import numpy as np
import pytest

from evcot.scenes._order import KEY_T_SHIFT, events_of


def keys_of(count: int, span_us: int, side: int, seed: int) -> np.ndarray:
    random = np.random.default_rng(seed)
    t_us, x, y, p = (random.integers(0, high, count) for high in (span_us, side, side, 2))
    return 1_000 + t_us << KEY_T_SHIFT | x << 17 | y << 1 | p


@pytest.mark.parametrize("count", [0, 1, 2, 20_000])
@pytest.mark.parametrize("span_us", [1, 50, 3_000, 2**30 - 1_000])
@pytest.mark.parametrize("side", [2, 65_536])
def test_events_come_by_time_then_x_then_y_then_polarity(count: int, span_us: int, side: int) -> None:
    """Few or many, of one microsecond or of 18 minutes, with equals among them."""
    keys = keys_of(count, span_us, side, seed=count)
    given = keys.copy()
    events = events_of(keys, 2**30)
    ordered = np.sort(keys)
    np.testing.assert_array_equal(events.t_us, ordered >> KEY_T_SHIFT)
    np.testing.assert_array_equal(events.x, ordered >> 17 & 0xFFFF)
    np.testing.assert_array_equal(events.y, ordered >> 1 & 0xFFFF)
    np.testing.assert_array_equal(events.p, ordered & 1)
    np.testing.assert_array_equal(keys, given)


def test_events_at_the_end_or_later_are_left_out() -> None:
    keys = np.array([[t << KEY_T_SHIFT | x << 17 for x in range(300)] for t in (7, 9, 10, 11)]).ravel()
    assert np.unique(events_of(keys, 10).t_us).tolist() == [7, 9]

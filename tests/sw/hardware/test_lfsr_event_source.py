# SPDX-License-Identifier: Apache-2.0
"""The model of the event source: distribution and rate of its events, and refused parameters."""

from __future__ import annotations

import numpy as np
import pytest

from evcot.errors import ConfigError
from evcot.hardware.lfsr import Lfsr
from evcot.hardware.lfsr_event_source import LfsrEventSource


def test_candidates_are_slices_of_the_state() -> None:
    source = LfsrEventSource(0, 511, 0, 511, gap=2, seed=77)
    states = Lfsr(32, seed=77).states(300)[1::3]  # after 2, 5, 8 … steps
    events = source.events(100)
    assert events.t_us.tolist() == list(range(2, 302, 3))
    assert np.array_equal(events.x, states & 511)
    assert np.array_equal(events.y, states >> 9 & 511)
    assert np.array_equal(events.p, states >> 18 & 1)


def test_events_are_uniform_over_an_odd_window() -> None:
    events = LfsrEventSource(10, 18, 300, 6, gap=18, seed=5).events(19 * 7 * 1000)
    pixels = np.bincount((events.y.astype(int) - 300) * 19 + events.x - 10, minlength=19 * 7)
    assert pixels.size == 19 * 7
    # Chi squared with 132 degrees of freedom: mean 132, standard deviation 16.
    assert 80 < np.sum((pixels - 1000.0) ** 2) / 1000 < 190
    assert abs(events.p.mean() - 0.5) < 0.005
    neighbours = np.corrcoef(events.x[:-1], events.x[1:])[0, 1]
    assert abs(neighbours) < 0.01


def test_candidates_outside_the_window_are_dropped() -> None:
    """A span of 4 needs three bits, of whose eight values five are inside: 5/8 per axis."""
    events = LfsrEventSource(0, 4, 0, 4, gap=18, seed=5).events(50_000)
    accepted = len(events) / (events.t_us[-1] / 19)
    assert accepted == pytest.approx(25 / 64, rel=0.02)


def test_the_start_of_a_sequence_does_not_depend_on_its_length() -> None:
    source = LfsrEventSource(3, 9, 4, 11, seed=123)
    long, short = source.events(1000), source.events(10)
    assert np.array_equal(long[:10].x, short.x)
    assert np.array_equal(long[:10].t_us, short.t_us)
    assert len(source.events(0)) == 0


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("x_w", 0, "x_w = 0: must be at least 1"),
        ("y_w", 0, "y_w = 0: must be at least 1"),
        ("gap_w", 0, "gap_w = 0: must be at least 1"),
        ("lfsr_w", 18, "lfsr_w = 18: must be from x_w + y_w + 1 = 19 to 64"),
        ("lfsr_w", 65, "lfsr_w = 65: must be from x_w + y_w + 1 = 19 to 64"),
        ("seed", 2**32 - 1, "seed = 0xffffffff: must be from 0 to 0xfffffffe"),
        ("gap", 65536, "gap = 65536: must be from 0 to 65535"),
        ("gap", -1, "gap = -1: must be from 0 to 65535"),
        ("x_min", 503, "x_min, x_span = 503, 9: must not be negative, and their sum must be below 512"),
        ("y_span", -1, "y_min, y_span = 0, -1: must not be negative, and their sum must be below 512"),
    ],
)
def test_refuses(field: str, value: int, message: str) -> None:
    legal = {"x_min": 0, "x_span": 9, "y_min": 0, "y_span": 9}
    with pytest.raises(ConfigError) as error:
        LfsrEventSource(**(legal | {field: value}))
    assert message in str(error.value)


def test_says_when_no_event_ever_comes() -> None:
    """A gap of one period less one reads the same state for ever: here one outside the window."""
    outside = next(seed for seed in range(15) if Lfsr(4, seed).states(14)[-1] & 3 == 3)
    with pytest.raises(ConfigError, match="gap = 14: no event in a whole period of the 4-bit LFSR"):
        LfsrEventSource(0, 2, 0, 0, gap=14, seed=outside, x_w=2, y_w=1, lfsr_w=4).events(1)

# SPDX-License-Identifier: Apache-2.0
"""Durations: the last ones exactly, all of them to about a hundredth."""

from __future__ import annotations

import numpy as np
import pytest

from evcot_cosim.live.latency import Latency


def test_before_the_first_nothing_is_known() -> None:
    assert Latency().recent_ms(0.5) is None
    assert Latency().overall_ms(0.5) is None


def test_quantiles() -> None:
    latency = Latency()
    durations_s = np.random.default_rng(1).lognormal(-4, 1, 20_000)
    for part in np.split(durations_s, 100):
        latency.add(part)
    for share in (0.5, 0.99):
        assert latency.recent_ms(share) == pytest.approx(1e3 * np.quantile(durations_s[-2_000:], share))
        assert latency.overall_ms(share) == pytest.approx(1e3 * np.quantile(durations_s, share), rel=0.02)


def test_what_no_clock_can_mean_stays_in_range() -> None:
    latency = Latency()
    latency.add(np.array([-1.0, 0.0, 1e9]))
    assert latency.overall_ms(0.3) == pytest.approx(1e-3, rel=0.02)
    assert latency.overall_ms(1.0) == pytest.approx(1e6, rel=0.02)

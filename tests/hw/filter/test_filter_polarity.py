# SPDX-License-Identifier: Apache-2.0
"""filter_polarity.v: the events of one polarity stay."""

from __future__ import annotations

import numpy as np
import pytest

from evcot_cosim.devices.base import Stalls
from evcot_cosim.devices.filter_device import FilterDevice
from support.filter_trials import compare_with_reference, filter_traffic
from support.testing import lint


def polarity_filter(polarity: int, *, enable: int = 1) -> FilterDevice:
    return FilterDevice("filter_polarity", {"X_W": 5, "Y_W": 4, "TICK_W": 4}, {"enable": enable, "polarity": polarity})


@pytest.mark.parametrize("polarity", [0, 1])
def test_one_polarity_stays(polarity: int) -> None:
    rng = np.random.default_rng(21)
    device = polarity_filter(polarity)
    device.stalls = Stalls.random(rng)
    kept = compare_with_reference(device, filter_traffic(rng, 50_000, 32, 16), lambda batch: batch.p == polarity)
    assert 0.4 < kept < 0.5  # half of those that did not come in dropped


def test_hands_everything_on_when_not_enabled() -> None:
    traffic = filter_traffic(np.random.default_rng(22), 1000, 32, 16, skips=0)
    assert compare_with_reference(polarity_filter(1, enable=0), traffic, lambda batch: np.ones(1000, np.bool_)) == 1


def test_a_token_every_clock_one_clock_later() -> None:
    traffic = filter_traffic(np.random.default_rng(23), 1000, 32, 16)
    _, times = polarity_filter(1).stream_timed(traffic, traffic.keep)
    assert (np.diff(times.accepted) == 1).all()
    assert (times.given - times.accepted == 1).all()


def test_reset_empties_it() -> None:
    device = polarity_filter(1)
    device.set(s_valid=1, s_event=1)
    for _ in range(2):  # s_ready rises a clock after reset
        device.sim.clock.tick()
    assert (device.sim.io.m_valid, device.sim.io.idle) == (1, 0)
    device.set(s_valid=0)
    device.reset()
    assert (device.sim.io.m_valid, device.sim.io.idle) == (0, 1)


@pytest.mark.parametrize("parameters", [{}, {"X_W": 1, "Y_W": 1, "TICK_W": 1}, {"X_W": 16, "Y_W": 16, "TICK_W": 32}])
def test_lints_clean(parameters: dict[str, int]) -> None:
    assert lint("filter_polarity", **parameters) == (0, "")


@pytest.mark.parametrize(("name", "most"), [("X_W", 16), ("Y_W", 16), ("TICK_W", 32)])
def test_refuses_parameters_out_of_range(name: str, most: int) -> None:
    for value in (0, most + 1):
        code, log = lint("filter_polarity", **{name: value})
        assert code != 0
        assert f"{name}_must_be_1_to_{most}" in log

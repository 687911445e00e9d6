# SPDX-License-Identifier: Apache-2.0
"""Filters without memory: polarity and region."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot_cosim.devices.base import Stalls
from support.filter_trials import FilterDevice, FilterTraffic, check_reset_amid_events, compare_with_reference, filter_traffic


def polarity_filter(polarity: int, *, enable: int = 1) -> FilterDevice:
    return FilterDevice("filter_polarity", {"X_W": 5, "Y_W": 4, "TICK_W": 4}, {"enable": enable, "polarity": polarity})


@pytest.mark.parametrize("polarity", [0, 1])
def test_one_polarity_stays(polarity: int) -> None:
    rng = np.random.default_rng(21)
    device = polarity_filter(polarity)
    device.stall(Stalls.random(rng))
    kept = compare_with_reference(device, filter_traffic(rng, 50_000, 32, 16), lambda batch: batch.p == polarity)
    assert 0.4 < kept < 0.5  # half of those that did not come in dropped


def test_hands_everything_on_when_not_enabled() -> None:
    traffic = filter_traffic(np.random.default_rng(22), 1000, 32, 16, skips=0)
    assert compare_with_reference(polarity_filter(1, enable=0), traffic, lambda batch: np.ones(1000, np.bool_)) == 1


def test_reset_amid_events_leaves_nothing() -> None:
    check_reset_amid_events(polarity_filter(1))
    check_reset_amid_events(region_filter((0, 1, 0, 1)))


NARROW = {"X_W": 5, "Y_W": 4, "TICK_W": 4}
Region = tuple[int, int, int, int]


def region_filter(region: Region, parameters: dict[str, int] | None = None, *, enable: int = 1) -> FilterDevice:
    ports = dict(zip(("region_x0", "region_x1", "region_y0", "region_y1"), region, strict=True))
    return FilterDevice("filter_region", parameters or NARROW, {"enable": enable, **ports})


def inside(region: Region, x: NDArray[np.uint16], y: NDArray[np.uint16]) -> NDArray[np.bool_]:
    x0, x1, y0, y1 = region
    return np.asarray((x0 <= x) & (x <= x1) & (y0 <= y) & (y <= y1))


def every_pixel() -> FilterTraffic:
    y, x = np.divmod(np.arange(512), 32)
    return FilterTraffic(
        np.arange(512), x.astype(np.uint16), y.astype(np.uint16), np.zeros(512, np.uint8), np.ones(512, np.bool_)
    )


@pytest.mark.parametrize(
    "region",
    [(3, 17, 2, 9), (0, 31, 0, 15), (7, 7, 5, 5), (9, 8, 0, 15), (0, 31, 8, 7), (0, 65535, 14, 65535), (32, 65535, 0, 15)],
    ids=["inside", "all", "one pixel", "no column", "no row", "wider than addresses", "beyond addresses"],
)
def test_decides_every_pixel(region: Region) -> None:
    kept = compare_with_reference(region_filter(region), every_pixel(), lambda batch: inside(region, batch.x, batch.y))
    x0, x1, y0, y1 = region
    assert kept == max(0, min(x1, 31) - x0 + 1) * max(0, min(y1, 15) - y0 + 1) / 512


def test_filter_region_hands_everything_on_when_not_enabled() -> None:
    assert (
        compare_with_reference(region_filter((9, 8, 9, 8), enable=0), every_pixel(), lambda batch: np.ones(512, np.bool_)) == 1
    )


def test_random_regions_traffic_and_stalls_are_exact() -> None:
    print("seed 11")
    rng = np.random.default_rng(11)
    wide = {"X_W": 16, "Y_W": 16, "TICK_W": 1}
    for parameters, size in ((NARROW, (32, 16)), (wide, (65536, 65536))):
        device = region_filter((0, 0, 0, 0), parameters)
        for _ in range(6):
            device.stall(Stalls.random(rng))
            x0, x1 = sorted(rng.integers(size[0], size=2).tolist())
            y0, y1 = sorted(rng.integers(size[1], size=2).tolist())
            device.set(region_x0=x0, region_x1=x1, region_y0=y0, region_y1=y1)
            traffic = filter_traffic(rng, 20_000, *size, first_tick=device.now)

            def wanted(batch: FilterTraffic, region: Region = (x0, x1, y0, y1)) -> NDArray[np.bool_]:
                return inside(region, batch.x, batch.y)

            compare_with_reference(device, traffic, wanted)


BOTH = pytest.mark.parametrize("name", ["filter_polarity", "filter_region"])


def open_filter(name: str) -> FilterDevice:
    """A filter that keeps some of the traffic and the event at 0, 0 of polarity 0."""
    return polarity_filter(0) if name == "filter_polarity" else region_filter((0, 17, 0, 9))


@BOTH
def test_a_token_every_clock_one_clock_later(name: str) -> None:
    traffic = filter_traffic(np.random.default_rng(23), 1000, 32, 16)
    _, times = open_filter(name).stream_timed(traffic, traffic.keep)
    assert (np.diff(times.accepted) == 1).all()
    assert (times.given - times.accepted == 1).all()


@BOTH
def test_reset_empties_it(name: str) -> None:
    device = open_filter(name)
    device.set(s_valid=1, s_event=1)
    for _ in range(2):  # s_ready rises a clock after reset
        device.sim.clock.tick()
    assert (device.sim.io.m_valid, device.sim.io.idle) == (1, 0)
    device.set(s_valid=0)
    device.reset()
    assert (device.sim.io.m_valid, device.sim.io.idle) == (0, 1)

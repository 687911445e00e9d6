# SPDX-License-Identifier: Apache-2.0
"""stamp_ticks.v: its ticks are those that the streaming drives make of the same events."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.ticks import tick_times
from support.stream_device import Bundle, StreamDevice, check_reset, random_stalls

TOP = "stamp_ticks"
EVENTS = Bundle("s_", ("t", "x", "y", "p"))
TICKED = Bundle("m_", ("tick", "x", "y", "p"))


def device_of(tick_us: int, t_w: int = 48, *, divides: int = 1, off: int = 0) -> StreamDevice:
    parameters = {"T_W": t_w, "X_W": 11, "Y_W": 11, "DIVIDES": divides}
    ports = {"tick_us": tick_us, "off": off}
    return StreamDevice(TOP, parameters, inputs=[EVENTS], outputs=[TICKED], ports=ports, has_idle=True)


@pytest.mark.parametrize(("tick_us", "divides"), [(1, 0), (10, 1)])
def test_reset_amid_events_leaves_nothing(tick_us: int, divides: int) -> None:
    check_reset(device_of(tick_us, divides=divides), {"s_": [[t, 1, 2, 1] for t in range(0, 5_000, 50)]})


def expected(t_us: NDArray[np.int64], rest: NDArray[np.int64], tick_us: int) -> NDArray[np.uint64]:
    """As the host does it: ticks since the first event, times that run back raised to the latest one."""
    ticks = tick_times(np.maximum.accumulate(t_us), int(t_us[0]), max(1, tick_us))
    return np.column_stack([np.diff(ticks, prepend=0), rest]).astype(np.uint64)


def stamped(device: StreamDevice, times: list[int]) -> list[int]:
    """The ticks of events at these times, from reset."""
    device.reset()
    return [int(tick) for tick in device.run({"s_": [[t, 1, 2, 1] for t in times]}).words["m_"][:, 0]]


class TestStories:
    @pytest.mark.parametrize("divides", [0, 1])
    def test_the_first_event_is_at_tick_0_and_ticks_count_from_there(self, divides: int) -> None:
        times = [1_000_000, 1_000_000, 1_000_005, 1_000_260]
        assert stamped(device_of(1, divides=divides), times) == [0, 0, 5, 255]

    def test_without_a_divider_a_tick_is_a_microsecond(self) -> None:
        assert stamped(device_of(10, divides=0), [3, 12, 1 << 40]) == [0, 9, (1 << 40) - 12]

    def test_what_is_less_than_a_tick_is_not_forgotten(self) -> None:
        assert stamped(device_of(10), [3, 12, 13, 22, 31, 32, 63, 64, 72, 73]) == [0, 0, 1, 0, 1, 0, 4, 0, 0, 1]

    @pytest.mark.parametrize("divides", [0, 1])
    def test_time_that_runs_back_stands_still_until_it_has_caught_up(self, divides: int) -> None:
        device = device_of(1, divides=divides)
        assert stamped(device, [100, 90, 105, 99, 104, 105, 106]) == [0, 0, 5, 0, 0, 0, 1]
        assert device.sim.io.n_backward == 3

    def test_reset_makes_the_next_event_the_first(self) -> None:
        device = device_of(10)
        assert stamped(device, [500, 509, 490]) == [0, 0, 0]
        assert stamped(device, [5, 14, 15]) == [0, 0, 1]
        assert device.sim.io.n_backward == 0

    def test_a_tick_of_0_is_taken_as_1(self) -> None:
        assert stamped(device_of(0), [5, 9]) == [0, 4]

    @pytest.mark.parametrize("divides", [0, 1])
    def test_off_no_event_has_ticks_and_no_time_runs_back(self, divides: int) -> None:
        device = device_of(10, divides=divides, off=1)
        assert stamped(device, [500, 20_000, 3, 900]) == [0, 0, 0, 0]
        assert device.sim.io.n_backward == 0


@pytest.mark.parametrize(("t_w", "tick_us", "divides"), [(48, 1, 0), (48, 1, 1), (64, 10, 1), (48, 7, 1), (48, 1_000_000, 1)])
def test_ticks_are_those_of_the_drives(t_w: int, tick_us: int, divides: int) -> None:
    """100,000 events a case, silences of any length, times that run back, any stalls."""
    device = device_of(tick_us, t_w, divides=divides)
    for run in range(2):
        rng = np.random.default_rng([61, t_w, tick_us, run])
        n = 50_000
        scale = float(rng.choice([0.5, 1, 3])) * tick_us
        gap_us = rng.integers(0, int(2 * scale) + 1, n)
        long = rng.random(n) < 0.01
        gap_us[long] = 2 ** rng.uniform(0, 37, int(long.sum()))
        gap_us[n // 2] = 1 << 46
        t_us = int(rng.integers(1 << 46)) + np.cumsum(gap_us) % (1 << 46)
        back = rng.random(n) < 0.02
        t_us[back] -= np.minimum(t_us[back], rng.integers(0, int(5 * scale) + 2, int(back.sum())))
        latest = np.maximum.accumulate(t_us)
        rest = np.stack([rng.integers(0, 2048, n), rng.integers(0, 2048, n), rng.integers(0, 2, n)], axis=1)
        device.reset()
        device.stalls = random_stalls(rng, ("s_", "m_"))
        found = device.run({"s_": np.column_stack([t_us, rest])}).words["m_"]
        assert np.array_equal(found, expected(t_us, rest, tick_us))
        n_backward = int((t_us[1:] < latest[:-1]).sum())
        assert device.sim.io.n_backward == n_backward > 0


class TestClocks:
    """What the header claims."""

    @pytest.mark.parametrize(("tick_us", "gap_us", "divides"), [(1, 1_000_000, 0), (1, 1_000_000, 1), (10, 9, 1)])
    def test_an_event_every_clock(self, tick_us: int, gap_us: int, divides: int) -> None:
        run = device_of(tick_us, divides=divides).run({"s_": [[k * gap_us, 0, 0, 0] for k in range(100)]})
        assert set(np.diff(run.accepted["s_"])) == {1}
        assert set(run.given["m_"] - run.accepted["s_"]) == {1 + 2 * divides}

    def test_a_division(self) -> None:
        run = device_of(10).run({"s_": [[k * 1000, 0, 0, 0] for k in range(100)]})
        assert set(np.diff(run.accepted["s_"])[4:]) == {48 + 3}  # behind those that wait inside

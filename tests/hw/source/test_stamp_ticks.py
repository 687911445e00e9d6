# SPDX-License-Identifier: Apache-2.0
"""stamp_ticks.v: its tokens are those that the streaming drives make of the same events."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.ticks import tick_times
from support.stream_device import Bundle, StreamDevice, random_stalls
from support.testing import lint
from support.ticked import ticked
from support.tokens import TOKENS_OUT, make_tokens

TOP = "stamp_ticks"
EVENTS = Bundle("s_", ("t", "x", "y", "p"))


def device_of(tick_w: int, tick_us: int) -> StreamDevice:
    parameters = {"T_W": 64 if tick_w == 8 else 48, "TICK_W": tick_w, "X_W": 11, "Y_W": 11}
    ports = {"tick_us": tick_us}
    return StreamDevice(TOP, parameters, inputs=[EVENTS], outputs=[TOKENS_OUT], ports=ports, has_idle=True)


def expected(t_us: NDArray[np.int64], rest: NDArray[np.int64], tick_us: int, tick_w: int) -> NDArray[np.uint64]:
    """As the host does it: ticks since the first event, times that run back raised to the latest one."""
    ticks = tick_times(np.maximum.accumulate(t_us), int(t_us[0]), max(1, tick_us))
    x, y, p = rest.T
    return make_tokens(ticked(ticks, x, y, p), tick_w)


def stamped(device: StreamDevice, times: list[int]) -> list[list[int]]:
    """(tick, event) of the tokens that events at these times become, from reset."""
    device.reset()
    return device.run({"s_": [[t, 1, 2, 1] for t in times]}).words["m_"][:, :2].tolist()


@pytest.mark.parametrize(("t_w", "tick_w"), [(48, 20), (32, 1), (64, 32)])
def test_lints_clean(t_w: int, tick_w: int) -> None:
    assert lint(TOP, T_W=t_w, TICK_W=tick_w) == (0, "")


@pytest.mark.parametrize(
    ("parameters", "rule"),
    [
        ({"T_W": 31}, "T_W_must_be_32_to_64"),
        ({"TICK_W": 33}, "TICK_W_must_be_1_to_32"),
        ({"X_W": 17}, "X_W_must_be_1_to_16"),
        ({"COUNT_W": 1}, "COUNT_W_must_be_8_to_64"),
    ],
)
def test_refuses_parameters(parameters: dict[str, int], rule: str) -> None:
    code, log = lint(TOP, **parameters)
    assert code != 0
    assert rule in log


class TestStories:
    def test_the_first_event_is_at_tick_0_and_ticks_count_from_there(self) -> None:
        assert stamped(device_of(8, 1), [1_000_000, 1_000_000, 1_000_005, 1_000_260]) == [[0, 1], [0, 1], [5, 1], [255, 1]]

    def test_a_long_silence_goes_ahead_in_full_tokens(self) -> None:
        assert stamped(device_of(8, 1), [7, 7 + 256]) == [[0, 1], [255, 0], [1, 1]]
        assert stamped(device_of(8, 1), [7, 7 + 3 * 255]) == [[0, 1], [255, 0], [255, 0], [255, 1]]

    def test_what_is_less_than_a_tick_is_not_forgotten(self) -> None:
        assert stamped(device_of(8, 10), [3, 12, 13, 22, 31, 32, 63, 64, 72, 73]) == [
            [0, 1], [0, 1], [1, 1], [0, 1], [1, 1], [0, 1], [4, 1], [0, 1], [0, 1], [1, 1],
        ]  # fmt: skip

    def test_time_that_runs_back_stands_still_until_it_has_caught_up(self) -> None:
        device = device_of(8, 1)
        assert stamped(device, [100, 90, 105, 99, 104, 105, 106]) == [[0, 1], [0, 1], [5, 1], [0, 1], [0, 1], [0, 1], [1, 1]]
        assert device.sim.io.n_backward == 3

    def test_reset_makes_the_next_event_the_first(self) -> None:
        device = device_of(8, 10)
        assert stamped(device, [500, 509, 490]) == [[0, 1], [0, 1], [0, 1]]
        assert stamped(device, [5, 14, 15]) == [[0, 1], [0, 1], [1, 1]]
        assert device.sim.io.n_backward == 0

    def test_a_tick_of_0_is_taken_as_1(self) -> None:
        assert stamped(device_of(8, 0), [5, 9]) == [[0, 1], [4, 1]]


@pytest.mark.parametrize(("tick_w", "tick_us"), [(20, 1), (1, 1), (8, 1), (8, 10), (32, 7), (20, 1_000_000)])
def test_tokens_are_those_of_the_drives(tick_w: int, tick_us: int) -> None:
    """100,000 events a case, silences of any length that so many tokens can hold, times that run back, any stalls."""
    device = device_of(tick_w, tick_us)
    for run in range(2):
        rng = np.random.default_rng([61, tick_w, tick_us, run])
        n = 50_000
        scale = float(rng.choice([0.5, 1, 3])) * tick_us
        gap_us = rng.integers(0, int(2 * scale) + 1, n)
        long = rng.random(n) < 0.01
        longest = min(1 << 46, 500 * tick_us << tick_w)
        gap_us[long] = 2 ** rng.uniform(0, np.log2(longest / 500), int(long.sum()))
        gap_us[n // 2] = longest
        t_us = int(rng.integers(1 << 46)) + np.cumsum(gap_us) % (1 << 46)
        back = rng.random(n) < 0.02
        t_us[back] -= np.minimum(t_us[back], rng.integers(0, int(5 * scale) + 2, int(back.sum())))
        latest = np.maximum.accumulate(t_us)
        rest = np.stack([rng.integers(0, 2048, n), rng.integers(0, 2048, n), rng.integers(0, 2, n)], axis=1)
        device.reset()
        device.stalls = random_stalls(rng, ("s_", "m_"))
        tokens = device.run({"s_": np.column_stack([t_us, rest])}).words["m_"]
        assert np.array_equal(tokens, expected(t_us, rest, tick_us, tick_w))
        n_backward = int((t_us[1:] < latest[:-1]).sum())
        assert device.sim.io.n_backward == n_backward > 0
        print(f"TICK_W {tick_w}, tick {tick_us} us: {n} events, {len(tokens) - n} tokens of ticks alone, {n_backward} run back")


class TestClocks:
    """What the header claims."""

    @pytest.mark.parametrize(("tick_us", "gap_us"), [(1, 1_000_000), (10, 9)])
    def test_an_event_every_clock_4_clocks_later(self, tick_us: int, gap_us: int) -> None:
        run = device_of(20, tick_us).run({"s_": [[k * gap_us, 0, 0, 0] for k in range(100)]})
        assert set(np.diff(run.accepted["s_"])) == {1}
        assert set(run.given["m_"] - run.accepted["s_"]) == {4}

    def test_a_division(self) -> None:
        run = device_of(20, 10).run({"s_": [[k * 1000, 0, 0, 0] for k in range(100)]})
        assert set(np.diff(run.accepted["s_"])[4:]) == {48 + 3}  # behind those that wait inside

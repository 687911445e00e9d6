# SPDX-License-Identifier: Apache-2.0
"""tick_prescaler.v: every event comes at the tick of the clock that takes it, and no tick is lost, whatever stalls."""

from __future__ import annotations

import numpy as np
import pytest

from support.stream_device import Bundle, StreamDevice, StreamRun, random_pattern, random_stalls
from support.testing import lint
from support.tokens import TOKENS_OUT, decode_tokens

TOP = "tick_prescaler"
EVENTS = Bundle("s_", ("x", "y", "p"))


def device_of(tick_w: int, prescale: int) -> StreamDevice:
    parameters = {"TICK_W": tick_w, "X_W": 11, "Y_W": 11}
    return StreamDevice(TOP, parameters, inputs=[EVENTS], outputs=[TOKENS_OUT], ports={"prescale": prescale}, has_idle=True)


def joined(*runs: StreamRun) -> np.ndarray[tuple[int, int], np.dtype[np.uint64]]:
    return np.concatenate([run.words["m_"] for run in runs])


@pytest.mark.parametrize(("tick_w", "prescale_w"), [(20, 16), (1, 1), (32, 24)])
def test_lints_clean(tick_w: int, prescale_w: int) -> None:
    assert lint(TOP, TICK_W=tick_w, PRESCALE_W=prescale_w) == (0, "")


@pytest.mark.parametrize(
    ("parameters", "rule"), [({"TICK_W": 0}, "TICK_W_must_be_1_to_32"), ({"PRESCALE_W": 0}, "W_must_be_at_least_1")]
)
def test_refuses_parameters(parameters: dict[str, int], rule: str) -> None:
    code, log = lint(TOP, **parameters)
    assert code != 0
    assert rule in log


class TestStories:
    def test_a_tick_every_so_many_clocks_comes_without_an_event(self) -> None:
        run = device_of(8, 5).run(clocks=28)
        assert run.words["m_"][:, :3].tolist() == [[1, 0, 0]] * 5
        assert run.given["m_"].tolist() == [7, 12, 17, 22, 27]

    def test_a_prescale_of_0_lets_time_stand_still(self) -> None:
        device = device_of(8, 0)
        assert len(device.run(clocks=100).words["m_"]) == 0
        assert device.run({"s_": [[1, 2, 1]]}).words["m_"].tolist() == [[0, 1, 0, 1, 2, 1]]

    def test_ticks_of_a_stall_go_with_the_next_event_as_far_as_they_fit(self) -> None:
        device = device_of(8, 1)
        device.stalls = {"m_": np.array([0] * 700 + [1] * 300, np.uint8)}
        stalled, after = device.run(clocks=699), device.run({"s_": [[1, 2, 1]]}, clocks=50)
        assert after.accepted["s_"].tolist() == [701]  # two clocks after the stall ended
        result = joined(stalled, after)[:, :2].tolist()
        assert result[:6] == [[1, 0], [1, 0], [1, 0], [255, 0], [255, 0], [701 - 3 - 2 * 255, 1]]

    def test_a_new_prescale_counts_from_the_last_tick(self) -> None:
        device = device_of(8, 100)
        device.run(clocks=50)
        device.set(prescale=60)
        assert device.run(clocks=30).given["m_"].tolist() == [59 + 3]
        device.set(prescale=5)  # 20 clocks have passed: the tick comes in the next clock
        assert device.run(clocks=7).given["m_"].tolist() == [81 + 3]


@pytest.mark.parametrize(("tick_w", "prescale"), [(20, 7), (8, 1), (8, 65_535), (1, 3), (1, 40)])
def test_events_come_at_the_tick_of_their_clock_and_no_tick_is_lost(tick_w: int, prescale: int) -> None:
    device = device_of(tick_w, prescale)
    for run in range(3):
        rng = np.random.default_rng([71, tick_w, prescale, run])
        device.stalls = random_stalls(rng, ("s_", "m_"))
        if run == 2:  # long stalls
            device.stalls = {"s_": random_pattern(rng), "m_": np.repeat(random_pattern(rng, 0.3), 500)}
        device.set(prescale=prescale)
        device.reset()
        n = 30_000
        events = np.stack([rng.integers(0, 2048, n), rng.integers(0, 2048, n), rng.integers(0, 2, n)], axis=1)
        first = device.run({"s_": events}, clocks=20_000)
        taken = len(first.accepted["s_"])
        device.set(prescale=0)  # from the next clock on nothing is added any more
        device.stalls = {}
        rest = device.run({"s_": []}, clocks=50_000)
        decoded = decode_tokens(joined(first, rest))
        assert np.array_equal(decoded.events[:, 2:], events[:taken])
        assert np.array_equal(decoded.at, first.accepted["s_"] // prescale)
        assert decoded.ticks == 20_001 // prescale
        assert taken > 500
        alone = joined(first, rest)
        assert (alone[alone[:, 1] == 0, 0] > 0).all()  # no token says nothing


def test_clocks() -> None:
    """A token every clock, 2 clocks later, while its ticks fit."""
    device = device_of(8, 3)
    run = device.run({"s_": [[1, 1, 1]] * 300})
    assert set(np.diff(run.accepted["s_"])) == {1}
    is_event = run.words["m_"][:, 1] == 1
    assert set(run.given["m_"][is_event] - run.accepted["s_"]) == {2}

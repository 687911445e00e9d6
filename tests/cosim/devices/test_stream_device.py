# SPDX-License-Identifier: Apache-2.0
"""The drive for modules of ready/valid streams: words through a queue, and broken ones found out."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from evcot_cosim.devices.base import HardwareError
from support.stream_device import Bundle, StreamDevice, random_pattern, random_stalls
from support.testing import broken_copy

IN, OUT = Bundle("s_", ("data",)), Bundle("m_", ("data",))


def queue(verilog: Path | None = None) -> StreamDevice:
    return StreamDevice("fifo", {"W": 8, "DEPTH": 5}, inputs=[IN], outputs=[OUT], verilog=verilog)


def test_words_come_out_with_the_clocks_at_which_they_moved() -> None:
    run = queue().run({"s_": [1, 2, 3]})
    assert run.words["m_"].tolist() == [[1], [2], [3]]
    assert run.accepted["s_"].tolist() == [0, 1, 2]
    assert run.given["m_"].tolist() == [1, 2, 3]


def test_any_number_of_words_under_any_stalls() -> None:
    device = queue()
    for seed in range(5):
        rng = np.random.default_rng(seed)
        device.stalls = random_stalls(rng, ("s_", "m_"))
        words = rng.integers(0, 256, 30_000)
        assert np.array_equal(device.run({"s_": words}).words["m_"][:, 0], words)


def test_a_pattern_says_when_a_stream_goes() -> None:
    device = queue()
    device.stalls = {"s_": np.array([0, 0, 1], np.uint8), "m_": np.array([1, 1, 1, 0], np.uint8)}
    run = device.run({"s_": range(100)})
    assert set(run.accepted["s_"] % 3) == {2}
    assert 3 not in run.given["m_"] % 4


def test_a_run_of_so_many_clocks_leaves_the_rest_for_the_next() -> None:
    device = queue()
    device.stalls = {"m_": np.array([0] * 50 + [1] * 50, np.uint8)}
    first = device.run({"s_": range(20)}, clocks=50)
    assert (first.clocks, len(first.accepted["s_"]), len(first.words["m_"])) == (50, 5, 0)
    rest = device.run({"s_": range(5, 20)}, clocks=50)
    assert rest.words["m_"][:, 0].tolist() == list(range(20))
    assert rest.given["m_"].min() == 50


def test_random_patterns_go_at_least_once() -> None:
    rng = np.random.default_rng(1)
    assert random_pattern(rng, 0.0).sum() == 1
    assert 0.4 < random_pattern(rng, 0.5).mean() < 0.6


def test_the_value_of_a_word_that_does_not_fit_is_refused() -> None:
    with pytest.raises(AssertionError, match="more bits than its port"):
        queue().run({"s_": [256]})


@pytest.mark.parametrize(
    ("right", "wrong", "message"),
    [
        ("m_data = memory[read_reg]", "m_data = memory[read_reg] ^ {7'd0, s_valid}", "fifo withdrew or changed word"),
        (
            "m_valid = level_reg != {LEVEL_W{1'b0}}",
            "m_valid = level_reg > {LEVEL_W{1'b0}} && !s_valid",
            "fifo withdrew or changed",
        ),
        ("s_ready = !full_reg", "s_ready = 1'b0", "fifo stands still"),
    ],
)
def test_a_broken_queue_is_found_out(right: str, wrong: str, message: str, tmp_path: Path) -> None:
    device = queue(broken_copy(tmp_path, "fifo.v", right, wrong))
    device.stalls = {"s_": np.array([1, 0, 1, 1, 0], np.uint8), "m_": np.array([0, 1, 1], np.uint8)}
    with pytest.raises(HardwareError, match=message):
        device.run({"s_": range(200)})

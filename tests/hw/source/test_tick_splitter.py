# SPDX-License-Identifier: Apache-2.0
"""tick_splitter.v: wide ticks in narrow tokens, every event still at its tick."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from support.stream_device import StreamDevice, random_stalls
from support.testing import lint
from support.tokens import TOKENS_IN, TOKENS_OUT

TOP = "tick_splitter"


def device_of(wide_w: int, tick_w: int) -> StreamDevice:
    parameters = {"WIDE_W": wide_w, "TICK_W": tick_w, "X_W": 8, "Y_W": 7}
    return StreamDevice(TOP, parameters, inputs=[TOKENS_IN], outputs=[TOKENS_OUT], has_idle=True)


def split(wide: NDArray[np.uint64], tick_w: int) -> NDArray[np.uint64]:
    """Of ticks that do not fit, halves of the range go ahead, without event."""
    half = 1 << tick_w - 1
    tick = wide[:, 0].astype(np.int64)
    ahead = np.where(tick < 2 * half, 0, tick // half - 1)
    index = np.repeat(np.arange(len(wide)), ahead + 1)
    last = np.cumsum(ahead + 1) - 1
    tokens = wide[index]
    tokens[:, 0] = half
    tokens[last, 0] = tick - half * ahead
    tokens[np.setdiff1d(np.arange(len(tokens)), last), 1:3] = 0
    return tokens


def test_what_does_not_fit_goes_ahead_in_halves() -> None:
    run = device_of(16, 8).run({"s_": [[255, 1, 0, 1, 2, 1], [256, 1, 0, 3, 4, 0], [520, 0, 1, 5, 6, 0]]})
    assert run.words["m_"][:, :3].tolist() == [
        [255, 1, 0], [128, 0, 0], [128, 1, 0], [128, 0, 0], [128, 0, 0], [128, 0, 0], [136, 0, 1],
    ]  # fmt: skip


@pytest.mark.parametrize(("wide_w", "tick_w"), [(48, 20), (20, 20), (1, 1), (64, 32), (33, 32)])
def test_lints_clean(wide_w: int, tick_w: int) -> None:
    assert lint(TOP, WIDE_W=wide_w, TICK_W=tick_w) == (0, "")


@pytest.mark.parametrize(
    ("parameters", "rule"),
    [
        ({"WIDE_W": 19}, "WIDE_W_must_be_at_least_TICK_W"),
        ({"TICK_W": 33}, "TICK_W_must_be_1_to_32"),
        ({"X_W": 0}, "X_W_must_be_1_to_16"),
        ({"Y_W": 17}, "Y_W_must_be_1_to_16"),
    ],
)
def test_refuses_parameters(parameters: dict[str, int], rule: str) -> None:
    code, log = lint(TOP, **parameters)
    assert code != 0
    assert rule in log


@pytest.mark.parametrize(("wide_w", "tick_w"), [(20, 20), (12, 1), (48, 32)])
def test_random_tokens(wide_w: int, tick_w: int) -> None:
    device = device_of(wide_w, tick_w)
    for run in range(3):
        rng = np.random.default_rng([91, wide_w, run])
        device.stalls = random_stalls(rng, ("s_", "m_"))
        n, longest = 20_000, min(wide_w, tick_w + 6)
        wait = (2 ** rng.uniform(0, longest, n)).astype(np.int64) - 1
        wait[rng.random(n) < 0.3] = 0
        wait[rng.random(n) < 0.1] = (1 << tick_w) - 1
        x, y = rng.integers(0, 256, n).astype(np.uint16), rng.integers(0, 128, n).astype(np.uint16)
        kind, p = rng.integers(0, 3, n), rng.integers(0, 2, n).astype(np.uint8)
        wide = np.stack([wait, kind == 1, kind == 2, x, y, p], axis=1).astype(np.uint64)
        assert np.array_equal(device.run({"s_": wide}).words["m_"], split(wide, tick_w))


def test_clocks() -> None:
    """A token every clock, 2 clocks later."""
    device = device_of(48, 32)
    run = device.run({"s_": [[9, 1, 0, 1, 2, 1]] * 50})
    assert run.accepted["s_"].tolist() == list(range(50))
    assert run.given["m_"].tolist() == list(range(2, 52))

# SPDX-License-Identifier: Apache-2.0
"""event_vector.v: bits of a mask as events, against the rule as one line of Python."""

from __future__ import annotations

import numpy as np
import pytest

from support.stream_device import Bundle, StreamDevice, random_stalls
from support.testing import lint

TOP = "event_vector"
FIELDS = ("t", "x", "y", "p", "mask", "known")
# bits, width, height, x_w, y_w
SHAPES = [(32, 100, 60, 7, 6), (12, 2048, 2048, 11, 11), (1, 1280, 720, 11, 10)]


def device_of(bits: int, width: int, height: int, x_w: int, y_w: int) -> StreamDevice:
    parameters = {"L": bits, "WIDTH": width, "HEIGHT": height, "X_W": x_w, "Y_W": y_w}
    inputs, outputs = [Bundle("s_", FIELDS)], [Bundle("m_", FIELDS[:4])]
    return StreamDevice(TOP, parameters, inputs=inputs, outputs=outputs, has_idle=True)


@pytest.mark.parametrize("shape", SHAPES)
def test_lints_clean(shape: tuple[int, int, int, int, int]) -> None:
    assert lint(TOP, **dict(zip(("L", "WIDTH", "HEIGHT", "X_W", "Y_W"), shape, strict=True))) == (0, "")


@pytest.mark.parametrize(
    ("parameters", "rule"),
    [
        ({"L": 33}, "L_must_be_1_to_32"),
        ({"X_W": 12}, "X_W_must_be_1_to_11"),
        ({"Y_W": 0, "HEIGHT": 1}, "Y_W_must_be_1_to_11"),
        ({"WIDTH": 2049}, "WIDTH_must_be_1_to_2_to_the_X_W"),
        ({"HEIGHT": 0}, "HEIGHT_must_be_1_to_2_to_the_Y_W"),
    ],
)
def test_refuses_parameters(parameters: dict[str, int], rule: str) -> None:
    code, log = lint(TOP, **parameters)
    assert code != 0
    assert rule in log


@pytest.mark.parametrize("shape", SHAPES)
def test_random_vectors(shape: tuple[int, int, int, int, int]) -> None:
    bits, width, height, *_ = shape
    device = device_of(*shape)
    for run in range(3):
        rng = np.random.default_rng([51, bits, run])
        n = 10_000
        t = rng.integers(0, 1 << 48, n)
        x, y = rng.integers(0, min(2049, width + 20), n), rng.integers(0, min(2048, height + 5), n)
        mask = rng.integers(0, 1 << bits, n) & rng.integers(0, 1 << bits, n)
        vectors = np.stack([t, x, y, rng.integers(0, 2, n), mask, rng.random(n) < 0.9], axis=1).astype(np.uint64)
        events = [
            ([t, x + bit, y, p], known)
            for t, x, y, p, mask, known in vectors.tolist()
            for bit in range(bits)
            if mask >> bit & 1
        ]
        inside = [event for event, known in events if known and event[1] < width and event[2] < height]
        untimed = sum(not known for _, known in events)
        device.reset()
        device.stalls = random_stalls(rng, ("s_", "m_"))
        assert device.run({"s_": vectors}).words["m_"].tolist() == inside
        io = device.sim.io
        assert (io.n_events, io.n_untimed, io.n_outside) == (len(inside), untimed, len(events) - len(inside) - untimed)
        assert untimed > 100


def test_clocks() -> None:
    """4 clocks to the first event, then one every clock; those left out and empty vectors take a clock each."""
    device = device_of(*SHAPES[0])
    run = device.run({"s_": [[0, 0, 0, 0, 0xFFFF_FFFF, 1]] * 20})
    assert run.given["m_"].tolist() == list(range(4, 4 + 640))
    run = device.run({"s_": [[0, 90, 0, 0, 0xFFF, 1], [0, 0, 0, 0, 0, 1]] * 20})
    assert set(np.diff(run.accepted["s_"][1::2])) == {12 + 1}

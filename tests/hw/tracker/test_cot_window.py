# SPDX-License-Identifier: Apache-2.0
"""cot_window.v: the pixel of a centre, and the bounds of a window that no edge of the sensor cuts off, made not negative."""

from __future__ import annotations

import numpy as np
import pytest

from support.testing import evaluate, lint


def check(centre: np.ndarray, radius: np.ndarray, w: int, frac: int, r_w: int) -> None:
    """The definition: a centre rounded to nearest, halves up, less and plus a radius."""
    inputs = {"asked": 1, "centre": centre, "radius": radius, "inset": (radius - 1) % (1 << r_w + 1)}
    result = evaluate("cot_window", {"W": w, "FRAC": frac, "R_W": r_w}, inputs, ["pixel", "lo_not", "hi"])
    pixel = np.floor(centre / 2.0**frac + (0.5 if frac else 0)).astype(np.int64)
    zero = 1 << max(w, r_w) + 1  # what stands for address 0
    on_sensor = pixel < 1 << w  # no centre lies beyond the last pixel
    np.testing.assert_array_equal(result["pixel"][on_sensor], pixel[on_sensor])
    np.testing.assert_array_equal(2 * zero - 1 - result["lo_not"], zero + pixel - radius)
    np.testing.assert_array_equal(result["hi"], zero + pixel + radius)


@pytest.mark.parametrize(("w", "frac", "r_w"), [(1, 0, 2), (5, 0, 6), (2, 1, 3), (5, 4, 6)])
def test_every_centre_and_radius(w: int, frac: int, r_w: int) -> None:
    centre, radius = (axis.ravel() for axis in np.meshgrid(np.arange(1 << w + frac), np.arange(1 << r_w)))
    check(centre, radius, w, frac, r_w)


@pytest.mark.parametrize(("w", "frac", "r_w"), [(16, 8, 13), (16, 0, 2)])
def test_random_wide_centres(w: int, frac: int, r_w: int) -> None:
    rng = np.random.default_rng(w)
    check(rng.integers(0, 1 << w + frac, 50_000), rng.integers(0, 1 << r_w, 50_000), w, frac, r_w)


@pytest.mark.parametrize(("w", "frac", "r_w"), [(1, 0, 1), (9, 4, 9), (16, 8, 13), (4, 1, 13)])
def test_lints_clean(w: int, frac: int, r_w: int) -> None:
    assert lint("cot_window", W=w, FRAC=frac, R_W=r_w) == (0, "")


@pytest.mark.parametrize(
    ("parameters", "rule"),
    [
        ({"W": 0}, "W_must_be_1_to_16"),
        ({"W": 17}, "W_must_be_1_to_16"),
        ({"FRAC": 9}, "FRAC_must_be_0_to_8"),
        ({"R_W": 0}, "R_W_must_be_1_to_13"),
        ({"R_W": 14}, "R_W_must_be_1_to_13"),
    ],
)
def test_refuses_parameters_out_of_range(parameters: dict[str, int], rule: str) -> None:
    code, log = lint("cot_window", **parameters)
    assert code != 0
    assert rule in log

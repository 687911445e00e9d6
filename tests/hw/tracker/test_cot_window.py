# SPDX-License-Identifier: Apache-2.0
"""cot_window.v: the pixel of a centre, and the first and last pixel within a radius of it."""

from __future__ import annotations

import numpy as np
import pytest

from support.testing import evaluate, lint

OUTPUTS = ["pixel", "lo", "hi"]


def bounds(centre: np.ndarray, radius: np.ndarray, w: int, frac: int) -> dict[str, np.ndarray]:
    """The definition: a centre rounded to nearest, halves up; the window clipped to the addresses that there are."""
    pixel = np.floor(centre / 2.0**frac + (0.5 if frac else 0)).astype(np.int64)
    return {"pixel": pixel, "lo": np.maximum(pixel - radius, 0), "hi": np.minimum(pixel + radius, (1 << w) - 1)}


def centres(w: int, frac: int) -> np.ndarray:
    """All centres that occur: none lies beyond the last pixel."""
    return np.arange((((1 << w) - 1) << frac) + 1)


@pytest.mark.parametrize(("w", "frac", "r_w"), [(1, 0, 2), (5, 0, 6), (2, 1, 3), (5, 4, 6)])
def test_every_centre_and_radius(w: int, frac: int, r_w: int) -> None:
    centre, radius = (axis.ravel() for axis in np.meshgrid(centres(w, frac), np.arange(1 << r_w)))
    result = evaluate("cot_window", {"W": w, "FRAC": frac, "R_W": r_w}, {"centre": centre, "radius": radius}, OUTPUTS)
    for name, expected in bounds(centre, radius, w, frac).items():
        np.testing.assert_array_equal(result[name], expected, err_msg=name)


@pytest.mark.parametrize(("w", "frac", "r_w"), [(16, 8, 13), (16, 0, 2)])
def test_random_wide_centres(w: int, frac: int, r_w: int) -> None:
    rng = np.random.default_rng(w)
    centre, radius = rng.integers(0, len(centres(w, frac)), 100_000), rng.integers(0, 1 << r_w, 100_000)
    result = evaluate("cot_window", {"W": w, "FRAC": frac, "R_W": r_w}, {"centre": centre, "radius": radius}, OUTPUTS)
    for name, expected in bounds(centre, radius, w, frac).items():
        np.testing.assert_array_equal(result[name], expected, err_msg=name)


def test_a_window_is_2r_plus_1_wide_wherever_its_centre_lies_within_a_pixel() -> None:
    centre = np.arange(16 << 4, 17 << 4)
    result = evaluate("cot_window", {"W": 5, "FRAC": 4, "R_W": 6}, {"centre": centre, "radius": 5}, OUTPUTS)
    assert result["pixel"].tolist() == [16] * 8 + [17] * 8
    assert set(result["hi"] - result["lo"]) == {10}


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

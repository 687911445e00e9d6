# SPDX-License-Identifier: Apache-2.0
"""approach.v against the golden model's step and against the numbers of the paper's plain shift, all values and shifts."""

from __future__ import annotations

import numpy as np
import pytest

from evcot.hardware._cot_kernel import _approach
from support.testing import evaluate, lint

SHIFTS = np.arange(9)


def steps(value: np.ndarray, target: np.ndarray, k: np.ndarray, frac: int) -> np.ndarray:
    return np.array([_approach(*row, frac) for row in zip(value.tolist(), target.tolist(), k.tolist(), strict=True)])


@pytest.mark.parametrize(("w", "frac"), [(1, 0), (6, 0), (6, 4)])
def test_is_the_models_step_for_every_value_target_and_shift(w: int, frac: int) -> None:
    every = np.arange(1 << w)
    value, target, k = (axis.ravel() for axis in np.meshgrid(every, every, SHIFTS))
    result = evaluate("approach", {"W": w, "FRAC": frac}, {"value": value, "target": target, "k": k}, ["result"])["result"]
    np.testing.assert_array_equal(result, steps(value, target, k, frac))
    assert ((np.minimum(value, target) <= result) & (result <= np.maximum(value, target))).all()


@pytest.mark.parametrize(("w", "frac"), [(24, 8)])
def test_is_the_models_step_for_random_wide_values(w: int, frac: int) -> None:
    rng = np.random.default_rng(w)
    value, target, k = rng.integers(0, 1 << w, 20_000), rng.integers(0, 1 << w, 20_000), rng.integers(0, 9, 20_000)
    result = evaluate("approach", {"W": w, "FRAC": frac}, {"value": value, "target": target, "k": k}, ["result"])["result"]
    np.testing.assert_array_equal(result, steps(value, target, k, frac))


@pytest.mark.parametrize(
    ("frac", "value", "target", "k", "result"),
    [
        (0, 10, 13, 1, 11),  # floor(3/2) = 1
        (0, 10, 7, 1, 8),  # floor(-3/2) = -2: the shift is not symmetric
        (0, 10, 13, 2, 10),  # short of a target that lies above
        (4, 10, 13, 1, 12),  # 1.5 rounds up
        (4, 10, 7, 1, 9),  # -1.5 rounds up as well
        (4, 10, 11, 2, 10),  # a quarter rounds to nothing
        (4, 10, 12, 2, 11),  # a half rounds up
        (4, 10, 63, 0, 63),  # k = 0 goes all the way
    ],
)
def test_rounds_with_fractional_bits_and_floors_without(frac: int, value: int, target: int, k: int, result: int) -> None:
    found = evaluate("approach", {"W": 6, "FRAC": frac}, {"value": value, "target": target, "k": k}, ["result"])
    assert found["result"].tolist() == [result]


@pytest.mark.parametrize(("w", "frac"), [(1, 0), (24, 8)])
def test_lints_clean(w: int, frac: int) -> None:
    assert lint("approach", W=w, FRAC=frac) == (0, "")


@pytest.mark.parametrize(
    ("parameters", "rule"),
    [({"W": 0}, "W_must_be_1_to_24"), ({"W": 25}, "W_must_be_1_to_24"), ({"FRAC": 9}, "FRAC_must_be_0_to_8")],
)
def test_refuses_parameters_out_of_range(parameters: dict[str, int], rule: str) -> None:
    code, log = lint("approach", **parameters)
    assert code != 0
    assert rule in log

# SPDX-License-Identifier: Apache-2.0
"""array_lowest.v: the lowest bit that is set, and whether there is one."""

from __future__ import annotations

import numpy as np
import pytest

from support.testing import evaluate, lint


@pytest.mark.parametrize(("n", "slot_w"), [(1, 1), (5, 3), (8, 3), (12, 4)])
def test_every_set_of_bits(n: int, slot_w: int) -> None:
    among = np.arange(1 << n)
    result = evaluate(
        "array_lowest", {"N": n, "SLOT_W": slot_w}, {"among": among, "asked": np.ones_like(among)}, ["any", "lowest"]
    )
    lowest = [next((i for i in range(n) if one >> i & 1), 0) for one in among.tolist()]
    np.testing.assert_array_equal(result["any"], among > 0)
    np.testing.assert_array_equal(result["lowest"][1:], lowest[1:])


@pytest.mark.parametrize("n", [32, 62])
def test_each_bit_with_others_above_it(n: int) -> None:
    rng = np.random.default_rng(n)
    place = rng.integers(0, n, 500)
    among = [1 << at | int(rng.integers(1 << 62)) << at + 1 & (1 << n) - 1 for at in place.tolist()]
    result = evaluate(
        "array_lowest", {"N": n, "SLOT_W": (n - 1).bit_length()}, {"among": among, "asked": [1] * 500}, ["lowest"]
    )
    np.testing.assert_array_equal(result["lowest"], place)


@pytest.mark.parametrize(("n", "slot_w"), [(1, 1), (21, 5), (64, 6)])
def test_lints_clean(n: int, slot_w: int) -> None:
    assert lint("array_lowest", N=n, SLOT_W=slot_w) == (0, "")

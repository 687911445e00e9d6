# SPDX-License-Identifier: Apache-2.0
"""array_products.v: any of three, two of them complements, shifted, where that is wanted."""

from __future__ import annotations

import numpy as np
import pytest

from support.testing import evaluate, lint

W = 9


@pytest.mark.parametrize("by", [0, 1, 2, 8])
def test_random_words(by: int) -> None:
    rng = np.random.default_rng(by)
    a, b, c = rng.integers(-1 << W - 1, 1 << W - 1, (3, 400))
    c[::3], a[1::3], b[2::3] = 0, 0, 0
    wanted = rng.integers(0, 2, 400)
    mask = (1 << W) - 1
    ports = {"a_not": ~a & mask, "b_not": ~b & mask, "c": c & mask, "wanted": wanted}
    result = evaluate("array_products", {"W": W, "BY": by}, ports, ["y"])["y"]
    assert result.tolist() == (((a >> by | b >> by | c >> by) & mask) * wanted).tolist()


def test_lints_clean() -> None:
    assert lint("array_products", W=1) == (0, "")
    assert lint("array_products") == (0, "")

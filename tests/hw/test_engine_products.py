# SPDX-License-Identifier: Apache-2.0
"""engine_products.v: which of three, two of them complements, where a fourth lets it through."""

from __future__ import annotations

from itertools import product

import numpy as np

from evcot_cosim.testing import evaluate, lint


def test_every_combination_in_every_bit() -> None:
    columns = np.array(list(product((0, 1), repeat=4)))
    words = (columns << np.arange(16)[:, None]).sum(axis=0)  # bit i: combination i
    for turn in range(16):
        a, b, c, d = ((words << turn | words >> 16 - turn) & 0xFFFF).tolist()
        ports = {"a_not": a ^ 0xFFFF, "b_not": b ^ 0xFFFF, "c": c, "d": d}
        told = evaluate("engine_products", {"W": 16}, ports, ["y"])["y"]
        bits = [int(any(columns[(i - turn) % 16, :3]) and bool(columns[(i - turn) % 16, 3])) for i in range(16)]
        assert told.tolist() == [sum(bit << i for i, bit in enumerate(bits))]


def test_lints_clean() -> None:
    assert lint("engine_products", W=1) == (0, "")
    assert lint("engine_products") == (0, "")

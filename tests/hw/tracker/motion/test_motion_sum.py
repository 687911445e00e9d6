# SPDX-License-Identifier: Apache-2.0
"""motion_sum.v: b or -b, added to a or to nothing."""

from __future__ import annotations

import numpy as np

from support.testing import evaluate


def test_every_operand_and_choice() -> None:
    a, b, adds, minus = (axis.ravel() for axis in np.meshgrid(range(16), range(16), range(2), range(2)))
    result = evaluate("motion_sum", {"W": 4}, {"a": a, "b": b, "adds": adds, "minus": minus}, ["y"])["y"]
    np.testing.assert_array_equal(result, (a * adds + np.where(minus, -b, b)) % 16)

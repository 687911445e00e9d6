# SPDX-License-Identifier: Apache-2.0
"""engine_choice.v: a number that is known, or another one where that is wanted."""

from __future__ import annotations

import numpy as np

from evcot_cosim.testing import evaluate, lint


def test_every_pair_of_numbers() -> None:
    known, lowest, wanted = (axis.ravel() for axis in np.meshgrid(range(8), range(8), range(2)))
    ports = {"known": np.where(wanted, 0, known), "lowest": lowest, "wanted": wanted}
    told = evaluate("engine_choice", {"SLOT_W": 3}, ports, ["slot"])["slot"]
    np.testing.assert_array_equal(told, np.where(wanted, lowest, known))


def test_lints_clean() -> None:
    assert lint("engine_choice", SLOT_W=1) == (0, "")

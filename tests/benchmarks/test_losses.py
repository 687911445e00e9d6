# SPDX-License-Identifier: Apache-2.0
"""When an object is missed, and what is there instead."""

from __future__ import annotations

import numpy as np
import pytest

from evcot.metrics.frames import Matches
from losses import Boxes, instead, when

CAR, OTHER = [10.0, 10.0, 4.0, 4.0], [22.0, 10.0, 4.0, 4.0]


def boxes(*rows: list[float]) -> Boxes:
    return np.array(rows, np.float64).reshape(-1, 4)


@pytest.mark.parametrize(("frame", "of", "said"), [(1, 0, "before"), (3, 0, "between"), (7, 0, "after"), (3, 1, "never")])
def test_when_an_object_is_missed(frame: int, of: int, said: str) -> None:
    matches = Matches(np.array([2, 5, 3]), np.array([0, 0, 2]), np.array([4, 4, 4]), np.ones(3))
    assert when(matches, frame, of) == said


@pytest.mark.parametrize(
    ("reported", "others", "said"),
    [
        ([[16.0, 10.0, 12.0, 5.0]], [CAR], "box over several"),
        ([[12.0, 10.0, 6.0, 5.0]], [CAR], "box beside"),
        ([[13.0, 12.0, 1.0, 1.0]], [], "box beside"),  # in it, but not over its centre
        ([OTHER], [CAR], "not reported"),
        ([OTHER], [], "nothing"),
    ],
)
def test_what_is_there_instead(reported: list[list[float]], others: list[list[float]], said: str) -> None:
    assert instead(np.array(CAR), boxes(CAR, OTHER), boxes(*reported), boxes(*others)) == said

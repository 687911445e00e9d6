# SPDX-License-Identifier: Apache-2.0
"""Settings of the frame pipeline: refused outside their ranges, in one line."""

from __future__ import annotations

from typing import Any

import pytest

from evcot.errors import ConfigError
from evcot.trackers.frame_based.config import FRAME_RANGES, FrameConfig


@pytest.mark.parametrize("field", FRAME_RANGES)
def test_each_field_has_its_range(field: str) -> None:
    low, high, meaning = FRAME_RANGES[field]
    for value in (low - 1, high + 1, "7", True):
        wrong: dict[str, Any] = {field: value}
        with pytest.raises(ConfigError, match=rf"^frames\.{field} = .*: must be from .* \(") as caught:
            FrameConfig(**wrong)
        assert meaning in str(caught.value)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"median_px": 4}, "frames.median_px = 4: must be odd, so that the square has a middle"),
        ({"area_min_px": 9, "area_max_px": 8}, "frames.area_min_px = 9: must be at most area_max_px = 8"),
    ],
)
def test_what_contradicts_itself_is_refused(wrong: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigError) as caught:
        FrameConfig(**wrong)
    assert str(caught.value) == message

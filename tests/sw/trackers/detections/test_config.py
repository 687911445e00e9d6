# SPDX-License-Identifier: Apache-2.0
"""Settings of the baselines: refused outside their ranges, in one line."""

from __future__ import annotations

from typing import Any

import pytest

from evcot.errors import ConfigError
from evcot.trackers.frame_based.config import FRAME_RANGES, FrameConfig
from evcot.trackers.mean_shift.config import MEAN_SHIFT_RANGES, MeanShiftConfig

RANGES = [("frames", FrameConfig, field, *FRAME_RANGES[field]) for field in FRAME_RANGES]
RANGES += [("mean_shift", MeanShiftConfig, field, *MEAN_SHIFT_RANGES[field]) for field in MEAN_SHIFT_RANGES]


@pytest.mark.parametrize(("name", "config", "field", "low", "high", "meaning"), RANGES)
def test_each_field_has_its_range(name: str, config: Any, field: str, low: float, high: float, meaning: str) -> None:
    for value in (low - 1, high + 1, "7", True, float("nan")):
        with pytest.raises(ConfigError, match=rf"^{name}\.{field} = .*: must be from .* \(") as caught:
            config(**{field: value})
        assert meaning in str(caught.value)


def test_a_median_filter_has_an_odd_side() -> None:
    with pytest.raises(ConfigError, match=r"^frames\.median_px = 4: must be odd, so that the square has a middle$"):
        FrameConfig(median_px=4)

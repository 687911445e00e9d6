# SPDX-License-Identifier: Apache-2.0
"""Settings of the clustering: refused outside their ranges, in one line."""

from __future__ import annotations

from typing import Any

import pytest

from evcot.errors import ConfigError
from evcot.trackers.mean_shift.config import MEAN_SHIFT_RANGES, MeanShiftConfig
from evcot.trackers.mean_shift.presets import PRESETS


@pytest.mark.parametrize("field", MEAN_SHIFT_RANGES)
def test_each_field_has_its_range(field: str) -> None:
    low, high, meaning = MEAN_SHIFT_RANGES[field]
    for value in (low - 1, high + 1, "7", True, float("nan")):
        wrong: dict[str, Any] = {field: value}
        with pytest.raises(ConfigError, match=rf"^mean_shift\.{field} = .*: must be from .* \(") as caught:
            MeanShiftConfig(**wrong)
        assert meaning in str(caught.value)


def test_a_source_is_of_events_or_of_frames() -> None:
    wrong: dict[str, Any] = {"source": "pixels"}
    with pytest.raises(ConfigError, match=r"^mean_shift\.source = 'pixels': must be one of events, frames$"):
        MeanShiftConfig(**wrong)


def test_presets_by_name() -> None:
    assert [PRESETS[name].source for name in ("discs", "discs-frames", "traffic", "traffic-frames")] == 2 * ["events", "frames"]

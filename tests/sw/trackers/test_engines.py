# SPDX-License-Identifier: Apache-2.0
"""The registry of trackers, and their compiled loops on bursts of events."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
import pytest

import evcot
from evcot.hardware.modules import MODULES
from evcot.trackers import detections
from evcot.trackers.adaptive import tracker as adaptive
from evcot.trackers.engines import ENGINES
from evcot.trackers.mean_shift import tracker as mean_shift
from evcot.trackers.rct import tracker as rct
from support.logs import centre_errors_px

LOOPS: dict[str, Any] = {
    "adaptive": adaptive.feed,
    "rct": rct.feed,
    "mean-shift": mean_shift.event_points,
    "frames": detections.own,
}


def test_every_compiled_engine_is_tried() -> None:
    assert {*LOOPS, *MODULES} == {*ENGINES}  # a golden model counts ticks first: its columns are its own


@pytest.mark.usefixtures("kernels")
@pytest.mark.parametrize("engine", LOOPS)
def test_a_loop_is_compiled_once_whether_columns_can_be_written_or_not(engine: str) -> None:
    events = evcot.Events(np.arange(2, dtype=np.int64), *np.zeros((2, 2), np.uint16), np.zeros(2, np.uint8))
    compiled = []
    for columns in (events, events.read_only()):
        evcot.track(evcot.Recording(columns, 32, 32, "two events"), engine)
        compiled.append(len(LOOPS[engine].signatures))
    assert compiled[0] == compiled[1] > 0


@pytest.mark.parametrize("engine", ENGINES)
def test_a_sensor_that_would_take_gigabytes_is_refused(engine: str) -> None:
    events = evcot.Events(np.arange(2, dtype=np.int64), *np.zeros((2, 2), np.uint16), np.zeros(2, np.uint8))
    with pytest.raises(evcot.RecordingError) as caught:
        evcot.track(evcot.Recording(events, 65535, 65535, "two events"), engine)
    assert str(caught.value) == (
        "sensor 65535x65535: 4,294,836,225 pixels: must be at most 16,777,216 for this; "
        "--sensor WxH states a smaller sensor, where events lie within it"
    )


@pytest.mark.parametrize("step_ms", [5, 10, 20, 33, 50, 100])
@pytest.mark.parametrize("rows", [False, True])
def test_the_default_follows_what_moves_by_a_third_of_its_size_from_burst_to_burst(step_ms: int, rows: bool) -> None:
    """A quarter, where steps are short or events of a burst come row by row; a fifth, where both are."""
    per_burst = 1 / (3 + rows + (step_ms == 5))
    for side, slope in product((12, 24, 40), (0, 0.37, 1)):
        assert np.median(centre_errors_px("cot_motion", step_ms, side, per_burst, slope, rows)) < 2, (side, slope)

# SPDX-License-Identifier: Apache-2.0
"""What holds for every engine."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import evcot
from evcot.hardware.modules import MODULES
from evcot.trackers.adaptive import kernel as adaptive
from evcot.trackers.detections import identity
from evcot.trackers.engines import ENGINES
from evcot.trackers.mean_shift import clusters as mean_shift
from evcot.trackers.rct import kernel as rct

LOOPS: dict[str, Any] = {
    "adaptive": adaptive.feed,
    "rct": rct.feed,
    "mean-shift": mean_shift.event_points,
    "frames": identity.own,
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

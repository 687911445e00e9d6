# SPDX-License-Identifier: Apache-2.0
"""The registry of trackers, and their compiled loops on bursts of events."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import evcot
from evcot.events import Recording
from evcot.hardware.modules import MODULES
from evcot.trackers import detections
from evcot.trackers.adaptive import tracker as adaptive
from evcot.trackers.engines import ENGINES
from evcot.trackers.mean_shift import tracker as mean_shift
from evcot.trackers.rct import tracker as rct
from evcot.tracks.log import Kind
from support.logs import Square, bursts

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


SENSOR = (1280, 720)
PER_BURST = 1 / 8  # of its side that an object may move from burst to burst
SETTLED_BURSTS, BURSTS = 20, 40


@pytest.mark.parametrize("step_ms", [5, 10, 20, 33, 50, 100])
@pytest.mark.parametrize("side", [12, 24, 40])
@pytest.mark.parametrize("slope", [0, 0.37, 1])
def test_the_default_follows_what_moves_by_an_eighth_of_its_size_from_burst_to_burst(
    step_ms: int, side: int, slope: float
) -> None:
    vx = side * PER_BURST / (step_ms * 1e-3) / np.hypot(1, slope)
    square = Square(20.3, 20.7, vx, slope * vx, side)
    events = bursts(step_ms, [square], SENSOR, lasts_ms=BURSTS * step_ms)
    records = evcot.track(Recording(events, *SENSOR, "bursts")).records
    states = records[records["kind"] <= Kind.MOVED]
    errors_px = []
    for burst in range(SETTLED_BURSTS, BURSTS):
        t_us = burst * step_ms * 1_000
        recent = states[(states["t_us"] <= t_us) & (states["t_us"] > t_us - 2_000 * step_ms)]
        assert len(recent), f"no track at burst {burst}"
        x, y = (corner + (side - 1) / 2 for corner in square.corner(t_us))
        newest = [recent[recent["track_id"] == track_id][-1] for track_id in np.unique(recent["track_id"])]
        errors_px.append(min(np.hypot(state["x"] - x, state["y"] - y) for state in newest))
    assert np.median(errors_px) < 2

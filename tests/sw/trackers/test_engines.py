# SPDX-License-Identifier: Apache-2.0
"""The registry of trackers; their compiled loops, on bursts of events and over a gap of decades."""

from __future__ import annotations

from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import evcot
from evcot.events import Events
from evcot.filters.config import FilterConfig
from evcot.filters.hot_pixels import learn_hot_pixels
from evcot.filters.run import filtered
from evcot.hardware.modules import MODULES
from evcot.recordings.describe import describe
from evcot.recordings.files import open_recording, write_events
from evcot.trackers import detections
from evcot.trackers.adaptive import tracker as adaptive
from evcot.trackers.engines import ENGINES
from evcot.trackers.mean_shift import tracker as mean_shift
from evcot.trackers.rct import tracker as rct
from evcot.tracks.compare import compare
from evcot.tracks.tracking import log_of
from support.logs import centre_errors_px
from support.refusals import refused

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
    with refused(
        evcot.RecordingError,
        "sensor 65535x65535: 4,294,836,225 pixels: must be at most 16,777,216 for this; "
        "--sensor WxH states a smaller sensor, where events lie within it",
    ):
        evcot.track(evcot.Recording(events, 65535, 65535, "two events"), engine)


@pytest.mark.parametrize("step_ms", [5, 10, 20, 33, 50, 100])
@pytest.mark.parametrize("rows", [False, True])
def test_the_default_follows_what_moves_by_a_third_of_its_size_from_burst_to_burst(step_ms: int, rows: bool) -> None:
    """A quarter, where steps are short or events of a burst come row by row; a fifth, where both are."""
    per_burst = 1 / (3 + rows + (step_ms == 5))
    for side, slope in product((12, 24, 40), (0, 0.37, 1)):
        assert np.median(centre_errors_px("cot_motion", step_ms, side, per_burst, slope, rows)) < 2, (side, slope)


SENSOR = (64, 48)
NOW_US = 1_700_000_000_000_000


def with_gap() -> Events:
    """A square that moves for 200 ms, and does so again after decades."""
    random = np.random.default_rng(8)
    n = 8_000
    t_us = np.sort(random.integers(0, 200_000, n))
    x = (10 + t_us // 10_000 + random.integers(0, 8, n)).astype(np.uint16)
    y = (20 + random.integers(0, 8, n)).astype(np.uint16)
    p = random.integers(0, 2, n).astype(np.uint8)
    return Events.joined([Events(t_us, x, y, p), Events(NOW_US + t_us, x, y, p)])


@pytest.mark.parametrize("name", ENGINES)
def test_every_tracker_takes_a_gap_of_decades_in_one_step(name: str) -> None:
    """The test is that it terminates, and that both halves are tracked."""
    engine = ENGINES[name]
    for settings in engine.presets.values():
        log = log_of(name, engine.start(settings, FilterConfig(), SENSOR), [with_gap()])
        assert np.isfinite(log.records["x"]).all()
    assert (log.records["t_us"] < NOW_US).any()


def test_filters_and_descriptions_take_it_too(tmp_path: Path) -> None:
    events = with_gap()
    kept = filtered((), FilterConfig(), SENSOR).keep(events)
    assert kept is None or len(kept) == len(events)
    learn_hot_pixels(events, SENSOR)
    path = tmp_path / "decades.npz"
    write_events(path, SENSOR, [events])
    with open_recording(path) as file:
        found = describe(file)
    assert found.events == len(events)
    logs = [log_of(name, ENGINES[name].start(next(iter(ENGINES[name].presets.values())), FilterConfig(), SENSOR), [events])
            for name in ("rct", "cot_motion")]  # fmt: skip
    assert compare(*logs, span_us=(0, NOW_US + 200_000)).samples < 1 << 20

# SPDX-License-Identifier: Apache-2.0
"""A gap of decades in a recording takes no stage longer than any other gap: microseconds since 1970 after events at 0."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from evcot.events import Events
from evcot.filters.config import FilterConfig
from evcot.filters.hot_pixels import learn_hot_pixels
from evcot.filters.run import filtered
from evcot.recordings.describe import describe
from evcot.recordings.files import open_recording, write_events
from evcot.trackers.engines import ENGINES
from evcot.tracks.compare import compare
from evcot.tracks.tracking import log_of

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

# SPDX-License-Identifier: Apache-2.0
"""stamp_units.v: the units that have passed are those of the time since reset, whatever the shift was before."""

from __future__ import annotations

import numpy as np
import pytest

from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load
from support.testing import PATTERNS, Sink, Source, lint, run_streams


@pytest.mark.parametrize("tick_w", [1, 8, 20])
@pytest.mark.parametrize("pattern", PATTERNS)
def test_units_add_up_to_the_ticks_shifted(tick_w: int, pattern: str) -> None:
    rng = np.random.default_rng([92, tick_w])
    sim = load("stamp_units", {"TICK_W": tick_w, "DATA_W": 8})
    reset(sim)
    total = 0
    for shift in (0, 3, 15, 1):
        sim.io.shift = shift
        ticks = rng.integers(0, 1 << tick_w, 200)
        words = [(int(tick), int(data)) for tick, data in zip(ticks, rng.integers(0, 256, 200), strict=True)]
        source = Source(sim, "s", ("tick", "data"), words, PATTERNS[pattern](rng))
        sink = Sink(sim, "m", ("units", "data"), PATTERNS[pattern](rng))
        run_streams(sim, [source], [sink])
        passed = total + np.concatenate([[0], np.cumsum(ticks)])
        assert [word[0] for word in sink.words] == np.diff(passed >> shift).tolist()
        assert [word[1] for word in sink.words] == [data for _, data in words]
        total = int(passed[-1])
        assert sim.io.idle == 1


@pytest.mark.parametrize("tick_w", [1, 15, 16, 32])
def test_lints_clean(tick_w: int) -> None:
    assert lint("stamp_units", TICK_W=tick_w) == (0, "")

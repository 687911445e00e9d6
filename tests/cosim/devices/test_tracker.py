# SPDX-License-Identifier: Apache-2.0
"""The hardware as a tracker: what it returns is what the golden model returns, however the events are split."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from evcot.errors import RecordingError
from evcot.events import Events
from evcot.filters.config import FilterConfig
from evcot.hardware.config import CotConfig
from evcot.hardware.golden import GoldenTracker
from evcot.trackers.config import RunConfig
from evcot_cosim.devices.tracker import DeviceTracker


@pytest.mark.parametrize("filtered", [False, True])
def test_it_returns_what_the_golden_model_returns(config: CotConfig, blobs: Events, filtered: bool) -> None:
    if filtered:
        config = RunConfig(hardware=config, filters=FilterConfig(refractory_us=20)).device_config(128, 128)
    later = Events(blobs.t_us + 5_000_000, blobs.x, blobs.y, blobs.p)
    hardware, model = DeviceTracker(config), GoldenTracker(config)
    wanted, owners = model.feed(later)
    cuts = [0, 1, 7, 500, 501, 1_999, len(later)]
    got = [hardware.feed(later[begin:end]) for begin, end in pairwise(cuts)]
    assert np.array_equal(np.concatenate([records for records, _ in got]), wanted)
    assert np.array_equal(np.concatenate([owner for _, owner in got]), owners)
    assert len(wanted) > 100
    assert len(hardware.finish()) == 0
    assert hardware.settled == len(later)


def test_a_wait_that_is_too_long_is_refused_and_nothing_was_fed(config: CotConfig, blobs: Events) -> None:
    hardware = DeviceTracker(config)
    hardware.feed(blobs[:100])
    late = Events(blobs.t_us + (1 << 60), blobs.x, blobs.y, blobs.p)
    with pytest.raises(RecordingError, match="clocks of silence"):
        hardware.feed(late)
    assert hardware.settled == 100

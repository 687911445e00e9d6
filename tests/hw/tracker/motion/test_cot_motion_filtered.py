# SPDX-License-Identifier: Apache-2.0
"""Filters in front of the array with motion: hardware and golden model decide the same, in the camera's own numbers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from evcot.filters.contract import Filter, FilterShape
from evcot.filters.registers import FilterRegisters
from evcot.hardware.config import CotConfig
from evcot.hardware.cot import CotModel
from evcot.tracks.log import DROPPED
from evcot_cosim.devices.base import Stalls
from evcot_cosim.devices.device import Device
from support.moving import QUICK, SHAPE, scene
from support.testing import lint


@pytest.mark.parametrize("stalls", [None, 5])
def test_equals_the_model(stalls: int | None) -> None:
    filters = FilterRegisters(enable=1 << Filter.REFRACTORY, refractory_ticks=200)
    config = CotConfig(SHAPE, filters=filters, filter_shape=FilterShape(width=128, height=64, stamp_w=12), motion=QUICK)
    model = CotModel(config).feed(scene(1))
    waits = None if stalls is None else Stalls.random(np.random.default_rng(stalls))
    hardware = Device(config, stalls=waits).stream(scene(1))
    for name in model._fields:
        assert np.array_equal(getattr(hardware, name), getattr(model, name)), name
    assert 0 < np.count_nonzero(model.owner == DROPPED) < len(model.owner)
    assert len(model.records) > 20
    unfiltered = CotModel(replace(config, filters=FilterRegisters())).feed(scene(1))
    assert len(unfiltered.records) != len(model.records)


def test_lint() -> None:
    assert lint("cot_motion_filtered") == (0, "")

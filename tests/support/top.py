# SPDX-License-Identifier: Apache-2.0
"""Support for tests of `evcot_top`: a few elaborations of it, each of which takes a minute to compile, and traffic for them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from evcot.filters.contract import Filter, FilterShape
from evcot.hardware.config import CotConfig, MotionConfig, SlotConfig
from evcot.hardware.contract import Shape
from evcot.hardware.modules import Module
from evcot.ticks import TickedEvents
from evcot.trackers.presets import PRESETS, fit
from evcot_cosim.devices.top_device import Pace, TopDevice

from .moving import SHAPE
from .trials import random_traffic

__all__ = ["BUILDS", "DVS128", "EVERY", "SMALL", "Build", "device_of", "traffic_of"]

SMALL = Shape(n_slots=4, x_w=6, y_w=6, radix_w=5, nev_w=6, tc_w=12, sup_w=8, id_w=16, seq_w=32, time_w=32)
SENSOR = FilterShape(width=60, height=50, stamp_w=10, recent_depth=8)
EVERY = SlotConfig(  # a record for every event
    init_radix=4, radix_th=2, radix_step=1, radix_min=4, radix_max=6, hist_avg=1, max_ticks=4_000,
    clust_nev=1, nev_min=1, nev_max=1, nev_th=9, detect_ticks=90,
)  # fmt: skip
DVS128 = fit(PRESETS["dvs128"], 128, 128)


class Build(NamedTuple):
    """One elaboration of the top; each takes a minute to compile."""

    shape: Shape
    filter_shape: FilterShape
    parameters: Mapping[str, int]
    module: Module = "cot_array"


BUILDS = {
    "array behind filters": Build(SMALL, SENSOR, {"SOURCES": 3, "HAS": 255, "FIFO_DEPTH": 40}),
    "array": Build(
        DVS128.hardware.shape,
        FilterShape(128, 128),
        {"HAS": 3, "DATA_W": 256, "FIFO_DEPTH": 16, "RECORD_DEPTH": 3},
    ),
    "sources": Build(
        Shape(n_slots=2, x_w=8, y_w=8),
        FilterShape(200, 150),
        {"SOURCES": 63, "SOURCE": 3, "FIFO_DEPTH": 16},
    ),
    "chain": Build(SMALL, FilterShape(64, 64), {"DATA_W": 32, "FIFO_DEPTH": 1, "RECORD_DEPTH": 1}, "cot_chain"),
    "motion": Build(
        SHAPE,
        FilterShape(128, 64, stamp_w=12),
        {"HAS": 1 << Filter.REFRACTORY, "DATA_W": 128, "FIFO_DEPTH": 16, "RECORD_DEPTH": 3},
        "cot_motion",
    ),
    "classifier": Build(
        replace(SHAPE, radix_w=6),
        FilterShape(128, 64, stamp_w=12),
        {"CLASSIFY": 1, "DATA_W": 128, "FIFO_DEPTH": 16, "RECORD_DEPTH": 3},
        "cot_motion",
    ),
    "classifier of one slot": Build(
        Shape(n_slots=1, x_w=7, y_w=6), FilterShape(128, 64), {"CLASSIFY": 1, "FIFO_DEPTH": 16, "RECORD_DEPTH": 8}, "cot_motion"
    ),
}


def device_of(name: str, config: CotConfig | MotionConfig | None = None, *, pace: Pace | None = None) -> TopDevice:
    """A device of one of the builds; `config` supplies the slots and filters, the build the shapes."""
    build = BUILDS[name]
    if config is None:
        config = MotionConfig(build.shape) if build.module == "cot_motion" else CotConfig.uniform(build.shape, EVERY)
    if isinstance(config, CotConfig):
        config = replace(config, module=build.module)
    return TopDevice(replace(config, filter_shape=build.filter_shape), build.parameters, pace=pace)


def traffic_of(rng: np.random.Generator, build: Build, n: int, since: int = 0) -> TickedEvents:
    """Random events on the sensor, from tick `since` on."""
    traffic = random_traffic(rng, build.shape, n, float(rng.choice([0.3, 2])), since)
    x, y = traffic.x % build.filter_shape.width, traffic.y % build.filter_shape.height
    return replace(traffic, x=x, y=y)

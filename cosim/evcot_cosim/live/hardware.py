# SPDX-License-Identifier: Apache-2.0
"""The hardware beside a live session: the RTL in simulation as long as it keeps up, its golden model from then on."""

from __future__ import annotations

import numpy as np

from evcot.errors import ToolchainError
from evcot.events import Events
from evcot.hardware.config import CotConfig, MotionConfig
from evcot.hardware.golden import GoldenTracker
from evcot.recordings.formats.source import Sensor
from evcot.tracks.tracking import Tracker

from ..devices.device import build_device
from ..devices.tracker import DeviceTracker
from .tracker_thread import Beside

__all__ = ["HARDWARE", "hardware_beside", "warm_up"]

HARDWARE = "hardware"
_RTL, _MODEL = "RTL in simulation", "golden model"
_BLOB_EVENTS = 4_000


def hardware_beside(config: CotConfig | MotionConfig, sensor: Sensor) -> Beside:
    """The module with this configuration; compiled where that has not been done, which takes 10 to 60 s.

    The golden model decides as the RTL does, bit for bit. It is there from the start where the RTL
    cannot be compiled, and takes over, beginning anew, when events come faster than the simulation takes them.
    """
    warm_up(GoldenTracker(config), sensor)
    try:
        tracker = DeviceTracker(config, model=build_device(config, waves=False))
    except ToolchainError as error:
        return Beside(HARDWARE, f"{_MODEL}; {error}", GoldenTracker(config))
    return Beside(HARDWARE, _RTL, tracker, (_MODEL, lambda: GoldenTracker(config)))


def warm_up(tracker: Tracker, sensor: Sensor) -> None:
    """Have everything compiled before the first event comes: a blob that rests for a while does it."""
    random = np.random.default_rng(0)
    x, y = ((side / 2 + random.normal(0, 2, _BLOB_EVENTS)).clip(0, side - 1).astype(np.uint16) for side in sensor)
    polarity = random.integers(2, size=_BLOB_EVENTS).astype(np.uint8)
    tracker.feed(Events(np.arange(_BLOB_EVENTS, dtype=np.int64) * 20, x, y, polarity))
    tracker.finish()

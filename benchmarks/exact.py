# SPDX-License-Identifier: Apache-2.0
"""Runs a recording through hardware and golden model in lock-step and returns their common log."""

from __future__ import annotations

import numpy as np

from evcot.events import Recording
from evcot.hardware.contract import RECORD
from evcot.hardware.golden import to_track_records, track
from evcot.trackers.config import RunConfig
from evcot.tracks.log import TrackLog
from evcot_cosim.devices.device import build_device
from evcot_cosim.lockstep.lockstep import Lockstep, chunks

__all__ = ["cot_log"]


def cot_log(recording: Recording, config: RunConfig, *, rtl: bool = True) -> TrackLog:
    """The hardware tracker's log of a recording of at least one event; without `rtl`, that of the golden model alone.

    Raises:
        MismatchError: hardware and model differ.
    """
    cot = config.device_config(recording.width, recording.height)
    if not rtl:
        return track(recording, cot)
    events = recording.events
    with Lockstep(cot, model=build_device(cot, waves=False)) as lockstep:
        steps = [lockstep.feed(run).hardware for run in chunks(events)]
    raw = np.concatenate([np.empty(0, RECORD), *(step.records for step in steps)])
    records = to_track_records(raw, cot, events.t_us, 0, int(events.t_us[0]))
    return TrackLog(cot.module, records, np.concatenate([step.owner for step in steps]))

# SPDX-License-Identifier: Apache-2.0
"""Real recordings, whole and checked, against real time; skipped where they are not at hand."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from statistics import median

import streams
from evcot.recordings.files import read_recording
from evcot.trackers.presets import fit, for_sensor
from evcot_cosim.devices.device import build_device
from evcot_cosim.lockstep.lockstep import Lockstep, chunks
from measure import Goal, Result, Skip
from shared import SHARED

__all__ = ["measure"]

_GOALS = {"traffic_outbound.aedat4": 10.0, "hand_dvs128.aedat4": None}  # times real time


def measure(_folder: Path, quick: bool) -> Iterator[Result]:
    """realtime_* for each recording."""
    found = {SHARED / name: goal for name, goal in _GOALS.items() if (SHARED / name).is_file()}
    if not found:
        raise Skip(f"no recordings in {SHARED}")
    for path, goal in found.items():
        yield _one(path, goal, 3 if quick else 7)


def _one(path: Path, goal: float | None, rounds: int) -> Result:
    recording = read_recording(path)
    config = fit(for_sensor(recording.width), recording.width, recording.height, streams.SLOTS).hardware
    model = build_device(config, waves=False)
    walls: list[float] = []
    for _ in range(rounds):
        with Lockstep(config, model=model) as lockstep:
            for run in chunks(recording.events):
                lockstep.feed(run)
            walls.append(lockstep.wall_s)
    wall_s = median(walls)
    events = len(recording.events)
    return Result(
        f"realtime_{path.stem}", recording.duration_us / 1e6 / wall_s, "x real time", goal, "goal" if goal else "",
        goal=Goal(1) if goal else None,
        how=f"{events:,} events, {streams.SLOTS} slots, checked, {events / wall_s / 1e6:.2f} M events/s",
    )  # fmt: skip

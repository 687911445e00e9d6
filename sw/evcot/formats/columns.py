# SPDX-License-Identifier: Apache-2.0
"""What a file that is read at once says."""

from __future__ import annotations

from dataclasses import dataclass

from ..events import Events

__all__ = ["Decoded", "Sensor", "smallest_sensor"]

Sensor = tuple[int, int]


@dataclass(frozen=True)
class Decoded:
    """What a file says: its events, and the sensor's (width, height) in pixels, given or inferred."""

    events: Events
    sensor: Sensor


def smallest_sensor(events: Events) -> Sensor:
    """The smallest (width, height) that holds every event; (1, 1) for none."""
    if not len(events):
        return 1, 1
    return int(events.x.max()) + 1, int(events.y.max()) + 1

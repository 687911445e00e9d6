# SPDX-License-Identifier: Apache-2.0
"""Follows lines through the spikes of the transform, on an angle axis that is cyclic; docs/lines.md has the rules."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..events import Events
from ._follower_kernel import FIELDS, SLOTS, follow
from .contract import HoughConfig
from .transform import HoughTransform

__all__ = ["LINE", "LineFollower"]

LINE = np.dtype([("t_us", "<i8"), ("line_id", "<i4"), ("angle_deg", "<f8"), ("rho_px", "<f8"), ("turn_deg_s", "<f8")])
"""A measurement of a line: time, id from 1, direction of its normal, distance from the middle of the sensor, turning speed.

A point (x, y) of the line, in pixels from the middle of the sensor, has x cos(angle) + y sin(angle) = rho. The angle of a line
is continuous: it goes beyond 180 degrees and below 0, and rho keeps its sign meanwhile.
"""


class LineFollower:
    """The lines in a stream of events: feed events in blocks of any length.

    Args:
        config: shape and registers of the transform.
    """

    def __init__(self, config: HoughConfig) -> None:
        self._transform = HoughTransform(config)
        self._config = config
        self._slots = np.zeros((SLOTS, FIELDS))
        self._counts = np.zeros(2, np.int64)  # spikes, ids

    def feed(self, events: Events) -> NDArray[np.void]:
        """The lines of a block of events: (m,) of dtype `LINE`, one entry for each spike of a line, in time order."""
        first = self._transform.events
        spikes = self._transform.feed(events.x, events.y)
        index = spikes["event"] - first
        config = self._config
        x = events.x[index] - (config.width - 1) / 2
        y = events.y[index] - (config.height - 1) / 2
        lines = np.empty(len(spikes), LINE)
        columns = tuple(lines[name] for name in LINE.names or ())
        t_us = events.t_us[index]
        return lines[: follow(t_us, x, y, spikes["angle"], np.pi / config.angles, self._slots, self._counts, columns)].copy()

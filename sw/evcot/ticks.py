# SPDX-License-Identifier: Apache-2.0
"""Time in the hardware: ticks since the first event of a run, and events with times in ticks."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

__all__ = ["TickedEvents", "tick_times"]


class TickedEvents(NamedTuple):
    """Events with times in ticks, the input of trackers and filters in hardware.

    Attributes:
        ticks: (n,) int64, ticks since reset at each event, never decreasing.
        x, y: (n,) uint16 pixel addresses.
        p: (n,) uint8 polarities, 0 or 1.
    """

    ticks: NDArray[np.int64]
    x: NDArray[np.uint16]
    y: NDArray[np.uint16]
    p: NDArray[np.uint8]


def tick_times(t_us: NDArray[np.int64], t0_us: int, tick_us: int) -> NDArray[np.int64]:
    """Number of ticks elapsed since `t0_us` at each event: floor((t - t0) / tick_us), (n,) int64."""
    since = t_us - t0_us
    return since if tick_us == 1 else since // tick_us

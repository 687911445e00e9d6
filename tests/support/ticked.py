# SPDX-License-Identifier: Apache-2.0
"""Ticked events from plain numbers, for short stories."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from evcot.ticks import TickedEvents

__all__ = ["ticked"]


def ticked(ticks: ArrayLike, x: ArrayLike, y: ArrayLike, p: ArrayLike = 0) -> TickedEvents:
    """Events whose columns are integers of any type; one number stands for all events."""
    return TickedEvents(*np.broadcast_arrays(np.atleast_1d(ticks), x, y, p))

# SPDX-License-Identifier: Apache-2.0
"""Correction by the mean place and the mean spread of an object's pixels along an axis, beside that by pixels beyond its sides.

A side that runs away from its object leaves few pixels behind it, which tell little: the quantile of `kalman.motion` follows an
object that turns back slowly, and its box grows. The mean place of the pixels moves with the object at once. It lies off the
centre, by the edges that are stronger, and so its usual offset, and the usual spread, are learnt while the object travels;
only differences from these correct it. Near the sensor's edge and beside other objects neither is usual.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..._numba_private import step
from ..kalman.motion import observe
from .layout import Rules, World

__all__ = ["correct_by_centroid"]

Table = NDArray[Any]

_PIXELS = 30.0  # from which the usual place and spread are known
_LEARNT = 1.0  # half sides of travel before they count
_KEEPS = 3.0  # half sides of travel for which they are kept
_VARIANCE = 0.35  # of a pixel's place, in squares of the half side
_UNSURE = 0.3  # standard deviation of what is usual, half sides
_LEAST_SPREAD = 0.1  # half sides


@step
def correct_by_centroid(rules: Rules, world: World, i: int, axis: int, n: float, noise: float, went: float) -> None:
    """Correct an object's centre and half side along an axis, and learn from the packet what is usual.

    Args:
        n: its pixels between the sides of the other axis, without the noise.
        noise: pixels of noise among them.
        went: half sides that it travelled in the packet.
    """
    o = world.objects[i]
    s, p = world.state[i, axis], world.cov[i, axis]
    half = s[2]
    last = (rules.width if axis == 0 else rules.height) - 1.0
    if o.meets or o.enters >= 0 or s[0] - half - o.gate < 0.0 or s[0] + half + o.gate > last:
        return
    place = world.moments[i, axis, 0] / n
    spread = (world.moments[i, axis, 1] - 0.5 * noise * (half + o.gate)) / n
    usual = world.usual[i, axis]
    if usual[0] > _PIXELS and o.drawn > _LEARNT:
        variance = rules.events_per_sample * _VARIANCE * (half * (1.0 + noise / n)) ** 2 / n
        known = (_UNSURE * half) ** 2
        observe(s, p, 0, place - usual[1] / usual[0] * half, variance + known)
        ratio = max(usual[2] / usual[0], _LEAST_SPREAD)
        observe(s, p, 2, spread / ratio - half, variance / (ratio * ratio) + known)
    keep = np.exp(-went / _KEEPS)
    for k in range(3):
        usual[k] *= keep
    usual[0] += n
    usual[1] += n * place / half
    usual[2] += n * spread / half

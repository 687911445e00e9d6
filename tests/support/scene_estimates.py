# SPDX-License-Identifier: Apache-2.0
"""Estimates of two scenes, one with objects of several sizes and one with objects alike, and changes of them."""

from __future__ import annotations

from dataclasses import replace

from evcot.trackers.adaptive.estimates import Estimates, Objects, Spread


def spread(median: float, by: float = 1.0) -> Spread:
    return Spread(median / by, median, median * by)


MIXED = Estimates(
    (346, 260), 4_000_000, 800_000, 0.01, ((3, 4),), 4, 7, Objects(spread(16, 2), spread(20, 2), spread(60, 3), spread(80))
)
ALIKE = replace(MIXED, objects=Objects(spread(9), spread(9), spread(120), spread(150)))

# SPDX-License-Identifier: Apache-2.0
"""Counts of a log that grows: what is alive."""

from __future__ import annotations

import numpy as np

from evcot.tracks.record import TRACK, Kind
from evcot.tracks.tally import Tally


def test_a_track_that_was_lost_and_is_found_again_is_alive() -> None:
    kinds = [Kind.BORN, Kind.MOVED, Kind.BORN, Kind.LOST, Kind.LOST, Kind.MOVED, Kind.BORN, Kind.MERGED]
    records = np.zeros(len(kinds), TRACK)
    records["kind"] = kinds
    records["track_id"] = [0, 0, 1, 0, 1, 0, 2, 2]
    records["t_us"] = np.arange(len(kinds))
    for size in (1, 3, len(kinds)):
        tally = Tally()
        for begin in range(0, len(kinds), size):
            tally.add(records[begin : begin + size], np.empty(0, np.int16))
        assert tally.alive == 1
        assert tally.kinds[Kind.LOST] == 2

# SPDX-License-Identifier: Apache-2.0
"""The golden model of the extended contract: tables and registers around the compiled kernel."""

from __future__ import annotations

from dataclasses import astuple

import numpy as np
from numpy.typing import NDArray

from ...ticks import TickedEvents
from ..contract import Shape
from ._kernel import RECORDS_PER_SLOT, feed, initialise, restart, restep
from ._places import ROWS, extent
from ._state import FIELD_COUNT, GLOBAL_COUNT, ID_MASK, LIMIT_COUNT, NOW, REACH, REL_MASK, SUPPORT_MAX
from .contract import MOTION_RECORD, SUB, MotionRegisters

__all__ = ["MotionModel"]

_SPARE_RECORDS = 4096  # in the buffer of the compiled loop, beside those of a motion step


class MotionModel:
    """The state of an array with motion, and what events do to it.

    Args:
        modes: start mode of each slot, off or seeded.
    """

    def __init__(self, shape: Shape, registers: MotionRegisters, modes: list[int]) -> None:
        self._registers = np.array(astuple(registers), np.int64)
        self._limits = np.zeros(LIMIT_COUNT, np.int64)
        self._limits[ID_MASK] = (1 << shape.id_w) - 1
        self._limits[SUPPORT_MAX] = (1 << shape.sup_w) - 1
        self._limits[REL_MASK] = (1 << shape.rel_w) - 1
        self._limits[REACH] = 1 << (shape.reach_log2 + SUB)
        self._modes = np.array(modes, np.int64)
        self._state = np.zeros((shape.n_slots, FIELD_COUNT), np.int64)
        self._globals = np.zeros(GLOBAL_COUNT, np.int64)
        self._buffer = np.zeros(RECORDS_PER_SLOT * shape.n_slots + _SPARE_RECORDS, MOTION_RECORD)
        self._places = np.zeros((ROWS, extent(shape.x_w, shape.y_w)), np.uint64)
        initialise(self._state, self._registers, self._globals, self._modes, self._places)

    def feed(
        self,
        events: TickedEvents,
        kept: NDArray[np.int64],
        owner: NDArray[np.int16],
        rel_x: NDArray[np.uint16],
        rel_y: NDArray[np.uint16],
    ) -> NDArray[np.void]:
        """Process a run of events, fill in what was decided on each, and return the records, (m,) MOTION_RECORD.

        Args:
            kept: numbers of the events that passed external filters, in order.
            owner: holds `DROPPED`, which stays where an event was not kept.
            rel_x, rel_y: hold zeros, which stay where an event has no owner.
        """
        done = 0
        parts: list[NDArray[np.void]] = []
        while done < len(events):
            done, count = feed(
                self._state, self._registers, self._limits, self._globals, self._modes, self._places,
                events.ticks, events.x, events.y, kept, done, owner, rel_x, rel_y, self._buffer,
            )  # fmt: skip
            parts.append(self._buffer[:count].copy())
        return np.concatenate(parts) if parts else np.zeros(0, MOTION_RECORD)

    def set_mode(self, slot: int, mode: int) -> NDArray[np.void]:
        """Restart a slot in another mode; returns the record of the life that ends, (m,) MOTION_RECORD."""
        self._modes[slot] = mode
        room = np.zeros(1, MOTION_RECORD)
        return room[: restart(self._state, self._globals, self._modes, self._places, slot, room)]

    def write(self, registers: MotionRegisters) -> None:
        """Change the registers of the whole array before the next event; lives go on."""
        self._registers[:] = astuple(registers)
        restep(self._registers, self._globals)

    @property
    def time(self) -> int:
        """Ticks since reset, at the last event."""
        return int(self._globals[NOW])

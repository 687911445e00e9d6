# SPDX-License-Identifier: Apache-2.0
"""The golden model of `cot_motion`: tables and registers around the compiled kernel. docs/motion.md specifies the rules."""

from __future__ import annotations

from dataclasses import astuple

import numpy as np
from numpy.typing import NDArray

from ...errors import ConfigError
from ...ticks import TickedEvents
from ..config import MotionConfig
from ..contract import Mode
from ..model import GoldenModel
from ._kernel import RECORDS_PER_STEP, feed, initialise, restart, restep
from ._places import ROWS, extent
from ._state import FIELD_COUNT, GLOBAL_COUNT, ID_MASK, LIMIT_COUNT, NOW, REACH, REL_MASK, SLOTS_LOG2, STEP_LOG2, SUPPORT_MAX
from .contract import MOTION_RECORD, SUB, MotionRegisters

__all__ = ["MotionModel"]

_SPARE_RECORDS = 4096  # in the buffer of the compiled loop, beside those of a slot's motion step


class MotionModel(GoldenModel):
    """See `GoldenModel`."""

    def __init__(self, config: MotionConfig) -> None:
        super().__init__(config)
        shape = config.shape
        self.config = config
        self._registers = np.array(astuple(config.registers), np.int64)
        self._limits = np.zeros(LIMIT_COUNT, np.int64)
        self._limits[ID_MASK] = (1 << shape.id_w) - 1
        self._limits[SUPPORT_MAX] = (1 << shape.sup_w) - 1
        self._limits[REL_MASK] = (1 << shape.rel_w) - 1
        self._limits[SLOTS_LOG2] = (shape.n_slots - 1).bit_length()
        self._limits[REACH] = 1 << (shape.reach_log2 + SUB)
        self._modes = np.array(config.modes, np.int64)
        self._state = np.zeros((shape.n_slots, FIELD_COUNT), np.int64)
        self._globals = np.zeros(GLOBAL_COUNT, np.int64)
        self._buffer = np.zeros(RECORDS_PER_STEP + _SPARE_RECORDS, MOTION_RECORD)
        self._places = np.zeros((ROWS, extent(shape.x_w, shape.y_w)), np.uint64)
        initialise(self._state, self._registers, self._globals, self._modes, self._places)

    def _decide(
        self,
        events: TickedEvents,
        keep: NDArray[np.bool_] | None,
        owner: NDArray[np.int16],
        rel_x: NDArray[np.uint16],
        rel_y: NDArray[np.uint16],
        visible: NDArray[np.bool_],
    ) -> NDArray[np.void]:
        kept = np.arange(len(events)) if keep is None else np.flatnonzero(keep)
        done = 0
        parts: list[NDArray[np.void]] = []
        while done < len(events):
            done, count = feed(
                self._state, self._registers, self._limits, self._globals, self._modes, self._places,
                events.ticks, events.x, events.y, kept, done, owner, rel_x, rel_y, visible,
                self._buffer,
            )  # fmt: skip
            parts.append(self._buffer[:count].copy())
        return np.concatenate(parts) if parts else np.zeros(0, MOTION_RECORD)

    def write_mode(self, slot: int, mode: int) -> NDArray[np.void]:
        """Restart a slot in a mode; returns the record of the life that ends, (m,) MOTION_RECORD.

        Raises:
            ConfigError: neither off nor seeded.
        """
        if mode not in (Mode.OFF, Mode.SEEDED):
            raise ConfigError(f"slot[{slot}].mode = {int(mode)}: must be 0 (off) or 2 (seeded)")
        self._modes[slot] = mode
        room = np.zeros(1, MOTION_RECORD)
        return room[: restart(self._state, self._limits, self._globals, self._modes, self._places, slot, room)]

    def write_registers(self, registers: MotionRegisters) -> None:
        """Change the registers of all slots before the next event, as commits do; tracks go on: docs/registers.md."""
        step_log2 = self._registers[STEP_LOG2]
        self._registers[:] = astuple(registers)
        if registers.step_log2 != step_log2:
            restep(self._registers, self._globals)

    @property
    def time(self) -> int:
        """See `GoldenModel`."""
        return int(self._globals[NOW])

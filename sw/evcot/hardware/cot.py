# SPDX-License-Identifier: Apache-2.0
"""The golden model of `cot`, `cot_chain` and `cot_array`: bit-exact, event-level, without clock cycles.

It computes with integers of the widths that the RTL has by `contract.Shape`, and returns the same raw records, owners and
recentred addresses. docs/algorithm.md specifies the rules; the arithmetic is equation (6) of the paper with
alpha = 2^-hist_avg.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..ticks import TickedEvents
from ._cot_kernel import FIELD_COUNT, GLOBAL_COUNT, LIMIT_COUNT, Global, Limit, feed, initialise, rewrite
from .config import CotConfig, SlotConfig
from .contract import RECORD, REGISTERS
from .model import GoldenModel

__all__ = ["CotModel"]

_ALL = np.empty(0, np.bool_)


class CotModel(GoldenModel):
    """See `GoldenModel`. About 30 to 60 ns per event with 8 slots.

    In an array every slot sees every event, and active windows never overlap. In a chain each tracker sees the events that the
    one before it passed on; a single tracker is a chain of one.
    """

    def __init__(self, config: CotConfig) -> None:
        super().__init__(config)
        shape = config.shape
        self.config = config
        self._regs = np.array([[getattr(slot, name) for slot in config.slots] for name in REGISTERS], np.int64)
        self._limits = np.zeros(LIMIT_COUNT, np.int64)
        self._limits[Limit.FRAC] = shape.frac
        self._limits[Limit.X_MAX] = (1 << shape.x_w) - 1
        self._limits[Limit.Y_MAX] = (1 << shape.y_w) - 1
        self._limits[Limit.TC_MAX] = (1 << shape.tc_w) - 1
        self._limits[Limit.SUPPORT_MAX] = (1 << shape.sup_w) - 1
        self._limits[Limit.ID_MASK] = (1 << shape.id_w) - 1
        self._limits[Limit.IS_CHAIN] = config.module != "cot_array"
        self._limits[Limit.REL_MASK] = (1 << shape.rel_w) - 1
        self._state = np.zeros((FIELD_COUNT, shape.n_slots), np.int64)
        self._globals = np.zeros(GLOBAL_COUNT, np.int64)
        initialise(self._state, self._regs, self._limits, self._globals)

    def _decide(
        self,
        events: TickedEvents,
        keep: NDArray[np.bool_] | None,
        owner: NDArray[np.int16],
        rel_x: NDArray[np.uint16],
        rel_y: NDArray[np.uint16],
        visible: NDArray[np.bool_],
    ) -> NDArray[np.void]:
        n, keep = len(events), _ALL if keep is None else keep
        per_event_max = 3 * self.config.shape.n_slots
        parts: list[NDArray[np.void]] = []
        done = 0
        while done < n:
            buffer = np.zeros(max(2 * per_event_max, (n - done) // 4), RECORD)
            done, count = feed(
                self._state, self._regs, self._limits, self._globals,
                events.ticks, events.x, events.y, keep, done, per_event_max, owner, rel_x, rel_y, buffer,
            )  # fmt: skip
            parts.append(buffer[:count])
        return parts[0] if len(parts) == 1 else np.concatenate(parts) if parts else np.zeros(0, RECORD)

    def write_registers(self, slot: int, registers: SlotConfig, *, restart: bool) -> NDArray[np.void]:
        """Change a slot's registers before the next event, as a commit does: docs/registers.md.

        Args:
            restart: `mode` is written, too, which ends the slot's current life; returns its record, (m,) RECORD.

        Raises:
            ConfigError: a register outside its limits.
        """
        registers.check(self.config.shape, f"slot[{slot}]")
        values = np.array([getattr(registers, name) for name in REGISTERS], np.int64)
        room = np.zeros(1, RECORD)
        return room[: rewrite(self._state, self._regs, self._limits, self._globals, slot, values, restart, room)]

    @property
    def time(self) -> int:
        """See `GoldenModel`."""
        return int(self._globals[Global.NOW])

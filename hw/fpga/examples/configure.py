# SPDX-License-Identifier: Apache-2.0
"""The settings of configure.c from Python, over any transport: mapped memory, a serial line, a simulation."""

from __future__ import annotations

import mmap
from pathlib import Path

import numpy as np

from evcot import Mode, Registers, Transport, register_map


class Uio:
    """The registers behind a UIO device of Linux, such as /dev/uio0."""

    def __init__(self, device: Path, size: int = 1 << register_map().address_w) -> None:
        with device.open("r+b", buffering=0) as file:
            self._words = np.frombuffer(mmap.mmap(file.fileno(), size), np.uint32)

    def read(self, address: int) -> int:
        return int(self._words[address // 4])

    def write(self, address: int, value: int) -> None:
        self._words[address // 4] = value


def configure(transport: Transport) -> Registers:
    """One seeded tracker in each slot; cot_motion has no other registers in a slot, and with it the default filters begin.

    Raises:
        ConfigError: no evcot_top answers. BusError, a subclass: the hardware clamped or refused a value.
    """
    regs = Registers(transport)
    motion = register_map().trackers[regs.build.tracker] == "motion"
    for slot in regs.slot:
        slot.mode = Mode.SEEDED
        if not motion:
            slot.init_radix, slot.radix_th, slot.radix_step, slot.radix_min, slot.radix_max = 12, 4, 1, 6, 40
            slot.hist_avg, slot.max_ticks, slot.clust_nev, slot.nev_min, slot.nev_max = 3, 50_000, 32, 8, 64
            slot.nev_th, slot.detect_ticks = 2000, 5000
        slot.commit()
    if motion and regs.build.filters:
        regs.filters.commit()  # the values after reset are those of the default configuration
    while regs.status.pending:
        pass
    regs.control.enable = 1
    return regs

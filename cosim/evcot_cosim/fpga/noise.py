# SPDX-License-Identifier: Apache-2.0
"""Common parts of the hardware self-tests: a noise source that keeps trackers busy, the register writes, the signature."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from evcot.hardware.config import SlotConfig
from evcot.hardware.contract import REGISTERS, Mode
from evcot.hardware.lfsr_event_source import LfsrEventSource
from evcot.templating import templates

__all__ = ["SIZE", "SLOT", "rendered", "signature", "source", "writes"]

SIZE = 128  # pixels of the noise, across and down

# With an event per tick, tracks start, move, merge and end all the time.
SLOT = SlotConfig(
    mode=Mode.SEEDED, init_cm_x=0, init_cm_y=0, init_radix=8, radix_th=4, radix_step=1, radix_min=4, radix_max=20, hist_avg=1,
    max_ticks=60, clust_nev=3, nev_min=2, nev_max=16, nev_th=20, detect_ticks=100,
)  # fmt: skip


def source(first: int, address_w: int) -> LfsrEventSource:
    """Noise source over `SIZE` x `SIZE` pixels from (first, first) on, with addresses of `address_w` bits."""
    last = SIZE - 1
    return LfsrEventSource(
        x_min=first, x_span=last, y_min=first, y_span=last, gap=24, seed=2026, x_w=address_w, y_w=address_w, gap_w=6
    )  # fmt: skip


def writes(slot: SlotConfig) -> list[tuple[str, int, int]]:
    """A slot's register writes in order, the mode last: name, number, value."""
    return [(name, REGISTERS[name].address, int(getattr(slot, name))) for name in sorted(REGISTERS, key="mode".__eq__)]


def signature(words: NDArray[np.uint64]) -> int:
    """Signature of words in 32 bits: rotate by one bit and exclusive-or, word by word."""
    return int(_fold(words))


@njit(cache=True, nogil=True)
def _fold(words):  # type: ignore[no-untyped-def]
    signature = np.uint64(0)
    for word in words:
        signature = ((signature << np.uint64(1) | signature >> np.uint64(31)) & np.uint64(0xFFFFFFFF)) ^ word
    return signature


def rendered(template: str, **values: Any) -> str:
    """The text of a header."""
    return templates("evcot_cosim.fpga").get_template(template).render(**values)

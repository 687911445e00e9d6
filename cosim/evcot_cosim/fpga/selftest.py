# SPDX-License-Identifier: Apache-2.0
"""Bit-exact model of hw/fpga/evcot_selftest.v: the expected signatures of its streams."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from evcot._numba_private import njit
from evcot.hardware.config import CotConfig, SlotConfig
from evcot.hardware.contract import REGISTERS, Mode, Shape
from evcot.hardware.cot import CotModel
from evcot.hardware.lfsr_event_source import LfsrEventSource
from evcot.hardware.registers import register_map
from evcot.templating import templates
from evcot.ticks import TickedEvents

__all__ = ["EVENTS", "SIZE", "SLOT", "SLOTS", "expected", "header", "rendered", "signature", "source", "writes"]


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


SLOTS = 8
EVENTS = 2_000

_SOURCE = source(first=64, address_w=9)


def expected() -> tuple[int, int, int, int]:
    """Signatures of records, owned and passed events, 32 bits each, and the number of records."""
    events = _SOURCE.events(EVENTS)
    config = CotConfig(Shape(n_slots=SLOTS, tick_w=1), (SLOT,) * SLOTS)
    decisions = CotModel(config).feed(TickedEvents(np.arange(1, EVENTS + 1), events.x, events.y, events.p))
    records = decisions.records
    cm = (
        records["kind"].astype(np.uint64)
        ^ _at(records["slot"], 8)
        ^ _at(records["track_id"])
        ^ _turned(_at(records["other_id"]))
        ^ _at(records["cm_x"], 16)
        ^ _at(records["cm_y"])
        ^ _at(records["radius"], 23)
        ^ _at(records["n_ev"], 13)
        ^ _at(records["support"], 16)
        ^ _at(records["seq"])
        ^ _turned(_at(records["time"]))
    )
    seq = np.arange(EVENTS, dtype=np.uint64)
    p = _at(events.p, 31)
    own = _at(decisions.owner.astype(np.uint16)) ^ _at(decisions.rel_x, 8) ^ _at(decisions.rel_y, 18) ^ p ^ seq
    passed = _at(events.x) ^ _at(events.y, 11) ^ p ^ seq
    taken = decisions.owner >= 0
    return signature(cm), signature(own[taken]), signature(passed[~taken]), len(records)


def header() -> str:
    """The text of evcot_selftest.vh."""
    return rendered(
        "evcot_selftest.vh.j2", slots=SLOTS, events=EVENTS, source=_SOURCE, signatures=expected(), writes=writes(SLOT),
        reg_w=register_map().banks["slot"].word_w,
    )  # fmt: skip


def _at(values: NDArray[np.generic], bit: int = 0) -> NDArray[np.uint64]:
    """Values as 32-bit words with their lowest bit at `bit`, which suffices for all of these words."""
    return values.astype(np.uint64) << np.uint64(bit) & np.uint64(0xFFFFFFFF)


def _turned(words: NDArray[np.uint64]) -> NDArray[np.uint64]:
    return (words << np.uint64(1) | words >> np.uint64(31)) & np.uint64(0xFFFFFFFF)

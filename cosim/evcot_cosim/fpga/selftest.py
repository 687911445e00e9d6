# SPDX-License-Identifier: Apache-2.0
"""Bit-exact model of hw/fpga/evcot_selftest.v: the expected signatures of its streams."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from evcot.hardware.config import CotConfig
from evcot.hardware.contract import Shape
from evcot.hardware.cot import CotModel
from evcot.hardware.registers import register_map
from evcot.ticks import TickedEvents

from .noise import SLOT, rendered, signature, source, writes

__all__ = ["EVENTS", "SLOTS", "expected", "header"]

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

# SPDX-License-Identifier: Apache-2.0
"""The exact twin of hw/fpga/evcot_selftest.v: which signatures its streams must give. As a program it writes its header."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined
from numba import njit
from numpy.typing import NDArray

from evcot.config import CotConfig, SlotConfig
from evcot.contract import REGISTERS, Mode, Shape
from evcot.cot import CotModel
from evcot.lfsr_event_source import LfsrEventSource
from evcot.outputs import written_aside

from ..build import verilog_dir

__all__ = ["EVENTS", "SLOTS", "expected", "header", "signature"]

SLOTS = 8
EVENTS = 2_000

_SOURCE = LfsrEventSource(x_min=64, x_span=127, y_min=64, y_span=127, gap=24, seed=2026)
# Noise all over 128 x 128 pixels: windows are born, move, meet and die all the time.
_SLOT = SlotConfig(
    mode=Mode.SEEDED, init_cm_x=0, init_cm_y=0, init_radix=8, radix_th=4, radix_step=1, radix_min=4, radix_max=20, hist_avg=1,
    max_ticks=60, clust_nev=3, nev_min=2, nev_max=16, nev_th=20, detect_ticks=100,
)  # fmt: skip


def expected() -> tuple[int, int, int, int]:
    """Signatures of records, owned and passed events, 32 bits each, and the number of records."""
    events = _SOURCE.events(EVENTS)
    config = CotConfig(Shape(n_slots=SLOTS, tick_w=1), (_SLOT,) * SLOTS)
    decisions = CotModel(config).feed(np.arange(1, EVENTS + 1), events.x, events.y)
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
    writes = [(name, REGISTERS[name].address, int(getattr(_SLOT, name))) for name in sorted(REGISTERS, key="mode".__eq__)]
    environment = Environment(loader=PackageLoader("evcot_cosim"), undefined=StrictUndefined, keep_trailing_newline=True)
    return environment.get_template("evcot_selftest.vh.j2").render(
        slots=SLOTS, events=EVENTS, source=_SOURCE, signatures=expected(), writes=writes
    )


def _at(values: NDArray[np.generic], bit: int = 0) -> NDArray[np.uint64]:
    """Values as 32-bit words with their lowest bit at `bit`; none of these words needs more."""
    return values.astype(np.uint64) << np.uint64(bit) & np.uint64(0xFFFFFFFF)


def _turned(words: NDArray[np.uint64]) -> NDArray[np.uint64]:
    return (words << np.uint64(1) | words >> np.uint64(31)) & np.uint64(0xFFFFFFFF)


@njit(cache=True, nogil=True)
def _fold(words):  # type: ignore[no-untyped-def]
    signature = np.uint64(0)
    for word in words:
        signature = ((signature << np.uint64(1) | signature >> np.uint64(31)) & np.uint64(0xFFFFFFFF)) ^ word
    return signature


def signature(words: NDArray[np.uint64]) -> int:
    """Words folded into 32 bits: rotated by one bit and exclusive-ored, word after word."""
    return int(_fold(words))


def _main() -> int:
    path: Path = verilog_dir().parent / "fpga" / "evcot_selftest.vh"
    with written_aside(path) as file:
        file.write(header().encode())
    print(f"{path}: written")
    return 0


if __name__ == "__main__":
    sys.exit(_main())

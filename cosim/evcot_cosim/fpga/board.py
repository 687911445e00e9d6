# SPDX-License-Identifier: Apache-2.0
"""Bit-exact model of hw/fpga/board_core.v: the settings of a board's self-test, and the expected signature of its records."""

from __future__ import annotations

from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from evcot.filters.contract import FILTER_SHAPE_RANGES
from evcot.hardware.config import CotConfig
from evcot.hardware.contract import RECORD, Shape
from evcot.hardware.cot import CotModel
from evcot.hardware.registers import register_map
from evcot.ticks import TickedEvents

from ..rtl.files import verilog_dir
from . import RECORDS
from .selftest import SIZE, SLOT, rendered, signature, source, writes

__all__ = ["SIZES", "board_dir", "expected_records", "header", "shape"]

SIZES = (1, 2, 4, 8)  # numbers of slots that a board may have
_EVENTS = 40_000  # more than make so many records

# Words that board_small.v has.
_SMALL = (
    "id", "version", "shape0", "shape1", "shape2", "build", "sensor", "memory", "control",
    "events", "owned", "passed", "records",
)  # fmt: skip
_SOURCE = source(first=0, address_w=7)
# An event comes every 25 us, and a tick is one of them.
_SLOT = replace(SLOT, init_radix=12, radix_min=6, max_ticks=1200, nev_th=500, detect_ticks=4000)


def board_dir() -> Path:
    """The folder of the board files: hw/fpga of a checkout."""
    return verilog_dir().parent / "fpga"


def shape(n: int) -> Shape:
    """The shape of a board's trackers: small enough for the smallest board."""
    return Shape(n_slots=n, x_w=7, y_w=7, frac=4, tick_w=8, radix_w=6, nev_w=5, tc_w=13, sup_w=8, id_w=8, seq_w=16, time_w=20)


def expected_records(n: int, count: int | None = None, events: int = _EVENTS) -> NDArray[np.void]:
    """The first records of a board with `n` slots after reset, (count,) of dtype `contract.RECORD`; None: all records of
    `events` events. Numbers wrap at the board's bit widths."""
    noise, small = _SOURCE.events(events), shape(n)
    model = CotModel(CotConfig(small, (_SLOT,) * n))
    records = model.feed(TickedEvents.of(noise)).records[:count]
    records["seq"] %= 1 << small.seq_w
    records["time"] %= 1 << small.time_w
    return records


def _expected(n: int) -> int:
    words = np.frombuffer(expected_records(n, RECORDS).tobytes(), "<u4")
    assert len(words) == RECORDS * RECORD.itemsize // 4
    return signature(words.astype(np.uint64))


def _address(name: str) -> int:
    return register_map().word(name).address


def _packed(name: str, **values: int) -> int:
    """The value of a register-map word with these values of its fields, 0 in the others."""
    lsb = {field.name: field.lsb for field in register_map().word(name).fields}
    return sum(value << lsb[field] for field, value in values.items())


def _constants() -> dict[str, int]:
    """The constant information words of board_small.v, without the number of slots."""
    sizes = asdict(shape(1)) | {"n_slots": 0}
    shapes = (register_map().word(f"shape{i}") for i in range(3))
    words = {word.name: {field.name: sizes[field.name] for field in word.fields} for word in shapes}
    words["build"] = {"sources": 1 << register_map().sources.index("lfsr")}
    words["sensor"] = {"last_x": SIZE - 1, "last_y": SIZE - 1}
    words["memory"] = {"stamp_w": FILTER_SHAPE_RANGES["stamp_w"][0]}  # there is none: the smallest legal value
    return {name: _packed(name, **values) for name, values in words.items()}


def _before() -> list[tuple[str, int, int]]:
    """The writes before those of the slots: the LFSR's settings, which take effect with a soft reset."""
    return [
        ("lfsr_seed", _address("lfsr_seed"), _SOURCE.seed),
        ("lfsr_gap", _address("lfsr_gap"), _SOURCE.gap),
        ("lfsr_x", _address("lfsr_x"), _packed("lfsr_x", min=_SOURCE.x_min, span=_SOURCE.x_span)),
        ("lfsr_y", _address("lfsr_y"), _packed("lfsr_y", min=_SOURCE.y_min, span=_SOURCE.y_span)),
        ("control: soft_reset", _address("control"), _packed("control", soft_reset=1)),
    ]


def _of_slot() -> list[tuple[str, int, int]]:
    bank = register_map().banks["slot"]
    return [(name, bank.base + 4 * number, value) for name, number, value in [*writes(_SLOT), ("commit", bank.commit, 1)]]


def header() -> str:
    """The text of board_selftest.vh."""
    shared = {name: value for name, value in asdict(shape(1)).items() if name != "n_slots"}
    return rendered(
        "board_selftest.vh.j2",
        shape=shared, size=SIZE, records=RECORDS, signatures={n: _expected(n) for n in SIZES},
        source=_SOURCE, constants=_constants(), addresses={name: _address(name) for name in _SMALL},
        before=_before(), of_slot=_of_slot(), after=[("control: enable", _address("control"), _packed("control", enable=1))],
        slot_step=4 * register_map().banks["slot"].words, address_w=register_map().address_w,
    )  # fmt: skip

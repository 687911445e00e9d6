# SPDX-License-Identifier: Apache-2.0
"""The C++ side of a simulation: generated from the contract, compiled into the shared object that pyverilator builds."""

from __future__ import annotations

import ctypes
from enum import IntEnum
from functools import cache
from typing import Any

from numpy.typing import NDArray

from evcot.hardware.contract import RECORD, SLOTS_MAX, Shape
from evcot.templating import templates
from evcot.tracks.log import DROPPED, Kind

__all__ = ["PARAMETERS", "UNDECIDED", "Job", "Status", "pointer", "source"]

UNDECIDED = DROPPED  # owner of an event that the hardware has not reported: behind filters, one that was taken out

# Shape field -> Verilog parameter.
PARAMETERS = {
    "n_slots": "N",
    "x_w": "X_W",
    "y_w": "Y_W",
    "frac": "FRAC",
    "tick_w": "TICK_W",
    "radix_w": "RADIX_W",
    "nev_w": "NEV_W",
    "tc_w": "TC_W",
    "sup_w": "SUP_W",
    "id_w": "ID_W",
    "seq_w": "SEQ_W",
    "time_w": "TIME_W",
}


class Status(IntEnum):
    """How a streaming call ended."""

    DONE = 0
    RECORDS_FULL = 1  # call again with room for more records
    STUCK = 2
    EVENT_LOST = 3
    OWNED_OUT_OF_ORDER = 4
    OWNED_CHANGED = 5
    PASSED_OUT_OF_ORDER = 6
    PASSED_CHANGED = 7


_POINTER = ctypes.c_void_p
_INT = ctypes.c_int64

# (field, ctypes type, C type)
_JOB: list[tuple[str, type, str]] = [
    # events in
    ("n", _INT, "int64_t"),
    ("ticks", _POINTER, "const int64_t*"),
    ("x", _POINTER, "const uint16_t*"),
    ("y", _POINTER, "const uint16_t*"),
    ("p", _POINTER, "const uint8_t*"),
    ("keep", _POINTER, "const uint8_t*"),  # 0: the event was taken out before and only counts; null: none was
    ("first_seq", ctypes.c_uint64, "uint64_t"),
    # stall patterns: one byte per clock, repeated; length 0 never stalls
    *(
        entry
        for stream in ("in", "cm", "own", "pass")
        for entry in ((f"{stream}_pattern", _POINTER, "const uint8_t*"), (f"{stream}_length", _INT, "int64_t"))
    ),
    # decisions out
    ("owner", _POINTER, "int16_t*"),
    ("rel_x", _POINTER, "uint16_t*"),
    ("rel_y", _POINTER, "uint16_t*"),
    ("records", _POINTER, "Record*"),
    ("record_capacity", _INT, "int64_t"),
    ("n_records", _INT, "int64_t"),
    # when things happened, or null
    ("accept_cycle", _POINTER, "int64_t*"),
    ("record_cycle", _POINTER, "int64_t*"),
    # where the drive stands
    ("now", _INT, "int64_t"),
    ("cycle", _INT, "int64_t"),
    ("next", _INT, "int64_t"),
    ("holding", _INT, "int64_t"),
    ("holds_event", _INT, "int64_t"),
    ("held_tick", _INT, "int64_t"),
    ("fault_seq", _INT, "int64_t"),
    ("began", _INT, "int64_t"),  # tick of the last event before this call
    # waveform: clocks from the one after event vcd_from - 1 was taken to the one that takes event vcd_to
    ("vcd", _POINTER, "void*"),
    ("vcd_from", _INT, "int64_t"),
    ("vcd_to", _INT, "int64_t"),
]


class Job(ctypes.Structure):
    """One streaming call: pointers into NumPy arrays, and where the drive stands."""

    _fields_ = [(name, ctype) for name, ctype, _ in _JOB]


_C_TYPES = {"u1": "uint8_t", "u2": "uint16_t", "u4": "uint32_t", "u8": "uint64_t"}


def _record_fields() -> list[tuple[str, str]]:
    assert RECORD.names is not None
    return [(_C_TYPES[RECORD[name].str[1:]], name) for name in RECORD.names]


@cache
def source(top: str, shape: Shape) -> str:
    """C++ text of the streaming drive for one top module: `cot`, `cot_chain`, `cot_array`, `cot_engine` or `cot_filtered`."""
    return (
        templates("evcot_cosim.devices")
        .get_template("stream.cpp.j2")
        .render(
            top=top,
            single=top == "cot",
            takes_seq=top == "cot",
            in_order=top in ("cot", "cot_array", "cot_engine"),
            filtered=top == "cot_filtered",
            registered=top == "cot_engine",
            tick_max=(1 << shape.tick_w) - 1,
            seq_mask=(1 << shape.seq_w) - 1,
            time_mask=(1 << shape.time_w) - 1,
            lost=int(Kind.LOST),
            slots_max=SLOTS_MAX,
            undecided=UNDECIDED,
            record_fields=_record_fields(),
            record_size=RECORD.itemsize,
            job_fields=[(ctype, name) for name, _, ctype in _JOB],
            statuses=[status.name for status in Status],
        )
    )


def pointer(array: NDArray[Any] | None) -> int | None:
    """Address of an array's data, for a `Job` field."""
    return None if array is None else array.ctypes.data

# SPDX-License-Identifier: Apache-2.0
"""The streaming drive of a tracker: C++ generated from the contract and compiled into the model's shared object."""

from __future__ import annotations

from functools import cache

import numpy as np

from evcot.hardware.contract import RECORD, SLOTS_MAX, Shape
from evcot.hardware.motion.contract import MOTION_RECORD
from evcot.templating import templates
from evcot.tracks.log import DROPPED, Kind

from .base import Drive, Ending, pattern_fields

__all__ = ["DRIVE", "MOTION_DRIVE", "PARAMETERS", "UNDECIDED", "Status", "saving_source", "source"]

UNDECIDED = DROPPED  # owner of an event that the hardware has not reported: behind filters, a dropped one

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


class Status(Ending):
    """Return codes of a streaming call."""

    DONE = ""
    RECORDS_FULL = ""  # call again with room for more records
    STUCK = "stands still: no handshake for a million clocks and what motion steps may take, waiting at event"
    EVENT_LOST = "lost event"
    OWNED_OUT_OF_ORDER = "gave twice, or out of order, owned event"
    OWNED_CHANGED = "changed the polarity of owned event"
    PASSED_OUT_OF_ORDER = "gave twice, or out of order, passed event"
    PASSED_CHANGED = "changed the address or polarity of passed event"


_C_TYPES = {f"{sign}{size}": f"{prefix}int{8 * size}_t" for sign, prefix in (("u", "u"), ("i", "")) for size in (1, 2, 4, 8)}


def _drive(record: np.dtype[np.void]) -> Drive[Status]:
    assert record.names is not None
    fields = {name: _C_TYPES[record[name].str[1:]] for name in record.names}
    return Drive("evcot_stream", "stream.cpp.j2", _JOB, Status, structures={"Record": fields})


_JOB = {
    # events in
    "n": "int64_t",
    "ticks": "const int64_t*",
    "x": "const uint16_t*",
    "y": "const uint16_t*",
    "p": "const uint8_t*",
    "keep": "const uint8_t*",  # 0: a filter dropped the event, which is only counted; null: none was dropped
    "first_seq": "uint64_t",
    **pattern_fields("in", "cm", "own", "pass"),
    # decisions out
    "owner": "int16_t*",
    "rel_x": "uint16_t*",
    "rel_y": "uint16_t*",
    "visible": "uint8_t*",  # of cot_motion: the owner is visible
    "records": "Record*",
    "record_capacity": "int64_t",
    "n_records": "int64_t",
    # clocks of handshakes, or null
    "accept_cycle": "int64_t*",
    "record_cycle": "int64_t*",
    # state of the drive
    "now": "int64_t",
    "cycle": "int64_t",
    "next": "int64_t",
    "holding": "int64_t",
    "holds_event": "int64_t",
    "held_tick": "int64_t",
    "fault_seq": "int64_t",
    "began": "int64_t",  # tick of the last event before this call
    "step_clocks": "int64_t",  # that motion steps may take between two handshakes, besides what anything else takes
    # waveform: clocks from the one after event vcd_from - 1 was accepted to the one that accepts event vcd_to
    "vcd": "void*",
    "vcd_from": "int64_t",
    "vcd_to": "int64_t",
}

DRIVE = _drive(RECORD)
MOTION_DRIVE = _drive(MOTION_RECORD)
"""That of cot_motion, whose records have a box and a velocity."""


@cache
def source(top: str, shape: Shape, motion: bool = False, gates: bool = False) -> str:
    """C++ text of the streaming drive for one top module: `cot`, `cot_chain`, `cot_array`, `cot_motion` or `cot_filtered`.

    Args:
        motion: its records are those of cot_motion.
        gates: it holds a netlist, so that not the clock alone changes something.
    """
    return (MOTION_DRIVE if motion else DRIVE).source(
        top,
        motion=motion,
        side_w=shape.reach_log2 + 16,
        single=top == "cot",
        takes_seq=top == "cot",
        in_order=top in ("cot", "cot_array", "cot_motion"),
        filtered=top == "cot_filtered",
        registered=top in ("cot_array", "cot_filtered", "cot_motion") and not gates,
        tick_max=(1 << shape.tick_w) - 1,
        seq_mask=(1 << shape.seq_w) - 1,
        time_mask=(1 << shape.time_w) - 1,
        lost=int(Kind.LOST),
        slots_max=SLOTS_MAX,
        undecided=UNDECIDED,
        record_size=(MOTION_RECORD if motion else RECORD).itemsize,
    )


@cache
def saving_source(top: str) -> str:
    """C++ text that saves and restores the state of a simulation of one top module."""
    return templates("evcot_cosim.devices").get_template("save.cpp.j2").render(top=top)

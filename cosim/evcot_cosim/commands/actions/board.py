# SPDX-License-Identifier: Apache-2.0
"""`evcot board`: compare the records of a board with the golden model."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evcot.errors import ConfigError
from evcot.hardware.contract import RECORD
from evcot.hardware.register_access import Registers
from evcot.hardware.registers import register_map

from ...fpga.board import SIZES, expected_records, shape
from ...fpga.serial_host import SerialHost
from ...tables import counted, print_table
from ..parsing import MISMATCH

__all__ = ["run"]

_MOST = 10_000  # records: five seconds of the line
_EVENTS = 8_000_000  # of the golden model, from a board's reset on: the records of a ULX3S in 19 minutes, of an iCEBreaker in 2


def run(options: argparse.Namespace, _arguments: Sequence[str]) -> int:
    """Hold a board against the golden model; `MISMATCH` where they differ, else 0."""
    if not 1 <= options.records <= _MOST:
        raise ConfigError(f"--records {options.records}: must be from 1 to {_MOST:,}")
    with SerialHost(options.port) as host:
        registers = Registers(host)
        told = _told(registers)
        slots = registers.shape.n_slots
        if slots not in SIZES or registers.shape != shape(slots):
            raise ConfigError(f"{options.port}: an evcot_top, but none of the boards': nothing to hold it against")
        counters = {name: value for name, value in registers.counters().items() if value}
        records = host.records(options.records)
    expected = expected_records(slots, events=_EVENTS)
    if counters.get("records", 0) + len(records) > len(expected):
        raise ConfigError(
            f"{options.port}: has given {counters['records']:,} records since its reset: must be fewer than {len(expected):,}, "
            "as many as the golden model makes here; reset the board"
        )
    first, difference = _compared(records, expected)
    if options.json:
        verdict = {"records": len(records), "first_record": first, "difference": difference or None}
        print(json.dumps({**told, "counters": counters, **verdict}, indent=2))
    else:
        print_table([(f"{name}:", value) for name, value in told.items()])
        print_table([("counter", "since reset"), *((name, f"{value:,}") for name, value in counters.items())])
    if difference:
        print(f"evcot: MISMATCH: {options.port}: {difference}", file=sys.stderr)
        return MISMATCH
    if not options.json:
        print(f"{counted(len(records), 'record')} from number {first:,} on: all as the golden model's")
    return 0


def _told(registers: Registers) -> dict[str, Any]:
    """What the hardware says of itself."""
    names, build = register_map(), registers.build
    return {
        "version": f"{registers.version.major}.{registers.version.minor}",
        "tracker": f"cot_{names.trackers[build.tracker]}",
        "slots": registers.shape.n_slots,
        "sources": ", ".join(name for i, name in enumerate(names.sources) if build.sources >> i & 1),
        "sensor": f"{registers.filter_shape.width} x {registers.filter_shape.height}",
    }


def _compared(records: NDArray[np.void], expected: NDArray[np.void]) -> tuple[int | None, str]:
    """Which of the expected records the first one is, and the first difference from there on; empty where there is none."""
    places = np.flatnonzero(expected == records[0])
    if not len(places):
        return None, "the board's first record is none of the golden model's; was a register written since reset?"
    first = int(places[0])
    for number, (found, wanted) in enumerate(zip(records, expected[first:], strict=False), first):
        for name in RECORD.names or ():
            if found[name] != wanted[name]:
                return first, f"record {number:,}, {name}: the board has {found[name]}, the golden model {wanted[name]}"
    return first, ""

# SPDX-License-Identifier: Apache-2.0
"""Generate headers, code and documentation from their single definitions: contract.py, lfsr.py, the register maps.

`python -m evcot.hardware.generate` writes the files into a source tree; `--check` writes nothing and fails when one is stale.
"""

from __future__ import annotations

import argparse
import html
import re
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from itertools import accumulate
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import ConfigError, EvcotError
from ..filters.config import DEFAULT_FILTERS
from ..filters.contract import (
    CLOCK_FRAC,
    FILTER_REGISTERS,
    FILTER_SHAPE_RANGES,
    UNITS_PER_HALF_LIFE,
    Filter,
    FilterRegister,
)
from ..filters.decay import weights
from ..hough.contract import COSINES, STAMP_W
from ..outputs import written_aside
from ..templating import templates
from ..tracks.log import Kind
from .classifier import (
    CLASSIFIER_REGISTERS,
    VERDICT_KIND,
    VERDICT_RECORD,
    VERDICT_RECORD_MEANINGS,
    VERSION,
    WEIGHT_BANKS,
    WEIGHT_ROWS,
)
from .contract import HIST_AVG_STILL, ORDERED, RECORD, RECORD_MEANINGS, REGISTERS, SHAPE_RANGES, Mode, Register, State
from .lfsr import TAPS, tap_mask
from .motion.contract import MOTION_BANKS, MOTION_RECORD, MOTION_RECORD_MEANINGS, MOTION_RULES, MotionRegister, Rule
from .published.registers import REGISTERS as PUBLISHED_REGISTERS
from .published.registers import SELECT, SELECT_FIRST, SELECT_NONE
from .registers import Access, Bank, Field, Listed, Word, motion_addresses, register_map

__all__ = ["render", "stale", "write"]

_ROOT = Path(__file__).resolve().parents[3]


_KINDS = {
    Kind.BORN: "the first centre of a track",
    Kind.MOVED: "a further centre; also of the survivor, after the MERGED of the other",
    Kind.MERGED: "a track that has ended in another one, `other_id`, with its own last centre",
    Kind.LOST: "a track that has ended, by its timer or by a write of `mode`; `seq` is the number of the next event",
}
"""What a record of each kind is."""


_WHAT_OF = {
    "motion": "boxes and velocities, of cot_motion", "tracks": "lives, of cot_motion", "classifier": "the classifier",
}  # fmt: skip
"""What the registers of each bank are of that not all hardware has."""


@dataclass(frozen=True)
class _Codes:
    """One group of sized constants: `EVCOT_<prefix>_<name>`, all of one width."""

    prefix: str
    comment: str
    members: list[tuple[str, int]]
    width: int


def _codes(prefix: str, comment: str, enum: type[IntEnum]) -> _Codes:
    members = [(member.name, int(member)) for member in enum]
    return _Codes(prefix, comment, members, max(1, max(enum).bit_length()))


def _bank_codes(prefix: str, comment: str, bank: Bank) -> _Codes:
    return _Codes(prefix, comment, [(name, register.address) for name, register in bank.registers.items()], bank.word_w)


def _motion_codes() -> _Codes:
    comment = "Addresses on the port of cot_motion: the mode of a slot, then the words of both banks."
    return _Codes("MREG", comment, list(motion_addresses().items()), register_map().banks["motion"].word_w + 1)


def _motion_registers() -> dict[str, Any]:
    """Variables of motion_regs.v: name, bits, reset value, range, meaning and lowest bit of each register."""
    registers = [entry for bank in MOTION_BANKS.values() for entry in bank.items()]
    places = accumulate((r.high.bit_length() for _, r in registers), initial=0)
    return {
        "rows": [
            (name, r.high.bit_length(), r.start, r.low, r.high, r.meaning, at)
            for (name, r), at in zip(registers, places, strict=False)
        ]
    }


def _rules() -> dict[str, list[Rule]]:
    """The rules of each bank of motion."""
    found = {name: [rule for rule in MOTION_RULES if rule.less in bank] for name, bank in MOTION_BANKS.items()}
    apart = [rule.less for name, rules in found.items() for rule in rules if rule.more not in MOTION_BANKS[name]]
    if apart:
        raise ConfigError(f"motion.{apart[0]}: its rule is about two banks, and a commit compares registers of one")
    return found


def _record(record: np.dtype[np.void]) -> list[tuple[str, int, int]]:
    """The fields of a record: name, lowest bit, bits."""
    assert record.fields is not None
    return [(name, 8 * int(record.fields[name][1]), 8 * record[name].itemsize) for name in record.names or () if name[0] != "_"]


def _record_in_c(record: np.dtype[np.void]) -> list[tuple[str, str]]:
    """The fields of a record: type in C, name."""
    return [
        (f"{'u' * (record[name].kind == 'u')}int{8 * record[name].itemsize}_t", name.strip("_")) for name in record.names or ()
    ]


def _verilog_high(register: Listed) -> str:
    """The largest legal value as a Verilog expression of the width parameters."""
    if register.high is not None:
        return f"32'd{register.high}"
    if isinstance(register, FilterRegister):
        return "32'hffffffff >> (33 - STAMP_W)"
    return f"32'hffffffff >> (32 - {str(register.width).upper()})"


def _checked(word: Word, field: Field) -> bool:
    limited = bool(field.low or field.high is not None or field.allowed)
    return field.access is Access.PORT or (field.access is Access.RW and limited)


def _flaws(field: Field) -> list[str]:
    """The ways in which a value written to a field may be illegal."""
    if field.allowed:
        return ["bad"]
    return ["bad"] * (field.access is Access.PORT) + ["over"] * (field.high is not None) + ["under"] * bool(field.low)


def _low_w(bank: Bank) -> int:
    """Bits of the lowest legal values of a bank."""
    return max(entry.low for entry in bank.registers.values()).bit_length() or 1


def _legal(field: Field) -> str:
    """The legal values of a field, as text."""
    if field.access not in (Access.RW, Access.PORT):
        return ""
    if field.allowed:
        return "what was built, else refused"
    high = (1 << field.bits) - 1 if field.high is None else field.high
    return f"{field.low} to {f'2^{high} - 1' if isinstance(high, str) else high}"


def _bank_legal(bank: str, name: str, register: Listed) -> str:
    """The legal values of a bank's register, as text."""
    width = register.width if isinstance(register, Register) else "STAMP_W - 1"
    high = f"2^{str(width).upper()} - 1" if register.high is None else register.high
    return f"{register.low} to {high}" + (", else refused" if name in register_map().banks[bank].refuse else "")


def _start(name: str, register: Listed) -> int:
    """The value after reset: that of the default configuration; of a slot's register the lowest legal one."""
    if isinstance(register, FilterRegister):
        return 0 if name == "mask" else int(getattr(DEFAULT_FILTERS.registers(1), name))
    return register.start if isinstance(register, MotionRegister) else register.low


def _verilog_start(name: str, register: Listed) -> str:
    """The value after reset as a Verilog expression; the lowest legal value where time stamps are too short for it."""
    start = f"32'd{_start(name, register)}"
    if register.high is None and isinstance(register, FilterRegister):
        return f"({start} > {_verilog_high(register)}) ? 32'd{register.low} : {start}"
    return start


def _limits(code: str, registers: Mapping[str, Listed], refuse: Sequence[str]) -> dict[str, Any]:
    """Limits of one kind of bank in Verilog."""
    rows = [(name, entry.low, _verilog_high(entry), _verilog_start(name, entry)) for name, entry in registers.items()]
    return {"code": code, "rows": rows, "refuse": refuse}


def _vocabulary() -> dict[str, Any]:
    """Variables and functions for the templates of the register map."""
    register_of = register_map()
    checked = [(word, field) for word in register_of.words for field in word.fields if _checked(word, field)]
    motion = {name: entry for bank in MOTION_BANKS.values() for name, entry in bank.items()}
    banks = register_of.banks
    built_banks = {**MOTION_BANKS, "classifier": CLASSIFIER_REGISTERS}
    attributes = ("slot", "filters", *(f"_{bank}" for bank in built_banks))
    return {
        "map": register_of,
        "counters": register_of.counters,
        "attributes": sorted([*attributes, *(word.name for word in register_of.words if word.fields[0].name)]),
        "irqs": next(word for word in register_of.words if word.name == "irq_status").fields,
        "slot_registers": REGISTERS,
        "ordered": ORDERED,
        "kind_meanings": _KINDS,
        "filter_registers": FILTER_REGISTERS,
        "motion_banks": MOTION_BANKS,
        "built_banks": built_banks,
        "what_of": _WHAT_OF,
        "classifier_registers": CLASSIFIER_REGISTERS,
        "classifier_version": VERSION,
        "weight_words": WEIGHT_ROWS * WEIGHT_BANKS,
        "verdict_kind": VERDICT_KIND,
        "motion_rules": _rules(),
        "tracker_motion": register_of.trackers.index("motion"),
        "limits": {
            "slot": _limits("REG", REGISTERS, banks["slot"].refuse),
            "filter": _limits("FREG", FILTER_REGISTERS, banks["filter"].refuse),
            "motion": _limits("MREG", motion, [name for bank in MOTION_BANKS for name in banks[bank].refuse]),
            "classifier": _limits("CREG", CLASSIFIER_REGISTERS, banks["classifier"].refuse),
        },
        "low_w": {
            "classifier": max(map(_low_w, banks.values())),
            "others": max(_low_w(bank) for name, bank in banks.items() if name != "classifier"),
        },
        "start": _start,
        "checked": checked,
        "flaws": _flaws,
        "refusing": [f"bad_{word.port(field)}" for word, field in checked if "bad" in _flaws(field)],
        "clamping": [f"{flaw}_{word.port(field)}" for word, field in checked for flaw in _flaws(field) if flaw != "bad"],
        "wide": lambda field: not field.name and field.bits < 32,
        "compared": lambda field: field.high is not None and field.high != (1 << field.bits) - 1,
        "record_meanings": {
            "record": RECORD_MEANINGS,
            "motion_record": MOTION_RECORD_MEANINGS,
            "verdict_record": VERDICT_RECORD_MEANINGS,
        },
        "records": {
            "record": (_record(RECORD), _record_in_c(RECORD), RECORD.itemsize),
            "motion_record": (_record(MOTION_RECORD), _record_in_c(MOTION_RECORD), MOTION_RECORD.itemsize),
            "verdict_record": (_record(VERDICT_RECORD), _record_in_c(VERDICT_RECORD), VERDICT_RECORD.itemsize),
        },
        "kinds": Kind,
        "code": lambda word: f"{register_of.address_w - 2}'h{word.address // 4:03x}",
        "range": lambda field: f"[{field.bits - 1}:0]".ljust(6) if field.bits > 1 else " " * 6,
        "place": lambda field: f"{field.lsb + field.bits - 1}:{field.lsb}" if field.bits > 1 else f"{field.lsb}",
        "legal": _legal,
        "bank_legal": _bank_legal,
        "html": lambda text: re.sub("`([^`]+)`", r"<code>\1</code>", html.escape(text, quote=False)),
        "camel": lambda name: name.title().replace("_", ""),
        "sentence": lambda text: text[0].upper() + text[1:],
    }


def render() -> dict[str, str]:
    """Returns path in a source tree -> text, of every generated file."""
    banks = register_map().banks
    enums = [
        _codes("ST", "States of the tracker FSM.", State),
        _codes("KIND", "Kinds of a record.", Kind),
        _codes("MODE", "How a slot starts a life: register `mode`.", Mode),
        _bank_codes("REG", "Word addresses of the registers of a slot.", banks["slot"]),
        _codes("FILTER", "The filters of a chain, in their order: bits of `enable`.", Filter),
        _bank_codes("FREG", "Word addresses of the registers of a filter chain.", banks["filter"]),
        _motion_codes(),
        _bank_codes("CREG", "Word addresses of the registers of the classifier in their bank.", banks["classifier"]),
    ]
    rows = [(width, tap_mask(width), taps) for width, taps in TAPS.items()]
    vocabulary = _vocabulary()
    contents: dict[str, dict[str, Any]] = {
        "hw/verilog/common/evcot_defs.vh": {
            "shape_ranges": SHAPE_RANGES, "filter_shape_ranges": FILTER_SHAPE_RANGES, "enums": enums,
            "hist_avg_still": HIST_AVG_STILL,
        },
        "hw/verilog/filter/decay_table.vh": {
            "units": UNITS_PER_HALF_LIFE, "clock_frac": CLOCK_FRAC, "weights": weights(0)[:UNITS_PER_HALF_LIFE],
        },
        "hw/verilog/lines/hough_table.vh": {"stamp_w": STAMP_W, "cosines": COSINES},
        "hw/verilog/math/lfsr_taps.vh": {"rows": rows},
        "hw/verilog/published/published_regs.vh": {
            "select": SELECT, "select_first": SELECT_FIRST, "select_none": SELECT_NONE, "registers": PUBLISHED_REGISTERS,
        },
        "hw/verilog/tracker/motion/motion_fields.vh": _motion_registers(),
        "hw/verilog/tracker/motion/motion_regs.v": _motion_registers(),
        "hw/verilog/bus/evcot_regs.vh": vocabulary,
        "hw/verilog/bus/evcot_limits.vh": vocabulary,
        "hw/verilog/bus/axi_lite_words.v": vocabulary,
        "hw/include/evcot_regs.h": vocabulary,
        "sw/evcot/hardware/register_access.py": vocabulary,
        "docs/registers.md": vocabulary,
    }  # fmt: skip
    environment = templates("evcot.hardware", trim_blocks=True)
    return {path: environment.get_template(f"{Path(path).name}.j2").render(**values) for path, values in contents.items()}


def stale(root: Path = _ROOT) -> list[Path]:
    """Returns the files of a source tree that are missing or differ from what this package generates."""
    paths = [(root / name, text) for name, text in render().items()]
    return [path for path, text in paths if not path.is_file() or path.read_text(encoding="utf-8") != text]


def write(root: Path = _ROOT) -> list[Path]:
    """Writes the stale files of a source tree, each whole or not at all, and returns their paths.

    Raises:
        ConfigError: `root` is not a source tree.
        OutputError: a file cannot be written.
    """
    if not (root / "hw" / "verilog").is_dir():
        raise ConfigError(f"{root / 'hw' / 'verilog'}: no such directory; files are generated into a source tree")
    texts = render()
    found = stale(root)
    for path in found:
        path.parent.mkdir(parents=True, exist_ok=True)
        with written_aside(path, force=True) as file:
            file.write(texts[path.relative_to(root).as_posix()].encode())
    return found


def _main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m evcot.hardware.generate", description=__doc__)
    parser.add_argument("--check", action="store_true", help="write nothing; exit 1 when a file is stale")
    parser.add_argument("--directory", type=Path, default=_ROOT, help="the source tree (default: that of this package)")
    options = parser.parse_args(arguments)
    try:
        paths = stale(options.directory) if options.check else write(options.directory)
    except EvcotError as error:
        print(f"evcot: {error}", file=sys.stderr)
        return 2
    for path in paths:
        print(f"{path}: {'stale: run python -m evcot.hardware.generate' if options.check else 'written'}")
    return 1 if options.check and paths else 0


if __name__ == "__main__":
    sys.exit(_main())

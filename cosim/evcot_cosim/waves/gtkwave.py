# SPDX-License-Identifier: Apache-2.0
"""GTKWave save files for a VCD: signals grouped, named and coloured, states by name, centres as curves.

A save file names its VCD, and the files that translate values to names, by absolute paths. GTKWave first looks for them where
they lie relative to the save file's own recorded path, so a made-up folder that is the same in all of them means "beside
this file", wherever that has been moved.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from evcot.hardware.motion.contract import SUB
from evcot.hardware.registers import register_map
from evcot.outputs import written_aside

from .vcd import Declared, declared, initial_values
from .views import VIEWS, WITH_MOTION, Codes, Colour, Form, Group, Row

__all__ = ["Marker", "write_view"]

_BESIDE = "/beside"  # the made-up folder
_SIZE_PX = 1600, 1000
_NAMES_PX, _BORDER_PX = 340, 40  # left of the waves; scroll bars and the like
_ZOOM_PX = 200  # GTKWave's zoom z: so many pixels show 2^-z steps of time
_ONE_BIT = re.compile(r"\[(\d+):\1\]$")  # of a vector that GTKWave calls name[0]
_PLOT_ROWS = 2  # a curve is so many rows higher than a number

# Trace flags, named as in GTKWave's analyzer.h.
_DEC, _BIN, _RJUSTIFY, _BLANK, _SIGNED, _COLLAPSED, _FTRANSLATED = (1 << bit for bit in (2, 3, 5, 9, 10, 12, 13))
_ANALOG_STEP, _ANALOG_BLANK_STRETCH, _ANALOG_FULLSCALE = (1 << bit for bit in (15, 17, 19))
_CLOSED, _GRP_BEGIN, _GRP_END, _FPDECSHIFT = (1 << bit for bit in (22, 23, 24, 30))

_CURVE = _ANALOG_STEP | _ANALOG_FULLSCALE
_FORMS = {
    Form.DECIMAL: _DEC,
    Form.PIXELS: _DEC | _FPDECSHIFT,
    Form.PLOT: _DEC | _CURVE,
    Form.PLOT_PIXELS: _DEC | _CURVE | _FPDECSHIFT,
    Form.SIGNED: _SIGNED,
    Form.SIGNED_PIXELS: _SIGNED | _FPDECSHIFT,
    Form.SIGNED_PLOT: _SIGNED | _CURVE,
}
_COLOURS = {Colour.PLAIN: 0, Colour.CONTROL: 2, Colour.EVENT: 3, Colour.TIME: 6, Colour.PLACE: 7}


class Marker(NamedTuple):
    """A named line at a time of the VCD, in its steps."""

    time: int
    name: str


def write_view(vcd: Path, view: Path, markers: Sequence[Marker] = (), reach: int = 0, *, force: bool = False) -> None:
    """Write a GTKWave save file for a VCD in the same folder, and a translation file for each kind of coded value.

    The view shows the groups in `views.VIEWS` for the module below the VCD's top scope, else that module's ports. It opens on
    the whole time range, or on `reach` steps around the markers: at most 26, of which the last is also the primary one.

    Raises:
        VcdError: the VCD cannot be read.
        OutputError: a file exists (without `force`), or cannot be written.
    """
    writer = _Writer(vcd, view)
    body = writer.body()
    for codes, values in writer.named.items():
        with written_aside(writer.beside(codes), force=force) as file:
            file.write("".join(f"{code} {name}\n" for name, code in values).encode())
    with written_aside(view, force=force) as file:
        file.write("".join(f"{line}\n" for line in (*_head(vcd, view, markers, reach), *body)).encode())


def _head(vcd: Path, view: Path, markers: Sequence[Marker], reach: int) -> Iterator[str]:
    begin, end = _time_span(vcd)
    if markers:
        begin, end = max(begin, markers[0].time - reach), min(end, markers[-1].time + reach)
    zoom = -math.log2(max(1, end - begin) * _ZOOM_PX / (_SIZE_PX[0] - _NAMES_PX - _BORDER_PX))
    yield f'[dumpfile] "{_BESIDE}/{vcd.name}"'
    yield f'[savefile] "{_BESIDE}/{view.name}"'
    yield f"[timestart] {begin}"
    yield f"[size] {_SIZE_PX[0]} {_SIZE_PX[1]}"
    primary = markers[-1].time if markers else -1
    yield " ".join([f"*{zoom:f}", str(primary), *(str(marker.time) for marker in markers)])
    yield from (f"[markername] {chr(ord('A') + i)}{marker.name}" for i, marker in enumerate(markers))
    yield f"[signals_width] {_NAMES_PX}"
    yield "[sst_expanded] 0"


def _time_span(vcd: Path) -> tuple[int, int]:
    """First and last time of a VCD."""
    with vcd.open("rb") as file:
        begin = next((int(line[1:].split()[0]) for line in file if line.startswith(b"#")), 0)
        tail, size = b"", file.seek(0, os.SEEK_END)
        while not (times := re.findall(rb"^#(\d+)", tail, re.MULTILINE)) and len(tail) < size:
            file.seek(-min(size, 2 * len(tail) + 4096), os.SEEK_END)
            tail = file.read()
    return begin, int(times[-1]) if times else begin


class _Writer:
    """Converts the groups of a view to lines of a save file.

    Attributes:
        named: the kinds of coded values in use, with their (name, code) pairs.
    """

    def __init__(self, vcd: Path, view: Path) -> None:
        self._view = view
        signals = declared(vcd)
        self._signals = {entry.path: entry for entry in signals}
        top = signals[0].scope.split(".")[0]
        module = next((entry.scope.split(".")[1] for entry in signals if "." in entry.scope), "")
        motion = module == "cot_motion" or self._has_motion(vcd, f"{top}.{module}.TRACKER")
        names = [WITH_MOTION.format(module), module] if motion else [module]
        self._groups = next((VIEWS[name] for name in names if name in VIEWS), ())
        self._scope = f"{top}.{module}" if self._groups else top
        if not self._groups:
            self._groups = (Group("ports", tuple(Row(entry.name) for entry in signals if entry.scope == top)),)
        scopes = {f"{self._scope}.{row.signal}".rpartition(".")[0] for group in self._groups for row in group.rows}
        self._constants = initial_values(vcd, [e for e in signals if e.name.isupper() and e.scope in scopes])
        self._frac = SUB if motion else self._constants.get(f"{self._scope}.FRAC", 0)
        self._slots = self._constants.get(f"{self._scope}.N", 1)
        self.named: dict[Codes, list[tuple[str, int]]] = {}

    def _has_motion(self, vcd: Path, tracker: str) -> bool:
        entry = self._signals.get(tracker)
        return entry is not None and initial_values(vcd, [entry])[tracker] == register_map().trackers.index("motion")

    def body(self) -> list[str]:
        return [line for group in self._groups for line in self._repeated(group)]

    def beside(self, codes: Codes) -> Path:
        """Path of the translation file for one kind of coded value."""
        return self._view.with_name(f"{self._view.stem}-{codes.name}.txt")

    def _repeated(self, group: Group) -> Iterator[str]:
        for slot in range(self._slots if "{slot}" in group.title else 1):
            lines = [line for row in group.rows for line in self._row(row, slot)]
            if lines:
                title = group.title.replace("{slot}", str(slot))
                shut = _CLOSED if group.closed else 0
                yield from (f"@{_GRP_BEGIN | _BLANK | shut:x}", f"-{title}")
                yield from lines
                yield from (f"@{_GRP_END | _BLANK | (shut and shut | _COLLAPSED):x}", f"-{title}")

    def _row(self, row: Row, slot: int) -> Iterator[str]:
        name = row.signal.replace("{slot}", str(slot))
        if "{place}" in name:  # see array_update.v
            far = self._constants.get(f"{self._scope}.{name}".rpartition(".")[0] + ".FAR", 0)
            complement = (1 << max(1, (self._slots - 1).bit_length())) - 1 - slot
            name = name.replace("{place}", str(slot if far else complement))
        entry = self._signals.get(f"{self._scope}.{name}")
        if entry is None:
            return
        scope = f"{self._scope}.{name}".rpartition(".")[0]
        width, low = entry.width, 0
        if row.packed:
            width = entry.width // self._slots
            low = slot * width
        elif row.field:
            width, *below = (self._constants[f"{scope}.{constant}"] for constant in row.field)
            low = sum(below)
        flags = _BIN if width == 1 else _FORMS[row.form]
        if row.codes is not None:
            flags |= _FTRANSLATED
            self._name(row.codes, scope)
        yield f"@{flags | _RJUSTIFY:x}"
        yield f"[color] {_COLOURS[row.colour]}"
        if flags & _FPDECSHIFT:
            yield f"[fpshift_count] {self._frac}"
        if row.codes is not None:
            yield f"^1 {_BESIDE}/{self.beside(row.codes).name}"
        label = row.label or name.rpartition(".")[2]
        is_part = entry.width > 1 and (row.packed or row.field)
        whole = _ONE_BIT.sub(r"[\1]", entry.reference)
        yield _part(label, entry, low, width) if is_part else f"+{{{label}}} {whole}"
        if flags & _ANALOG_STEP:
            yield f"@{_ANALOG_BLANK_STRETCH:x}"
            yield from ["-"] * _PLOT_ROWS

    def _name(self, codes: Codes, scope: str) -> None:
        values = ((name, self._constants.get(f"{scope}.{name}") if code is None else code) for name, code in codes.values)
        self.named[codes] = [(name, code) for name, code in values if code is not None]


def _part(label: str, entry: Declared, low: int, width: int) -> str:
    """Bits low to low + width - 1 of a vector; GTKWave counts them from the left."""
    bits = [f"({entry.width - 1 - bit}){entry.reference}" for bit in reversed(range(low, low + width))]
    return f"+{{{label}}} {bits[0]}" if width == 1 else f"#{{{label}}} {' '.join(bits)}"

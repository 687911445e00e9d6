# SPDX-License-Identifier: Apache-2.0
"""Program that converts a VCD to FST: `python fst_writer.py VCD FST`; ends with the reason on stderr if that fails.

A program, since pylibfst maps files in /tmp: where that disk is full, the system ends the process by a signal.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from typing import Any

_MODULE, _WIRE, _IMPLICIT = 0, 16, 0  # FST_ST_VCD_MODULE, FST_VT_VCD_WIRE, FST_VD_IMPLICIT of fstapi.h


def main(vcd: str, path: str) -> int:
    """Write the FST; the exit code."""
    from pylibfst import ffi, lib

    context = lib.fstWriterCreate(os.fsencode(path), 1)
    if context == ffi.NULL:
        print(os.strerror(ffi.errno) if ffi.errno else "pylibfst gives no reason", file=sys.stderr)
        return 1
    with open(vcd, "rb") as file:
        _copy(file, context, lib)
    lib.fstWriterClose(context)
    return 0


def _copy(lines: Any, context: Any, lib: Any) -> None:
    """Copy declarations, then times and values; IEEE 1364-2005, section 18.2, specifies the VCD format."""
    handles: dict[bytes, int] = {}
    widths: dict[bytes, int] = {}
    declare: dict[bytes, Callable[[list[bytes]], Any]] = {
        b"$timescale": lambda words: lib.fstWriterSetTimescaleFromString(context, b"".join(words[1:-1])),
        b"$version": lambda words: lib.fstWriterSetVersion(context, b" ".join(words[1:-1])),
        b"$scope": lambda words: lib.fstWriterSetScope(context, _MODULE, words[2], b""),
        b"$upscope": lambda _: lib.fstWriterSetUpscope(context),
    }
    for line in lines:
        words = line.split()
        if not words:
            continue
        if words[0] == b"$enddefinitions":
            break
        if words[0] == b"$var":
            width, code, name = int(words[2]), words[3], b" ".join(words[4:-1])
            handle = lib.fstWriterCreateVar(context, _WIRE, _IMPLICIT, width, name, handles.get(code, 0))
            handles.setdefault(code, handle)
            widths[code] = width
        elif words[0] in declare:
            declare[words[0]](words)
    for line in lines:
        kind = line[:1]
        if kind == b"#":
            lib.fstWriterEmitTimeChange(context, int(line[1:]))
        elif kind == b"b":
            value, code = line[1:].split()
            lib.fstWriterEmitValueChange(context, handles[code], value.rjust(widths[code], b"0"))
        elif kind in b"01xzXZ" and kind:
            lib.fstWriterEmitValueChange(context, handles[line[1:].strip()], kind)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))

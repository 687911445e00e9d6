# SPDX-License-Identifier: Apache-2.0
"""Conversion of a VCD to FST, GTKWave's own format: a tenth of the size, and faster to open.

pylibfst writes it; on platforms without its wheel there is no FST output. The library ignores errors of the system, so the
finished file is checked. A child process runs the library, since a full /tmp ends that process by a signal.
"""

from __future__ import annotations

import os
import signal
import struct
import subprocess
import sys
import zlib
from pathlib import Path
from typing import Any, BinaryIO

from evcot.errors import OutputError
from evcot.outputs import path_written_aside

__all__ = ["fst_writer", "write_fst"]


def fst_writer() -> Any | None:
    """pylibfst, or None where it is not installed."""
    try:
        import pylibfst
    except ImportError:
        return None
    return pylibfst


def write_fst(vcd: Path, path: Path, *, force: bool = False) -> None:
    """Convert a VCD written by Verilator to FST, with the same scopes, names, times and values.

    Raises:
        OutputError: it exists (without `force`), or cannot be written.
    """
    with path_written_aside(path, force=force) as aside:
        command = [sys.executable, "-P", str(_WRITER), str(vcd), str(aside)]
        done = subprocess.run(command, capture_output=True, text=True, errors="replace", check=False)
        if done.returncode:
            aside.with_name(f"{aside.name}.hier").unlink(missing_ok=True)  # a part of it, until it is complete
            by_signal = f"pylibfst was ended by {signal.Signals(-done.returncode).name}" if done.returncode < 0 else ""
            reason = by_signal or (done.stderr.splitlines() or ["pylibfst gives no reason"])[-1]
            raise OutputError(f"{path}: cannot be written: {reason} ({_NEEDS})")
        with aside.open("rb") as file:
            if not _is_whole(file):
                size = aside.stat().st_size
                raise OutputError(f"{path}: cannot be written: is cut off after {size} bytes, as by a full disk ({_NEEDS})")


def _is_whole(file: BinaryIO) -> bool:
    """Whether the file is a sequence of complete blocks that ends with the hierarchy, which the library writes last."""
    end, at = file.seek(0, os.SEEK_END), 0
    while at < end:
        file.seek(at)
        block = file.read(_BLOCK.size)
        if len(block) < _BLOCK.size:
            return False
        kind, size = _BLOCK.unpack(block)  # the size includes itself, but not the kind
        at += 1 + size
        if size < _BLOCK.size - 1 or at > end:
            return False
    if not end or kind != _HIERARCHY:
        return False
    file.read(8)  # its size when it is unpacked
    stream = zlib.decompressobj(zlib.MAX_WBITS | 16)
    try:
        stream.decompress(file.read())
    except zlib.error:
        return False
    return stream.eof


_WRITER = Path(__file__).with_name("fst_writer.py")
_NEEDS = "an FST needs 132 MB of memory, and four files in /tmp"
_BLOCK = struct.Struct(">BQ")
_HIERARCHY = 4  # FST_BL_HIER of fstapi.h

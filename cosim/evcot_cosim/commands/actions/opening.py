# SPDX-License-Identifier: Apache-2.0
"""Open a recording with the options of the command line."""

from __future__ import annotations

import argparse
import atexit
import shutil
import sys
import tempfile
from pathlib import Path

from evcot.errors import RecordingError
from evcot.recordings.files import Damage, RecordingFile, open_recording

from ..options import sensor_from

__all__ = ["open_from"]

_STANDARD_INPUT = Path("/dev/stdin")


def open_from(options: argparse.Namespace, path: Path) -> RecordingFile:
    """Open a recording as the options say.

    Raises:
        ConfigError: --sensor that is no size.
        RecordingError: as `open_recording`.
    """
    if path == _STANDARD_INPUT:
        path = path.resolve() if path.is_file() else _spooled(options)
    damage: Damage = "skip" if options.skip_damaged else "refuse"
    return open_recording(path, sensor_from(options), damage=damage, struct=options.struct)


def _spooled(options: argparse.Namespace) -> Path:
    """A file with all that comes from standard input, because readers go back; made once per command, removed at its end."""
    if not hasattr(options, "spool"):
        if sys.stdin.isatty():
            raise RecordingError("standard input: is a terminal: must be a file or a pipe")
        folder = tempfile.mkdtemp(prefix="evcot-")
        atexit.register(shutil.rmtree, folder, ignore_errors=True)
        options.spool = Path(folder) / "stdin"
        with options.spool.open("wb") as file:
            shutil.copyfileobj(sys.stdin.buffer, file)
    spool: Path = options.spool
    return spool

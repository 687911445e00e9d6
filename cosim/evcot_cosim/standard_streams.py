# SPDX-License-Identifier: Apache-2.0
"""Standard input and output as files. Readers go back, and read several times, so input is copied."""

from __future__ import annotations

import sys
from functools import lru_cache
from pathlib import Path

from evcot.errors import RecordingError

__all__ = ["STANDARD_INPUT", "STANDARD_OUTPUT", "as_file", "begin_command", "format_name", "without_copy"]

STANDARD_INPUT, STANDARD_OUTPUT = Path("/dev/stdin"), Path("/dev/stdout")


def as_file(path: Path) -> Path:
    """The same path; of standard input the file that it is, or a temporary file with all that comes from it.

    Raises:
        RecordingError: standard input is a terminal, or the temporary file has no room.
    """
    if path != STANDARD_INPUT:
        return path
    return path.resolve() if path.is_file() else _spooled()


def begin_command() -> None:
    """What an earlier command has read from standard input is no longer meant."""
    _spooled.cache_clear()


def without_copy(message: str) -> str:
    """The message, with standard input named where its copy was."""
    return message.replace(str(_spooled()), str(STANDARD_INPUT)) if _spooled.cache_info().currsize else message


def format_name(target: Path) -> str | None:
    """Of standard output, which has no suffix, npz; None where the suffix names a recording's format."""
    return "npz" if target == STANDARD_OUTPUT else None


@lru_cache(maxsize=1)
def _spooled() -> Path:
    """A copy that is made once per command, and removed at the end of the process."""
    import atexit  # here, as hardly any command needs these
    import shutil
    import tempfile

    if sys.stdin.isatty():
        raise RecordingError("standard input: is a terminal: must be a file or a pipe")
    folder = Path(tempfile.mkdtemp(prefix="evcot-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    path = folder / "stdin"
    try:
        with path.open("wb") as file:
            shutil.copyfileobj(sys.stdin.buffer, file, 1 << 20)
    except OSError as error:
        path.unlink(missing_ok=True)
        rule = "must have room for all of it; the variable TMPDIR names another folder"
        raise RecordingError(f"standard input: cannot be copied to {folder}: {error.strerror or error}: {rule}") from error
    return path

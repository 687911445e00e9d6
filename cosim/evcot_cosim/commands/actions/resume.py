# SPDX-License-Identifier: Apache-2.0
"""Long work that is continued: what identifies it, and the message about it."""

from __future__ import annotations

import os
import sys
from hashlib import blake2b
from pathlib import Path

from evcot.errors import RecordingError

from ...rtl.files import code_fingerprint

__all__ = ["say_resumed", "work_key"]


def work_key(path: Path, *depends_on: object) -> str:
    """A text that changes with a recording's file, with the program, and with what else a result depends on.

    Args:
        depends_on: each with a `repr` that says all of it.
    """
    try:
        found = os.stat(path)
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read: {error.strerror or error}") from error
    identity = str(path.absolute()), found.st_size, found.st_mtime_ns, code_fingerprint()
    return blake2b(repr((identity, depends_on)).encode(), digest_size=16).hexdigest()


def say_resumed(name: str, events: int) -> None:
    """Say that work is continued, a line on stderr."""
    print(f"{name}: continues after {events:,} events, where it was ended before", file=sys.stderr)

# SPDX-License-Identifier: Apache-2.0
"""All errors that a user can cause, one class per kind; the command line reports them in one line, with exit code 2."""

from __future__ import annotations

import difflib
import os
import re
from collections.abc import Iterable

__all__ = [
    "ConfigError",
    "DamagedRecordingError",
    "EngineError",
    "EvcotError",
    "OutputError",
    "RecordingError",
    "RecordingWarning",
    "ToolchainError",
    "TrackLogError",
    "meant",
    "reason_of",
]


_ALIKE = 0.7  # of 1, by difflib's measure
# A file or a folder that gets its own name when it is complete: see `outputs`.
_ASIDE = re.compile(r"(?<![^/])\.([^/]+)\.[0-9a-f]{8}\.partial(?![^/])")


class EvcotError(Exception):
    """Base class of all errors that a user can correct."""


class RecordingError(EvcotError, ValueError):
    """A recording that cannot be used: names the file, the offset or event index, the value and the rule."""


class DamagedRecordingError(RecordingError):
    """A recording with damage behind events that can be read: with damage "skip" they are."""


class RecordingWarning(UserWarning):
    """Events of a recording were left out, or it contradicts itself: names the file, how many events, and the reason."""


class ConfigError(EvcotError, ValueError):
    """A parameter outside its range: names the field, the value and the rule."""


class EngineError(EvcotError, RuntimeError):
    """A tracker of another package that cannot be used: names engine, package, what happened or the rule."""


class ToolchainError(EvcotError, RuntimeError):
    """A compiler or simulator is missing, too old, or failed: names the tool and what to install."""


class OutputError(EvcotError, OSError):
    """A file that cannot be written: names the file and the system's reason."""


class TrackLogError(EvcotError, ValueError):
    """A stored TrackLog that cannot be used: names the file, the field and the rule."""


def reason_of(error: OSError, path: object = "") -> str:
    """Why a file cannot be read or written, never empty: the system's text, after the file that it names if that is another.

    Args:
        path: the file that the message names already, or what the message begins with.
    """
    reason = error.strerror or " ".join(str(error).split()) or type(error).__name__
    if not isinstance(error.filename, str | bytes):
        return reason
    named, said = _ASIDE.sub(r"\1", os.fsdecode(error.filename)), str(path)
    is_said = said.endswith(named) or os.path.realpath(said) == os.path.realpath(named)
    return reason if is_said else f"{named}: {reason}"


def meant(word: str, known: Iterable[str]) -> str:
    """The known word that is most like a misspelled one, as the end of a message; empty where none is near."""
    bare = {each.lstrip("-"): each for each in known}  # the dashes of options make all of them alike
    near = difflib.get_close_matches(word.lstrip("-"), bare, 1, _ALIKE)
    return f"; did you mean {bare[near[0]]}?" if near else ""

# SPDX-License-Identifier: Apache-2.0
"""All errors that a user can cause, one class per kind; the command line reports them in one line, with exit code 2."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

__all__ = [
    "ConfigError",
    "DamagedRecordingError",
    "EvcotError",
    "OutputError",
    "RecordingError",
    "RecordingWarning",
    "ToolchainError",
    "TrackLogError",
    "meant",
]


_ALIKE = 0.7  # of 1, by difflib's measure


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


class ToolchainError(EvcotError, RuntimeError):
    """A compiler or simulator is missing, too old, or failed: names the tool and what to install."""


class OutputError(EvcotError, OSError):
    """A file that cannot be written: names the file and the system's reason."""


class TrackLogError(EvcotError, ValueError):
    """A stored TrackLog that cannot be used: names the file, the field and the rule."""


def meant(word: str, known: Iterable[str]) -> str:
    """The known word that is most like a misspelled one, as the end of a message; empty where none is near."""
    bare = {each.lstrip("-"): each for each in known}  # the dashes of options make all of them alike
    near = difflib.get_close_matches(word.lstrip("-"), bare, 1, _ALIKE)
    return f"; did you mean {bare[near[0]]}?" if near else ""

# SPDX-License-Identifier: Apache-2.0
"""Every error that a user can cause, one class per kind; the command line turns them into one line and exit code 2."""

from __future__ import annotations

__all__ = ["ConfigError", "EvcotError", "OutputError", "RecordingError", "RecordingWarning", "ToolchainError", "TrackLogError"]


class EvcotError(Exception):
    """Base of all errors that evcot raises for something a user can mend."""


class RecordingError(EvcotError, ValueError):
    """A recording that cannot be used: names the file, the offset or event index, the value and the rule."""


class RecordingWarning(UserWarning):
    """A recording of which something was left out: names the file, how many events, and why."""


class ConfigError(EvcotError, ValueError):
    """A parameter outside its range: names the field, the value and the rule."""


class ToolchainError(EvcotError, RuntimeError):
    """A compiler or simulator that is missing, too old, or that failed: names the tool and what to install."""


class OutputError(EvcotError, OSError):
    """A file that cannot be written: names the file and the system's reason."""


class TrackLogError(EvcotError, ValueError):
    """A stored TrackLog that cannot be used: names the file, the field and the rule."""

# SPDX-License-Identifier: Apache-2.0
"""Errors of waveform files, of properties, and of waveforms that fail them."""

from __future__ import annotations

from evcot.errors import EvcotError

__all__ = ["PropertyError", "VcdError", "WaveformError"]


class VcdError(EvcotError, ValueError):
    """A VCD that cannot be read, or a missing signal: names the file, the signal and similar signals."""


class PropertyError(EvcotError, TypeError):
    """An ill-formed property, such as the negation of a number: names the expression and the rule."""


class WaveformError(EvcotError, AssertionError):
    """A property that fails in a waveform, or is vacuous.

    The first line states what was expected, when and how often it failed; a table of the signals around that time follows.

    Attributes:
        path: the VCD.
        cycle: the clock at which the property first fails, or None if it is vacuous.
        time: that clock's edge in the VCD's time units, or None.
    """

    def __init__(self, message: str, path: str, cycle: int | None = None, time: int | None = None) -> None:
        super().__init__(message)
        self.path = path
        self.cycle = cycle
        self.time = time

# SPDX-License-Identifier: Apache-2.0
"""What can be wrong with a waveform, with a question asked of it, and with what it shows."""

from __future__ import annotations

from evcot.errors import EvcotError

__all__ = ["PropertyError", "VcdError", "WaveformError"]


class VcdError(EvcotError, ValueError):
    """A VCD that cannot be read, or a signal that it does not have: names the file, the signal and what is near it."""


class PropertyError(EvcotError, TypeError):
    """A property that makes no sense, such as the negation of a number: names the expression and the rule."""


class WaveformError(EvcotError, AssertionError):
    """A property that a waveform breaks, or never puts to the test.

    The first line says what was expected, when and how often it fails; a table of the signals around that time follows.

    Attributes:
        path: the VCD.
        cycle: the clock at which the property fails first, or None when it was never put to the test.
        time: that clock's edge in the VCD's time units, or None.
    """

    def __init__(self, message: str, path: str, cycle: int | None = None, time: int | None = None) -> None:
        super().__init__(message)
        self.path = path
        self.cycle = cycle
        self.time = time

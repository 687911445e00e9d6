# SPDX-License-Identifier: Apache-2.0
"""Exit codes other than 0, done."""

from __future__ import annotations

__all__ = ["BROKEN", "MISMATCH", "USER_ERROR"]

MISMATCH = 1  # hardware and model differ
BROKEN = 1  # a property of a waveform does not hold
USER_ERROR = 2  # something that the user can mend

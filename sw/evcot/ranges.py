# SPDX-License-Identifier: Apache-2.0
"""Settings and their limits: one table per settings class, from which checks and messages come."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .errors import ConfigError

__all__ = ["Range", "check_ranges", "span"]

Range = tuple[float, float, str]
"""Lowest, highest, meaning; two integers stand for an integer setting."""


def span(low: float, high: float) -> str:
    """Limits as a message says them: integers in full."""
    return " to ".join(str(limit) if isinstance(limit, int) else f"{limit:g}" for limit in (low, high))


def check_ranges(name: str, settings: Any, ranges: Mapping[str, Range]) -> None:
    """Raise ConfigError for the first field of `settings` that lies outside its entry in `ranges`, or is of another kind."""
    for field, (low, high, meaning) in ranges.items():
        value = getattr(settings, field)
        wanted = int if isinstance(low, int) else (int, float)
        if isinstance(value, bool) or not isinstance(value, wanted) or not low <= value <= high:
            raise ConfigError(f"{name}.{field} = {value!r}: must be from {span(low, high)} ({meaning})")

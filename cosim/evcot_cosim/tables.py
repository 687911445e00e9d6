# SPDX-License-Identifier: Apache-2.0
"""Small tables on a terminal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

__all__ = ["counted", "print_table"]


def print_table(rows: Sequence[Sequence[Any]]) -> None:
    """Print rows of equal length, columns aligned to the left."""
    widths = [max(len(str(row[i])) for row in rows) for i in range(len(rows[0]))]
    for row in rows:
        print("  ".join(str(cell).ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip())


def counted(n: int, noun: str) -> str:
    """A number and what it counts: 1 alarm, 2 alarms."""
    return f"{n:,} {noun}" if n == 1 else f"{n:,} {noun}s"

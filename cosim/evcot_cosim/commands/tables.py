# SPDX-License-Identifier: Apache-2.0
"""Small tables on a terminal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

__all__ = ["print_table"]


def print_table(rows: Sequence[Sequence[Any]]) -> None:
    """Print rows of equal length, columns aligned to the left."""
    widths = [max(len(str(row[i])) for row in rows) for i in range(len(rows[0]))]
    for row in rows:
        print("  ".join(str(cell).ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip())

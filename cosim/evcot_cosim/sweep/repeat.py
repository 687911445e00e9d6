# SPDX-License-Identifier: Apache-2.0
"""Repeats one run of a sweep, by its key, and compares it with the store."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from evcot.errors import ConfigError

from .execute import execute
from .folder import spec_of
from .metrics import METRICS
from .store import read_rows
from .task import Task

__all__ = ["Difference", "Repeated", "repeat"]

_LEAST = 6  # digits of a key: enough to distinguish runs


@dataclass(frozen=True)
class Difference:
    """A column in which a run and its row differ."""

    name: str
    stored: Any
    now: Any


@dataclass(frozen=True)
class Repeated:
    """A run that was done again: its row, and where that differs from the stored one."""

    row: Mapping[str, Any]
    stored: bool
    differences: tuple[Difference, ...]

    @property
    def shown(self) -> list[tuple[str, str]]:
        """The result as a table for people."""
        names = ("key", "status", "engine", "hardware", "preset", "input", "error")
        rows = [(name, str(self.row[name])) for name in names if self.row.get(name)]
        rows += [(name, str(value)) for name, value in self.row["settings"].items()]
        return rows + [(name, f"{self.row[name]:.6g}") for name in METRICS if self.row.get(name) is not None]


def repeat(folder: Path, key: str) -> Repeated:
    """Do a run of the sweep in a folder again; the store stays as it is.

    Args:
        key: of the run, or its first digits.

    Raises:
        ConfigError: no such folder or run, or a program that has changed since.
    """
    spec_of(folder)
    matching = [row for row in read_rows(folder) if row["key"].startswith(key)] if len(key) >= _LEAST else []
    if len(matching) != 1:
        raise ConfigError(f"--only {key}: is the key of {len(matching)} runs in {folder}: must be that of one")
    stored = matching[0]
    row = execute(Task.from_json(stored["task"]))
    names = ("status", "error", *METRICS)
    compared = [Difference(name, stored[name], row.get(name)) for name in names]
    different = tuple(each for each in compared if each.stored != each.now)
    return Repeated(row, True, different)

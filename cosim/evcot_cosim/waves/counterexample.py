# SPDX-License-Identifier: Apache-2.0
"""Messages for failed properties: one line, then a table of the signals around the failure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import IntEnum
from typing import TYPE_CHECKING

from .errors import WaveformError

if TYPE_CHECKING:
    from .wave import Samples

__all__ = ["Names", "failure", "untested", "value_text"]

Names = Mapping[str, type[IntEnum]]
"""Signals, by path, whose values have names."""

_BEFORE, _AFTER = 3, 2
_COLUMNS = 12
_ROWS = 24


def failure(
    samples: Samples,
    property_text: str,
    what: str,
    cycle: int,
    paths: Sequence[str],
    *,
    failures: int,
    cases: int,
    until: int | None = None,
    names: Names | None = None,
) -> WaveformError:
    """The error for a property that first fails at `cycle`; the table extends to cycle `until` as far as there is room."""
    time = int(samples.times[cycle])
    scale = samples.wave.timescale
    head = (
        f"{property_text}: {what} at {scale.text(time)}, cycle {cycle}; "
        f"{failures} of {cases} cases fail ({samples.wave.path}, rising {samples.clock})"
    )
    last = min(max(cycle + _AFTER, until or 0), cycle - _BEFORE + _COLUMNS - 1, len(samples) - 1)
    cycles = range(max(0, cycle - _BEFORE), last + 1)
    table = [["cycle", *(f">{i}" if i == cycle else str(i) for i in cycles)]]
    table.append([scale.unit, *(str(int(samples.times[i]) * scale.magnitude) for i in cycles)])
    table += [[path, *(value_text(samples.text(path, i), (names or {}).get(path)) for i in cycles)] for path in paths[:_ROWS]]
    lines = [head, *_aligned(table)]
    if len(paths) > _ROWS:
        lines.append(f"  and {len(paths) - _ROWS} more signals")
    return WaveformError("\n".join(lines), str(samples.wave.path), cycle, time)


def untested(samples: Samples, property_text: str, why: str) -> WaveformError:
    """The error for a property that is vacuous in the waveform."""
    if not len(samples):
        why = f"no samples: {samples.clock} never rises"
        span = ""
    else:
        text = samples.wave.timescale.text
        span = f" in {len(samples)} cycles, {text(int(samples.times[0]))} to {text(int(samples.times[-1]))}"
    return WaveformError(f"{property_text}: vacuous: {why}{span} ({samples.wave.path})", str(samples.wave.path))


def value_text(text: str, names: type[IntEnum] | None) -> str:
    """The name of a value, if it has one, else the value."""
    return {str(int(member)): member.name for member in names or ()}.get(text, text)


def _aligned(table: list[list[str]]) -> list[str]:
    widths = [max(len(row[i]) for row in table) for i in range(len(table[0]))]
    return [
        "  "
        + "  ".join([row[0].ljust(widths[0]), *(cell.rjust(width) for cell, width in zip(row[1:], widths[1:], strict=True))])
        for row in table
    ]

# SPDX-License-Identifier: Apache-2.0
"""Interfaces of readers and writers of event files: source of blocks, sink of blocks, and format detection."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, Protocol

from ...events import Events

__all__ = ["BLOCK_EVENTS", "AnySensor", "Format", "Sensor", "Sink", "Source", "WritableFormat"]

# Approximate number of events per block: enough to amortise the fixed cost of a block, few enough for a core's cache.
BLOCK_EVENTS = 1 << 15

Sensor = tuple[int, int]  # width, height in pixels


class Source(Protocol):
    """An open event file.

    Attributes:
        sensor: (width, height) in pixels as stated in the file; None if not stated.
        details: other metadata of the file, for `evcot info`: short name -> short value.
        left_out: reason -> number of events left out in the most recent pass of `blocks`; complete when the pass has ended.
        remarks: where the file contradicts itself without any event being lost; one line each, complete as above.
    """

    @property
    def sensor(self) -> Sensor | None: ...

    @property
    def details(self) -> Mapping[str, str]: ...

    @property
    def left_out(self) -> Mapping[str, int]: ...

    @property
    def remarks(self) -> Sequence[str]: ...

    def blocks(self, from_us: int | None = None) -> Iterator[Events]:
        """All events, in file order and with the file's times, in blocks of about `BLOCK_EVENTS`.

        May be called again for another pass. Memory does not grow with the file's length.

        Args:
            from_us: absolute time; a format that supports seeking skips most events before it without reading them. The
                caller drops the rest.

        Raises:
            RecordingError: where the file is damaged, after the blocks before it. The message names place, value and rule,
                but not the file.
        """
        ...

    def smallest_sensor(self, width: int, height: int) -> Sensor:
        """The sensor to assume if none is stated and all events lie below (width, height)."""
        ...

    def close(self) -> None:
        """Close the file."""
        ...


class AnySensor:
    """The part of a `Source` that formats have in common whose files may be of a sensor of any size."""

    def smallest_sensor(self, width: int, height: int) -> Sensor:
        """See `Source`."""
        return width, height


@dataclass(frozen=True)
class Format:
    """A kind of event file that can be read.

    Attributes:
        name: identifier, lower case: "evt3".
        title: display name: "Prophesee RAW, EVT 3.0".
        matches: whether the path, with its first bytes (up to 1024; empty for a directory), is such a file.
        open: opens it; raises RecordingError, without the file's name, if its header is damaged.
        open_struct: opens one of several lists of events in it, by name; None where a file holds one.
    """

    name: str
    title: str
    matches: Callable[[bytes, Path], bool]
    open: Callable[[Path], Source]
    open_struct: Callable[[Path, str], Source] | None = None


class Sink(Protocol):
    """An event file being written."""

    def write(self, events: Events) -> None:
        """Append events; times must not decrease.

        Raises:
            RecordingError: a value that the format cannot represent; names event index, value and rule.
        """
        ...

    def close(self) -> None:
        """Write the end of the format; closing the file itself is up to the caller."""
        ...


@dataclass(frozen=True)
class WritableFormat:
    """A kind of event file that can be written: identifier, display name, suffix, and constructor of its sink."""

    name: str
    title: str
    suffix: str
    begin: Callable[[BinaryIO, Sensor], Sink]

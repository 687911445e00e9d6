# SPDX-License-Identifier: Apache-2.0
"""What every reader and writer of event files is to the rest: a source of blocks, a sink of blocks, and how to tell a file."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, Protocol

from ...events import Events

__all__ = ["BLOCK_EVENTS", "Format", "Sensor", "Sink", "Source", "WritableFormat"]

# About how many events a block holds: a fixed cost of a block spread over many, and little enough to stay in a core's cache.
BLOCK_EVENTS = 1 << 15

Sensor = tuple[int, int]  # width, height in pixels


class Source(Protocol):
    """An open event file.

    Attributes:
        sensor: (width, height) in pixels as the file states it; None where it does not.
        details: what else the file says about itself, for `evcot info`: short name -> short value.
        left_out: why events could not be given -> how many, of the pass that `blocks` last began; complete when it has ended.
    """

    @property
    def sensor(self) -> Sensor | None: ...

    @property
    def details(self) -> Mapping[str, str]: ...

    @property
    def left_out(self) -> Mapping[str, int]: ...

    def blocks(self, from_us: int | None = None) -> Iterator[Events]:
        """Every event, in the file's order and with the file's own time, in blocks of about `BLOCK_EVENTS`.

        May be called again for another pass. Memory does not grow with the file's length.

        Args:
            from_us: absolute time; a format that can find its place leaves out events before it without reading them, as
                far as that is easy. The caller drops the rest.

        Raises:
            RecordingError: at the place where the file is damaged, after the blocks before it. The message gives place,
                value and rule, without the file's name.
        """
        ...

    def smallest_sensor(self, width: int, height: int) -> Sensor:
        """The sensor to assume where none is stated and every event lies below (width, height)."""
        ...

    def close(self) -> None:
        """Let go of the file."""
        ...


@dataclass(frozen=True)
class Format:
    """A kind of event file that can be read.

    Attributes:
        name: short, lower case: "evt3".
        title: for people: "Prophesee RAW, EVT 3.0".
        matches: whether the path, whose first bytes (up to 1024; none of a directory) are given, is such a file.
        open: opens it; raises RecordingError, without the file's name, where its header is damaged.
    """

    name: str
    title: str
    matches: Callable[[bytes, Path], bool]
    open: Callable[[Path], Source]


class Sink(Protocol):
    """An event file that is being written."""

    def write(self, events: Events) -> None:
        """Append events that follow those before in time.

        Raises:
            RecordingError: a value that the format cannot hold; names event index, value and rule.
        """
        ...

    def close(self) -> None:
        """Write what the format needs at its end; the file itself stays the caller's."""
        ...


@dataclass(frozen=True)
class WritableFormat:
    """A kind of event file that can be written: name, title for people, suffix, and how to begin one."""

    name: str
    title: str
    suffix: str
    begin: Callable[[BinaryIO, Sensor], Sink]

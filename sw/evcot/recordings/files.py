# SPDX-License-Identifier: Apache-2.0
"""Open, read and write recordings; a file's format is detected from its content, not from its name."""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from types import TracebackType
from typing import Literal

import numpy as np

from .._numba_private import njit
from ..errors import ConfigError, DamagedRecordingError, RecordingError, RecordingWarning
from ..events import Events, Recording, check_sensor, find_fault
from ..outputs import note_input, reading, written_aside
from . import formats
from .formats.source import BLOCK_EVENTS, Sensor, Source, WritableFormat

__all__ = [
    "HELD_US",
    "Damage",
    "RecordingFile",
    "format_for",
    "open_recording",
    "read_recording",
    "sound",
    "write_events",
    "write_recording",
]

Damage = Literal["refuse", "skip"]

HELD_US = 10_000  # a time that runs back by no more is held at the latest one; by more, it is damage

_RESTART_EVENTS = 16  # so many in a row stay behind the latest time where time restarts; fewer are strays

_SNIFF_BYTES = 1024


class RecordingFile:
    """A recording on disk, read in blocks: memory does not grow with its length. Use as a context manager.

    Attributes:
        path, name: the file, and its name without suffix.
        format: the format's display name.
        assumes_sensor: whether the sensor size is assumed, because neither the caller nor the file states it.
        details: other metadata of the file.
        left_out: reason -> number of events left out in the most recent pass of `blocks`; complete when the pass has ended.
        remarks: faults found in that pass for which no event was left out, one line each.
    """

    def __init__(self, path: Path, format_title: str, source: Source, sensor: Sensor | None, damage: Damage) -> None:
        self.path = path
        self.name = path.stem
        self.format = format_title
        self._source = source
        self._sensor = sensor or source.sensor
        self.assumes_sensor = self._sensor is None
        self._damage = damage
        self._t0_us: int | None = None
        self.left_out: Counter[str] = Counter()
        self.remarks: list[str] = []
        if self._sensor is not None:
            check_sensor(str(path), *self._sensor)
        self._release = reading(self, path)

    def __enter__(self) -> RecordingFile:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._source.close()
        self._release()

    @property
    def details(self) -> Mapping[str, str]:
        """Metadata of the file other than its sensor: short name -> short value."""
        return self._source.details

    @property
    def sensor(self) -> Sensor:
        """(width, height) in pixels: the caller's, else the file's, else the smallest that holds all events (one pass)."""
        if self._sensor is None:
            width = height = 1
            for block in self._source_blocks(None, warn=False):
                if len(block):
                    width, height = max(width, int(block.x.max()) + 1), max(height, int(block.y.max()) + 1)
            self._sensor = self._source.smallest_sensor(width, height)
        return self._sensor

    @property
    def t0_us(self) -> int:
        """Time of the first event.

        Raises:
            RecordingError: the file holds no events, or is damaged before the first one.
        """
        if self._t0_us is None:
            self._t0_us = next((int(block.t_us[0]) for block in self._source_blocks(None, warn=False) if len(block)), None)
            if self._t0_us is None:
                raise RecordingError(f"{self.path}: holds no events")
        return self._t0_us

    def blocks(self, from_us: int = 0, to_us: int | None = None, *, required: bool = False) -> Iterator[Events]:
        """The events with from_us <= t - t0_us < to_us, validated, in file order.

        Args:
            from_us, to_us: times since the first event; None: to the end.
            required: whether a window without events is an error.

        Raises:
            RecordingError: the file is damaged, time runs back by more than `HELD_US`, or an event lies outside the sensor;
                names file, place, value and rule. With damage "skip" such events are left out instead, and so is everything
                after a place that cannot be read; where time restarts, it goes on from the latest time. Also raised where
                an event is `required` and there is none.
        Warns:
            RecordingWarning: events were left out, how many and why; events ran back in time by no more than `HELD_US` and
                have the time of the latest before them; or the file contradicts itself.
        """
        width, height = self.sensor
        t0_us = self.t0_us
        begin = t0_us + from_us
        end = None if to_us is None else t0_us + to_us
        last_us = np.iinfo(np.int64).min
        seen = given = 0
        broken: Counter[str] = Counter()
        held = longest_us = restarts = shift_us = 0
        # A reader that skips to `begin` goes by the times in the file: not where they may restart.
        for block in self._source_blocks(begin if from_us > 0 and self._damage == "refuse" else None):
            if shift_us:
                block = Events(block.t_us + shift_us, block.x, block.y, block.p)
            fault = find_fault(block, width, height, last_us)
            first_index, seen = seen, seen + len(block)
            if fault is not None:
                goes_on = self._damage == "skip"
                if goes_on:
                    block = _inside(block, width, height, broken)
                block, count, back_us, more_us, more_restarts = _held(block, last_us, t0_us + shift_us, goes_on)
                held, longest_us = held + count, max(longest_us, back_us)
                restarts, shift_us = restarts + more_restarts, shift_us + more_us
                if goes_on:
                    block = _forward(block, last_us, broken)
                elif (fault := find_fault(block, width, height, last_us) if count else fault) is not None:
                    raise DamagedRecordingError(f"{self.path}: {fault.describe(first_index)}{_counted_from(from_us)}")
            if not len(block):
                continue
            last_us = int(block.t_us[-1])
            first = int(np.searchsorted(block.t_us, begin)) if block.t_us[0] < begin else 0
            past = len(block) if end is None or last_us < end else int(np.searchsorted(block.t_us, end))
            if first < past:
                given += past - first
                yield block[first:past]
            if past < len(block):
                break
        self.left_out = Counter(self._source.left_out) + broken
        self.remarks = [*self._source.remarks]
        if held:
            what = f"{held} events run back in time, by at most {longest_us} us: each has the time of the latest before it"
            self.remarks.append(what)
        if restarts:
            places = "one place" if restarts == 1 else f"{restarts} places"
            self.remarks.append(f"time restarts in {places}: there, it goes on from the latest time before")
        for what in (*(f"{count} events left out: {why}" for why, count in self.left_out.items()), *self.remarks):
            warnings.warn(RecordingWarning(f"{self.path}: {what}"), stacklevel=2)
        if required and not given:
            window = f"from {from_us / 1e6:g} s" + ("" if to_us is None else f" to {to_us / 1e6:g} s")
            raise RecordingError(f"{self.path}: holds no events {window}")

    def read(self, from_us: int = 0, to_us: int | None = None) -> Recording:
        """Read the events of `blocks` into one recording in memory.

        Raises:
            RecordingError: as for `blocks`, or there is no event in the window.
        """
        return Recording(Events.joined(self.blocks(from_us, to_us, required=True)), *self.sensor, self.name)

    def _source_blocks(self, from_us: int | None, *, warn: bool = True) -> Iterator[Events]:
        """The source's blocks; errors are prefixed with the file's name.

        Args:
            warn: whether to warn about events left out after a place that cannot be read.
        """
        given = 0
        try:
            for block in self._source.blocks(from_us):
                given += len(block)
                yield block
        except OSError as error:
            raise RecordingError(f"{self.path}: cannot be read: {error.strerror or error}") from error
        except RecordingError as error:
            if not given:
                raise RecordingError(f"{self.path}: {error}") from error
            if self._damage == "refuse":
                raise DamagedRecordingError(f"{self.path}: {error}") from error
            if warn:
                after = f"{given} events{_counted_from(0 if from_us is None else from_us - self.t0_us)}"
                warnings.warn(RecordingWarning(f"{self.path}: everything after {after} left out: {error}"), stacklevel=2)


def _counted_from(from_us: int) -> str:
    """The start of a window, for messages with indices and counts; empty where that is the start of the file."""
    return f" (counted from {from_us / 1e6:g} s)" if from_us else ""


def _held(events: Events, latest_us: int, start_us: int, goes_on: bool) -> tuple[Events, int, int, int, int]:
    """Give events that run back in time, by `HELD_US` at most, the time of the latest before them; those that run back further
    are unchanged. Where `goes_on`, times that restart go on from the latest one.

    A camera's readout, or the program that merges its packets, may swap events that lie microseconds apart. A time restarts
    where it runs back to the recording's first time, `start_us`, and stays behind.

    Returns:
        The events; how many were held, and the longest way back; how much later the times after the last restart are, and
        the number of restarts.
    """
    t_us = events.t_us.copy()
    figures = _hold(t_us, latest_us, start_us, goes_on)
    held, longest_us, shift_us, restarts = (int(figure) for figure in figures)
    return Events(t_us, events.x, events.y, events.p), held, longest_us, shift_us, restarts


@njit(cache=True, nogil=True)
def _hold(t_us, latest_us, start_us, goes_on):  # type: ignore[no-untyped-def]
    held, longest_us, shift_us, restarts = 0, np.int64(0), np.int64(0), 0
    for i in range(len(t_us)):
        now_us = t_us[i] + shift_us
        if now_us < latest_us:
            back_us = latest_us - now_us  # negative where the difference exceeds 63 bits
            if 0 < back_us <= HELD_US:
                held += 1
                longest_us = max(longest_us, back_us)
                now_us = latest_us
            elif (
                goes_on
                and back_us > 0
                and now_us - shift_us <= start_us + HELD_US
                and _stays_behind(t_us, i, latest_us - shift_us)
            ):
                shift_us += back_us
                restarts += 1
                now_us = latest_us
        latest_us = max(latest_us, now_us)
        t_us[i] = now_us
    return held, longest_us, shift_us, restarts


@njit(cache=True, nogil=True)
def _stays_behind(t_us, first, latest_us):  # type: ignore[no-untyped-def]
    if first + _RESTART_EVENTS > len(t_us):
        return False
    for i in range(first, first + _RESTART_EVENTS):
        if latest_us - t_us[i] <= HELD_US or (i > first and t_us[i - 1] - t_us[i] > HELD_US):
            return False
    return True


def sound(events: Events, width: int, height: int, after_us: int, broken: Counter[str]) -> Events:
    """The events inside the sensor whose times do not decrease; the others are counted in `broken`."""
    return _forward(_inside(events, width, height, broken), after_us, broken)


def _inside(events: Events, width: int, height: int, broken: Counter[str]) -> Events:
    kept = events.where((events.x < width) & (events.y < height) & (events.p <= 1))
    broken["outside the sensor, or without a polarity"] += len(events) - len(kept)
    return kept


def _forward(events: Events, after_us: int, broken: Counter[str]) -> Events:
    latest = np.maximum.accumulate(np.maximum(events.t_us, after_us))
    forward = events.where(events.t_us == latest)
    broken["time runs back"] += len(events) - len(forward)
    return forward


def open_recording(
    path: Path | str, sensor: Sensor | None = None, *, damage: Damage = "refuse", struct: str | None = None
) -> RecordingFile:
    """Open an event file of any format in `evcot.recordings.formats`.

    Args:
        path: the file; its format is detected from its content.
        sensor: (width, height) in pixels, overrides what the file states. Without it, a file that does not state its sensor
            gets the smallest (for a Prophesee file: the smallest common one) that holds every event.
        damage: how to handle invalid events and unreadable places: refuse the file, or leave out what is invalid and warn
            with the number of events. Where time restarts, "skip" lets it go on from the latest time.
        struct: of a MATLAB file with several structs of events the one to read, by name; None: TD, else the first.

    Raises:
        RecordingError: the file is missing, unreadable, empty, of no known format, or its header is damaged. One line: file,
            place, value, rule.
    """
    path = Path(path)
    note_input(path)
    try:
        title, source = _open(path, struct)
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read: {error.strerror or error}") from error
    except RecordingError as error:
        raise RecordingError(f"{path}: {error}") from error
    try:
        return RecordingFile(path, title, source, sensor, damage)
    except BaseException:
        source.close()
        raise


_LFS = b"version https://git-lfs.github.com/spec/"


def _open(path: Path, struct: str | None) -> tuple[str, Source]:
    start = b""
    if path.is_file():
        with path.open("rb") as file:
            start = file.read(_SNIFF_BYTES)
        if not start:
            raise RecordingError("is empty")
    elif not path.exists():
        raise FileNotFoundError(2, "No such file or directory")
    elif not path.is_dir():
        raise RecordingError("is a device or a pipe: must be a file")
    if start.startswith(_LFS):
        raise RecordingError("is a pointer of Git LFS, without the data: get these with `git lfs pull`")
    kind = formats.format_of(start, path)
    if kind is None:
        if path.is_dir():
            raise RecordingError("is a directory, and no ROS 2 bag: has no metadata.yaml")
        raise RecordingError(f"has an unknown format: must be one of {', '.join(each.title for each in formats.formats())}")
    if struct is None:
        return kind.title, kind.open(path)
    if kind.open_struct is None:
        raise RecordingError(f"is {kind.title}, which has no structs: struct must not be given")
    return kind.title, kind.open_struct(path, struct)


def read_recording(
    path: Path | str,
    sensor: Sensor | None = None,
    *,
    from_us: int = 0,
    to_us: int | None = None,
    damage: Damage = "refuse",
) -> Recording:
    """Read a recording, or a window of it, into memory: `open_recording` followed by `RecordingFile.read`.

    Events keep the file's order and times: nothing is sorted or shifted, and the number of events left out is reported in a
    warning.

    Example:
        recording = evcot.read("drive.aedat4", from_us=500_000, to_us=900_000)
        recording.events.x  # (n,) uint16, pixels

    Args:
        path: the file; its format is detected from its content.
        sensor: (width, height) in pixels, in place of what the file states.
        from_us, to_us: the window, in microseconds since the first event; None: to the end.
        damage: what to do about events that break the rules, see `open_recording`.

    Raises:
        RecordingError: the file cannot be read, or has no event in the window.
    """
    with open_recording(path, sensor, damage=damage) as file:
        return file.read(from_us, to_us)


def write_events(
    path: Path | str, sensor: Sensor, blocks: Iterable[Events], format_name: str | None = None, *, force: bool = False
) -> int:
    """Write blocks of events, in time order, and return the number of events; the file appears only when it is complete.

    Args:
        format_name: one of `formats.WRITABLE`; if not given, chosen by the path's suffix.
        force: replace an existing file, but never one that is being read.

    Raises:
        ConfigError: unknown format or suffix.
        RecordingError: a value that the format cannot represent, or that is invalid in a recording.
        OutputError: the file exists, is a recording that is open, or cannot be written.
    """
    path = Path(path)
    kind = format_for(path, format_name)
    check_sensor(str(path), *sensor)
    count, last_us = 0, np.iinfo(np.int64).min
    with written_aside(path, force=force) as file:
        sink = kind.begin(file, sensor)
        for block in blocks:
            for begin in range(0, len(block), BLOCK_EVENTS):
                part = block[begin : begin + BLOCK_EVENTS]
                fault = find_fault(part, *sensor, last_us)
                if fault is not None:
                    raise RecordingError(f"{path}: {fault.describe(count)}")
                try:
                    sink.write(part)
                except RecordingError as error:
                    raise RecordingError(f"{path}: {error}") from error
                count, last_us = count + len(part), int(part.t_us[-1])
        sink.close()
    return count


def write_recording(recording: Recording, path: Path | str, format_name: str | None = None, *, force: bool = False) -> None:
    """Write a recording from memory in the format of the path's suffix, or in another one; see `write_events`.

    Raises:
        ConfigError, RecordingError, OutputError: as `write_events`.
    """
    if not isinstance(recording, Recording) or not isinstance(path, str | Path):
        kinds = f"{type(recording).__name__} and {type(path).__name__}"
        raise RecordingError(f"arguments of type {kinds}: must be a Recording, then the path of the file to write")
    write_events(path, (recording.width, recording.height), [recording.events], format_name, force=force)


def format_for(path: Path | str, name: str | None = None) -> WritableFormat:
    """The format in which to write a file: by name if one is given, else by the path's suffix.

    Raises:
        ConfigError: unknown format or suffix.
    """
    if name is not None:
        if name not in formats.WRITABLE:
            raise ConfigError(f"format {name!r}: must be one of {', '.join(formats.WRITABLE)}")
        return formats.WRITABLE[name]
    suffix = Path(path).suffix
    kind = next((kind for kind in formats.WRITABLE.values() if kind.suffix == suffix.lower()), None)
    if kind is None:
        suffixes = ", ".join(dict.fromkeys(kind.suffix for kind in formats.WRITABLE.values()))
        raise ConfigError(f"{path}: suffix {suffix!r}: must be one of {suffixes}, or the format must be named")
    return kind

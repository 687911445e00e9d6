# SPDX-License-Identifier: Apache-2.0
"""Small files read in tests: as rows, as the line that refuses them, and as the readers of other packages read them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.errors import RecordingError
from evcot.events import Events
from evcot.recordings.files import read_recording
from shared import SHARED

__all__ = [
    "FIELDS",
    "Row",
    "assert_same",
    "by_others",
    "columns_of",
    "read",
    "refusal",
    "rows_of",
    "shared",
    "written_by_faery",
]

Row = tuple[int, int, int, int]  # t_us, x, y, p
FIELDS = {"t_us": np.int64, "x": np.uint16, "y": np.uint16, "p": np.uint8}


def columns_of(events: Events) -> list[NDArray[Any]]:
    return [getattr(events, field) for field in FIELDS]


def rows_of(events: Events) -> list[Row]:
    return list(zip(*(column.tolist() for column in columns_of(events)), strict=True))


def assert_same(got: Events, wanted: Events | Sequence[NDArray[Any]]) -> None:
    """Equal events, or columns t, x, y, p; each of the type that events have."""
    columns = columns_of(wanted) if isinstance(wanted, Events) else wanted
    for (field, kind), column in zip(FIELDS.items(), columns, strict=True):
        assert getattr(got, field).dtype == kind
        np.testing.assert_array_equal(getattr(got, field), column)


def read(path: Path, content: bytes | str, **options: Any) -> list[Row]:
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return rows_of(read_recording(path, **options).events)


def refusal(path: Path, content: bytes | str | None = None, **options: Any) -> str:
    """The one line with which a file, or this content in it, is refused, without the file's name that it starts with."""
    if content is not None:
        path.write_bytes(content.encode() if isinstance(content, str) else content)
    with pytest.raises(RecordingError) as caught:
        read_recording(path, **options)
    message = str(caught.value)
    assert message.startswith(f"{path}: ")
    assert message.isprintable()
    return message.removeprefix(f"{path}: ")


def shared(name: str) -> Path:
    """A recording of a camera, where it is on this machine."""
    if not (SHARED / name).is_file():
        pytest.skip(f"{name} is not on this machine")
    return SHARED / name


def _faery(path: Path) -> list[NDArray[Any]]:
    events = pytest.importorskip("faery").events_stream_from_file(path).to_array()
    return [events[name] for name in ("t", "x", "y", "on")]


def _aedat(path: Path) -> list[NDArray[Any]]:
    packets = pytest.importorskip("aedat").Decoder(path)
    events = np.concatenate([packet["events"] for packet in packets if "events" in packet])
    return [events[name] for name in ("t", "x", "y", "on")]


def _evt3(path: Path) -> list[NDArray[Any]]:
    events = pytest.importorskip("evt3").decode_file(str(path))
    return [events.t, events.x, events.y, events.p]


def _expelliarmus(path: Path, encoding: str) -> list[NDArray[Any]]:
    events = pytest.importorskip("expelliarmus").Wizard(encoding=encoding).read(path)
    return [events[name] for name in ("t", "x", "y", "p")]


def _eventcv(path: Path, **options: str) -> list[NDArray[Any]]:
    x, y, t, p = np.asarray(pytest.importorskip("eventcv").load(str(path), **options).numpy()).astype(np.int64).T
    return [t, x, y, p > 0]


_READERS: dict[str, Callable[..., list[NDArray[Any]]]] = {
    "faery": _faery, "aedat": _aedat, "evt3": _evt3, "expelliarmus": _expelliarmus, "eventcv": _eventcv,
}  # fmt: skip


def by_others(reader: str, path: Path, **options: str) -> Events:
    """The events that another package finds in a file; the test is skipped where that package is not installed."""
    columns = _READERS[reader](path, **options)
    return Events(*(np.asarray(column).astype(kind) for column, kind in zip(columns, FIELDS.values(), strict=True)))


def written_by_faery(path: Path, events: Events, sensor: tuple[int, int], **options: Any) -> Path:
    faery = pytest.importorskip("faery")
    packet = np.zeros(len(events), faery.EVENTS_DTYPE)
    packet["t"], packet["x"], packet["y"], packet["on"] = columns_of(events)
    faery.events_stream_from_array(packet, sensor).to_file(path, **options)
    return path

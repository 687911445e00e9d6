# SPDX-License-Identifier: Apache-2.0
"""MCAP files that Foxglove shows: boxes as annotations over a picture of the sensor, and as numbers. https://mcap.dev

Three topics, all JSON, a message each at every instant:

    /tracks/boxes        evcot.Boxes                the numbers, in evcot's coordinates; this one is read again
    /tracks/annotations  foxglove.ImageAnnotations  a rectangle and an id a box; pixels begin at their upper left corner
    /sensor              foxglove.CompressedImage   a black picture of the sensor's size, for the Image panel to draw them on

Foxglove finds its schemas by their names; those written here have the fields that are used. A layout that shows the topics is
written next to the file, for Foxglove's menu "Import from file", unless a file of that name exists.
"""

from __future__ import annotations

import base64
import io
import json
import math
import os
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from ...errors import TrackLogError
from ...outputs import note_input, written_aside
from .base import BOX, FRAME_MAX, Boxes, FrameClock

__all__ = ["COLOURS", "FoxgloveBoxes", "layout_for"]

COLOURS = tuple(
    (int(text[:2], 16) / 255, int(text[2:4], 16) / 255, int(text[4:], 16) / 255)
    for text in ("e69f00", "56b4e9", "009e73", "f0e442", "0072b2", "d55e00", "cc79a7", "ffffff")
)
"""Red, green and blue from 0 to 1, of ids in turn: the palette of Okabe and Ito, with white for black."""

_EDGE = 0.5  # where the first pixel begins, 0, less where it does in evcot, -0.5
_TIME_MAX_US = (2**63 - 1) // 1000
_SIDE_MAX = 1 << 14  # of the picture
_CHUNK_MAX = 1 << 26  # bytes of a chunk: more are not evcot's
_NEEDED = "mcap is not installed: must be, for MCAP: pip install 'evcot[mcap]'"
_LINE_LOOP = 2  # of foxglove.PointsAnnotationType
_BOXES = "/tracks/boxes"
_NUMBERS = ("left", "top", "width", "height", "confidence", "visibility")
_INTEGERS = ("id", "class_id")

_NUMBER: dict[str, Any] = {"type": "number"}
_TEXT: dict[str, Any] = {"type": "string"}


def _object(**properties: Any) -> dict[str, Any]:
    return {"type": "object", "properties": properties}


def _list(items: Any) -> dict[str, Any]:
    return {"type": "array", "items": items}


_TIME = {"title": "time", **_object(sec={"type": "integer"}, nsec={"type": "integer"})}
_POINT = _object(x=_NUMBER, y=_NUMBER)
_COLOUR = _object(r=_NUMBER, g=_NUMBER, b=_NUMBER, a=_NUMBER)
_OUTLINE = _object(
    timestamp=_TIME, type={"type": "integer"}, points=_list(_POINT), outline_color=_COLOUR, outline_colors=_list(_COLOUR),
    fill_color=_COLOUR, thickness=_NUMBER,
)  # fmt: skip
_LABEL = _object(timestamp=_TIME, position=_POINT, text=_TEXT, font_size=_NUMBER, text_color=_COLOUR, background_color=_COLOUR)
_BOX = _object(**dict.fromkeys((*_INTEGERS, *_NUMBERS), _NUMBER), counted={"type": "boolean"})
_SCHEMAS = {
    _BOXES: (
        "evcot.Boxes",
        _object(timestamp=_TIME, t_us={"type": "integer"}, sensor=_list({"type": "integer"}), boxes=_list(_BOX)),
    ),
    "/tracks/annotations": (
        "foxglove.ImageAnnotations",
        _object(circles=_list(_object()), points=_list(_OUTLINE), texts=_list(_LABEL)),
    ),
    "/sensor": (
        "foxglove.CompressedImage",
        _object(timestamp=_TIME, frame_id=_TEXT, data={**_TEXT, "contentEncoding": "base64"}, format=_TEXT),
    ),
}


def _plotted(value: str) -> dict[str, Any]:
    return {"value": value, "enabled": True, "timestampMethod": "receiveTime"}


# Panels of a layout as Foxglove exports it: `Kind!id`.
_LAYOUT = {
    "configById": {
        "Image!evcot": {
            "foxglovePanelTitle": "Tracks",
            "imageMode": {"imageTopic": "/sensor", "annotations": {"/tracks/annotations": {"visible": True}}},
        },
        "Table!evcot": {"foxglovePanelTitle": "Boxes", "topicPath": f"{_BOXES}.boxes"},
        "Plot!evcot": {
            "foxglovePanelTitle": "Upper left corner of each box, px",
            "paths": [_plotted(f"{_BOXES}.boxes[:].{name}") for name in ("left", "top")],
            "xAxisVal": "timestamp", "isSynced": True, "showLegend": True,
        },
    },
    "globalVariables": {},
    "userNodes": {},
    "playbackConfig": {"speed": 1},
    "layout": {
        "direction": "row", "splitPercentage": 65, "first": "Image!evcot",
        "second": {"direction": "column", "first": "Table!evcot", "second": "Plot!evcot"},
    },
}  # fmt: skip


def layout_for(path: Path) -> Path | None:
    """Where the layout of an MCAP file is written: a.layout.json for a.mcap, if nothing of that name exists; else None.

    A pipe, and a file without that suffix, has none.
    """
    is_file = path.suffix.lower() == FoxgloveBoxes.SUFFIX and (path.is_file() or not path.exists())
    layout = path.with_suffix(".layout.json")
    return layout if is_file and not os.path.lexists(layout) else None


class FoxgloveBoxes:
    """Tracks for Foxglove."""

    NAME, SUFFIX, TITLE = "mcap", ".mcap", "MCAP for Foxglove"

    @staticmethod
    def read(path: Path, clock: FrameClock) -> Boxes:
        """See `BoxFormat`; the file has times, so the clock is not needed."""
        note_input(path)
        times_us: list[int] = []
        rows: list[tuple[Any, ...]] = []
        sensor: tuple[int, int] | None = None
        for number, message in enumerate(_messages(path)):
            place = f"{path}: message {number}"
            if number >= FRAME_MAX:
                raise TrackLogError(f"{place}: must be at most {FRAME_MAX}")
            t_us, sensor, boxes = _parsed(place, message)
            if times_us and t_us <= times_us[-1]:
                raise TrackLogError(f"{place}: t_us = {t_us} follows {times_us[-1]}: must ascend")
            rows += [(number, *values) for values in boxes]
            times_us.append(t_us)
        table = np.zeros(len(rows), BOX)
        for i, name in enumerate(("instant", *_INTEGERS, *_NUMBERS, "counted")):
            table[name] = [row[i] for row in rows]
        return Boxes(np.array(times_us, np.int64), table, sensor)

    @staticmethod
    def write_layout(path: Path) -> None:
        """Write the layout to a new file.

        Raises:
            OutputError: the file exists, or cannot be written.
        """
        with written_aside(path) as file:
            file.write((json.dumps(_LAYOUT, indent=2) + "\n").encode())

    @staticmethod
    def write(file: BinaryIO, path: Path, boxes: Boxes, clock: FrameClock) -> None:
        """See `BoxFormat`."""
        _mcap(path)
        from mcap.writer import Writer

        times_us = boxes.instants_us
        if len(times_us) and not 0 <= times_us.min() <= times_us.max() <= _TIME_MAX_US:
            at_us = next(t for t in times_us.tolist() if not 0 <= t <= _TIME_MAX_US)
            raise TrackLogError(f"{path}: t = {at_us} us: must be from 0 to {_TIME_MAX_US}, a time of MCAP")
        sensor = boxes.sensor or _smallest(boxes.rows)
        if max(sensor) > _SIDE_MAX:
            raise TrackLogError(f"{path}: boxes reach to {sensor[0]}x{sensor[1]} px: must lie within {_SIDE_MAX}x{_SIDE_MAX}")
        picture = _picture(sensor)
        writer = Writer(file)
        writer.start(library="evcot")
        channels = {
            topic: writer.register_channel(
                topic, "json", writer.register_schema(name, "jsonschema", json.dumps(schema).encode())
            )
            for topic, (name, schema) in _SCHEMAS.items()
        }
        rows = boxes.rows
        ends = np.searchsorted(rows["instant"], np.arange(len(times_us) + 1))
        for i, t_us in enumerate(times_us.tolist()):
            time = {"sec": t_us // 1_000_000, "nsec": t_us % 1_000_000 * 1_000}
            here = rows[ends[i] : ends[i + 1]]
            told = {
                _BOXES: {
                    "timestamp": time, "t_us": t_us, "sensor": list(boxes.sensor or ()), "boxes": [_told(row) for row in here]
                },
                "/tracks/annotations": _annotations(here, time),
                "/sensor": {"timestamp": time, "frame_id": "sensor", "data": picture, "format": "png"},
            }  # fmt: skip
            for topic, message in told.items():
                writer.add_message(channels[topic], 1_000 * t_us, json.dumps(message).encode(), 1_000 * t_us, i)
        writer.finish()


def _mcap(path: Path) -> Any:
    try:
        import mcap.stream_reader
    except ImportError as error:
        raise TrackLogError(f"{path}: {_NEEDED}") from error
    return mcap


def _told(row: np.void) -> dict[str, Any]:
    told: dict[str, Any] = {name: int(row[name]) for name in _INTEGERS} | {name: float(row[name]) for name in _NUMBERS}
    return told | {"counted": bool(row["counted"])}


def _annotations(rows: NDArray[np.void], time: dict[str, int]) -> dict[str, Any]:
    outlines, labels = [], []
    for row in rows:
        left, top = float(row["left"]) + _EDGE, float(row["top"]) + _EDGE
        right, bottom = left + float(row["width"]), top + float(row["height"])
        colour = {**dict(zip("rgb", COLOURS[int(row["id"]) % len(COLOURS)], strict=True)), "a": 1.0}
        corners = [{"x": x, "y": y} for x, y in ((left, top), (right, top), (right, bottom), (left, bottom))]
        outlines.append({
            "timestamp": time, "type": _LINE_LOOP, "points": corners, "outline_color": colour, "outline_colors": [],
            "fill_color": {**colour, "a": 0.0}, "thickness": 1.0,
        })  # fmt: skip
        labels.append({
            "timestamp": time, "position": corners[0], "text": str(int(row["id"])), "font_size": 8.0, "text_color": colour,
            "background_color": {"r": 0.0, "g": 0.0, "b": 0.0, "a": 0.5},
        })  # fmt: skip
    return {"circles": [], "points": outlines, "texts": labels}


def _smallest(rows: NDArray[np.void]) -> tuple[int, int]:
    """(width, height) of the smallest sensor that holds all boxes."""
    sides = []
    for low, side in (("left", "width"), ("top", "height")):
        reach = float((rows[low] + rows[side]).max()) + _EDGE if len(rows) else 1.0
        sides.append(max(1, math.ceil(reach)))
    return sides[0], sides[1]


def _picture(sensor: tuple[int, int]) -> str:
    from PIL import Image

    made = io.BytesIO()
    Image.new("L", sensor).save(made, "PNG")
    return base64.b64encode(made.getvalue()).decode()


def _messages(path: Path) -> Iterator[bytes]:
    """The messages of evcot's own topic, in order."""
    mcap = _mcap(path)
    from mcap.exceptions import McapError
    from mcap.records import Channel, Chunk, Message
    from zstandard import ZstdError

    own: set[int] = set()
    found = False
    try:
        with path.open("rb") as file:
            for chunk in mcap.stream_reader.StreamReader(file, emit_chunks=True, record_size_limit=_CHUNK_MAX).records:
                for record in _unpacked(path, chunk) if isinstance(chunk, Chunk) else (chunk,):
                    if isinstance(record, Channel) and record.topic == _BOXES and record.message_encoding == "json":
                        own.add(record.id)
                        found = True
                    elif isinstance(record, Message) and record.channel_id in own:
                        yield record.data
    except OSError as error:
        raise TrackLogError(f"{path}: cannot be read: {error.strerror or error}") from error
    except (McapError, ZstdError, struct.error, ValueError, OverflowError, MemoryError) as error:
        if isinstance(error, TrackLogError):
            raise
        raise TrackLogError(f"{path}: is damaged, or no MCAP file: {' '.join(str(error).split()) or 'ends early'}") from error
    if not found:
        raise TrackLogError(f"{path}: has no topic {_BOXES} in JSON: must be a file that evcot wrote")


def _unpacked(path: Path, chunk: Any) -> list[Any]:
    """The records of a chunk, whose size is checked before anything is allocated."""
    import zstandard
    from mcap.stream_reader import breakup_chunk

    if chunk.compression not in ("", "zstd"):
        raise TrackLogError(f"{path}: compression {chunk.compression!r}: must be zstd, or none, as evcot writes it")
    size = zstandard.frame_content_size(chunk.data) if chunk.compression else len(chunk.data)
    if not 0 <= size == chunk.uncompressed_size <= _CHUNK_MAX:
        raise TrackLogError(f"{path}: chunk of {chunk.uncompressed_size} bytes: must be at most {_CHUNK_MAX}, as its data say")
    records: list[Any] = breakup_chunk(chunk, validate_crc=True)
    return records


def _parsed(place: str, message: bytes) -> tuple[int, tuple[int, int] | None, list[list[Any]]]:
    """Time, sensor and boxes of a message."""
    try:
        told = json.loads(message)
        t_us, sensor, boxes = told["t_us"], told["sensor"], told["boxes"]
        if type(t_us) is not int or not 0 <= t_us <= _TIME_MAX_US:
            raise TrackLogError(f"{place}: t_us = {t_us!r}: must be an integer from 0 to {_TIME_MAX_US}")
        if sensor and not (len(sensor) == 2 and all(type(side) is int and 0 < side <= _SIDE_MAX for side in sensor)):
            raise TrackLogError(f"{place}: sensor = {sensor!r}: must be width and height, each from 1 to {_SIDE_MAX}")
        rows = []
        for box in boxes:
            whole = [box[name] for name in _INTEGERS]
            if not all(type(value) is int and -(2**63) <= value < 2**63 for value in whole):
                raise TrackLogError(f"{place}: id, class_id = {whole}: must be integers")
            rows.append([*whole, *(float(box[name]) for name in _NUMBERS), bool(box["counted"])])
    except (TypeError, KeyError, RecursionError, OverflowError, UnicodeDecodeError, json.JSONDecodeError) as error:
        fields = ", ".join((*_INTEGERS, *_NUMBERS, "counted"))
        raise TrackLogError(f"{place}: must hold t_us, sensor, and boxes, each with {fields}") from error
    except ValueError as error:
        if isinstance(error, TrackLogError):
            raise
        raise TrackLogError(f"{place}: {error}: must be numbers") from error
    return t_us, (sensor[0], sensor[1]) if sensor else None, rows

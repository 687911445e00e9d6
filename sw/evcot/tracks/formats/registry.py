# SPDX-License-Identifier: Apache-2.0
"""All formats of boxes by name, and by the ends of files' names."""

from __future__ import annotations

from pathlib import Path

from ...errors import ConfigError
from ...outputs import written_aside
from .base import Boxes, BoxFormat, FrameClock, check_boxes
from .coco import CocoBoxes
from .foxglove import FoxgloveBoxes, layout_for
from .mot import MotDetections, MotResult, MotTruth
from .prophesee import PropheseeBoxes

__all__ = ["FORMATS", "box_format", "is_boxes", "read_boxes", "write_boxes"]

# Of those with one suffix, the first is the one that a file's name stands for.
FORMATS: dict[str, type[BoxFormat]] = {
    format.NAME: format for format in (MotResult, MotTruth, MotDetections, CocoBoxes, PropheseeBoxes, FoxgloveBoxes)
}


def is_boxes(path: Path | str) -> bool:
    """Whether a file's name is that of a file of boxes."""
    return Path(path).suffix.lower() in {format.SUFFIX for format in FORMATS.values()}


def box_format(path: Path | str, name: str | None = None) -> type[BoxFormat]:
    """The format of a name in `FORMATS` or, without one, of a file's name.

    Raises:
        ConfigError: no such format, or a name that ends as those of no format.
    """
    if name is not None:
        if name not in FORMATS:
            raise ConfigError(f"format {name!r}: must be one of {', '.join(FORMATS)}")
        return FORMATS[name]
    found = next((format for format in FORMATS.values() if Path(path).suffix.lower() == format.SUFFIX), None)
    if found is None:
        ends = ", ".join(dict.fromkeys(format.SUFFIX for format in FORMATS.values()))
        raise ConfigError(f"{path}: must end in {ends}, or its format must be given: {', '.join(FORMATS)}")
    return found


def read_boxes(path: Path | str, clock: FrameClock | None = None, name: str | None = None) -> Boxes:
    """Read a file of boxes.

    Args:
        clock: the times of frames, for formats that number frames.
        name: of a format in `FORMATS`; None: chosen by the file's name.

    Raises:
        TrackLogError: the file cannot be read, or holds an invalid value: names file, place, value and rule.
        ConfigError: an unknown format, or frames without a clock.
    """
    path = Path(path)
    return check_boxes(path, box_format(path, name).read(path, clock or FrameClock()))


def write_boxes(
    path: Path | str, boxes: Boxes, clock: FrameClock | None = None, name: str | None = None, *, force: bool = False
) -> None:
    """Write boxes to a file; next to an MCAP file also a layout for Foxglove, unless its name is taken.

    Args:
        clock, name: as for `read_boxes`.
        force: replace a file that exists.

    Raises:
        OutputError: the file exists, or cannot be written.
        TrackLogError: a time at which there is no frame, or an id that the format cannot hold.
        ConfigError: as for `read_boxes`.
    """
    path = Path(path)
    chosen = box_format(path, name)
    layout = layout_for(path) if chosen is FoxgloveBoxes else None
    with written_aside(path, force=force) as file:
        chosen.write(file, path, boxes, clock or FrameClock())
        if layout is not None:
            FoxgloveBoxes.write_layout(layout)

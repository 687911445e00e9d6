# SPDX-License-Identifier: Apache-2.0
"""Picture of recordings side by side, a few milliseconds of each.

    python -m evcot.scenes.snapshot real.aedat4 simulated.aedat4 -o both.png --at 1.0

writes a PNG of 20 ms of both, 1 s after their first events: ON events red, OFF events blue.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from ..errors import EvcotError
from ..events import Recording
from ..outputs import written_aside
from ..recordings.files import read_recording

__all__ = ["main", "snapshot"]

_ON, _OFF, _PAPER, _GAP = (200, 60, 0), (0, 90, 180), (255, 255, 255), (128, 128, 128)
_GAP_PX = 4
_COLUMNS = 3


def snapshot(recording: Recording) -> NDArray[np.uint8]:
    """(height, width, 3) sRGB: each pixel in the colour of its last event."""
    picture = np.full((recording.height, recording.width, 3), _PAPER, np.uint8)
    events = recording.events
    last = np.zeros(picture.shape[:2], np.int64)
    np.maximum.at(last, (events.y, events.x), np.arange(1, len(events) + 1))
    seen = last > 0
    picture[seen] = np.where(events.p[last[seen] - 1, None] == 1, np.array(_ON, np.uint8), np.array(_OFF, np.uint8))
    return picture


def _mounted(pictures: Sequence[NDArray[np.uint8]]) -> Image.Image:
    """Pictures in rows of up to three."""
    across, down = max(picture.shape[1] for picture in pictures), max(picture.shape[0] for picture in pictures)
    columns = min(len(pictures), _COLUMNS)
    rows = -(-len(pictures) // columns)
    size = columns * (across + _GAP_PX) - _GAP_PX, rows * (down + _GAP_PX) - _GAP_PX
    sheet = Image.new("RGB", size, _GAP)
    for i, picture in enumerate(pictures):
        sheet.paste(Image.fromarray(picture), (i % columns * (across + _GAP_PX), i // columns * (down + _GAP_PX)))
    return sheet


def main(arguments: Sequence[str]) -> int:
    """Write the picture; returns the exit code."""
    parser = argparse.ArgumentParser(prog="python -m evcot.scenes.snapshot", description="recordings side by side")
    parser.add_argument("recordings", nargs="+", type=Path, metavar="RECORDING")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="PNG")
    parser.add_argument("--at", type=float, default=1.0, metavar="S", help="seconds after the first event (default: 1)")
    parser.add_argument("--ms", type=float, default=20.0, help="how long (default: 20)")
    options = parser.parse_args(arguments)
    from_us = round(options.at * 1e6)
    to_us = from_us + round(options.ms * 1e3)
    try:
        pictures = [snapshot(read_recording(path, from_us=from_us, to_us=to_us)) for path in options.recordings]
        with written_aside(options.output) as file:
            _mounted(pictures).quantize(8).save(file, format="png", optimize=True)
    except EvcotError as error:
        print(f"snapshot: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

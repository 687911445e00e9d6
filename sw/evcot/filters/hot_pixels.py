# SPDX-License-Identifier: Apache-2.0
"""Hot pixels: detected by their activity, and stored in a text file.

A pixel is hot when it is much more active than most pixels, much more active than its neighbours, and active all the time:

- it has `OVER_MEDIAN` times as many events as the median of all pixels with any events;
- it has `OVER_NEIGHBOURS` times as many as the second most active of its 8 neighbours: a busy road or a fast object covers
  adjacent pixels, a defect only one or two;
- it has events in at least `SHARE_MIN` of all time slices of `SLICE_US` with any events: a glint does not last.

A threshold on the count alone, such as the mean plus some standard deviations over all pixels, fails in both directions: a
stationary object exceeds it, and one very hot pixel raises it above all others.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .._numba_private import njit
from ..errors import ConfigError
from ..events import Events
from ..outputs import note_input, written_aside
from .base import per_pixel
from .contract import FilterShape

__all__ = [
    "OVER_MEDIAN",
    "OVER_NEIGHBOURS",
    "SHARE_MIN",
    "SLICE_US",
    "Pixels",
    "learn_hot_pixels",
    "load_hot_pixels",
    "save_hot_pixels",
]

OVER_MEDIAN = 20
OVER_NEIGHBOURS = 5
SHARE_MIN = 0.5
SLICE_US = 100_000

Pixels = tuple[tuple[int, int], ...]

_HEADER = re.compile(r"# hot pixels of a (\d{1,5})x(\d{1,5}) sensor")


def learn_hot_pixels(events: Events | Iterable[Events], sensor: tuple[int, int]) -> Pixels:
    """Find the hot pixels of a recording: (x, y), most active first. About 15 ns per event.

    Args:
        events: a recording's events, in one piece or in blocks, in time order and on the sensor.
        sensor: (width, height) in pixels.

    Raises:
        ConfigError: the sensor has more pixels than filters support.
    """
    width, height = sensor
    shape = FilterShape(width, height)
    counts, slices, latest = (per_pixel(shape, value) for value in (0, 0, -1))
    total, current = 0, -1
    t0_us: int | None = None
    for block in [events] if isinstance(events, Events) else events:
        if not len(block):
            continue
        t0_us = int(block.t_us[0]) if t0_us is None else t0_us
        total, current = _count(block.t_us, block.x, block.y, t0_us, counts, slices, latest, total, current)
    active = counts[counts > 0]
    if not len(active):
        return ()
    hot = (
        (counts >= OVER_MEDIAN * np.median(active))
        & (counts >= OVER_NEIGHBOURS * _second_busiest_neighbour(counts))
        & (slices >= SHARE_MIN * total)
    )
    y, x = np.nonzero(hot)
    order = np.argsort(-counts[y, x], kind="stable")
    return tuple(zip(x[order].tolist(), y[order].tolist(), strict=True))


@njit(cache=True, nogil=True)
def _count(t_us, x, y, t0_us, counts, slices, latest, total, current):  # type: ignore[no-untyped-def]
    """Add a run of events to each pixel's count of events and of slices; `total` slices so far, the last being `current`."""
    for i in range(len(t_us)):
        now = (t_us[i] - t0_us) // SLICE_US
        total += now != current
        current = now
        counts[y[i], x[i]] += 1
        slices[y[i], x[i]] += latest[y[i], x[i]] != now
        latest[y[i], x[i]] = now
    return total, current


def _second_busiest_neighbour(counts: NDArray[np.int64]) -> NDArray[np.int64]:
    padded = np.pad(counts, 1)
    height, width = counts.shape
    first, second = np.zeros_like(counts), np.zeros_like(counts)
    for dy in range(3):
        for dx in range(3):
            if (dx, dy) != (1, 1):
                one = padded[dy : dy + height, dx : dx + width]
                second = np.maximum(second, np.minimum(first, one))
                first = np.maximum(first, one)
    return second


def save_hot_pixels(
    path: Path | str, pixels: Iterable[tuple[int, int]], sensor: tuple[int, int], *, force: bool = False
) -> None:
    """Write hot pixels as text: a line with the sensor size, then one `x y` per line.

    Args:
        force: replace an existing file.

    Raises:
        OutputError: the file exists, or cannot be written.
    """
    lines = [f"# hot pixels of a {sensor[0]}x{sensor[1]} sensor", *(f"{x} {y}" for x, y in pixels)]
    with written_aside(Path(path), force=force) as file:
        file.write(("\n".join(lines) + "\n").encode())


def load_hot_pixels(path: Path | str, sensor: tuple[int, int] | None = None) -> Pixels:
    """Read a file written by `save_hot_pixels` or by hand: one `x y` per line, `#` begins a comment.

    Args:
        sensor: (width, height) in pixels that the file must match, if it states one.

    Raises:
        ConfigError: the file cannot be read, is for another sensor, or has a line that is not a pixel of its sensor.
    """
    path = Path(path)
    note_input(path)
    pixels: dict[tuple[int, int], None] = {}
    meant = sensor
    try:
        if path.exists() and not path.is_file():
            raise ConfigError(f"{path}: is no file")
        with path.open(encoding="utf-8") as file:
            for number, line in enumerate(file, 1):
                where = f"{path}: line {number}"
                if header := _HEADER.fullmatch(line.strip()):
                    meant = int(header[1]), int(header[2])
                    if sensor is not None and sensor != meant:
                        raise ConfigError(
                            f"{where}: is for a {meant[0]}x{meant[1]} sensor: must be for {sensor[0]}x{sensor[1]}"
                        )
                elif text := line.partition("#")[0].strip():
                    pixels[_pixel(text, meant, where)] = None
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read: {error.strerror or error}") from error
    except UnicodeDecodeError as error:
        raise ConfigError(f"{path}: is not text: byte {error.start} is 0x{error.object[error.start]:02x}") from error
    return tuple(pixels)


def _pixel(text: str, sensor: tuple[int, int] | None, where: str) -> tuple[int, int]:
    found = re.fullmatch(r"(\d{1,5})\s+(\d{1,5})", text, re.ASCII)
    if found is None:
        raise ConfigError(f"{where}: {text[:40]!r}: must be two integers, x and y")
    x, y = int(found[1]), int(found[2])
    width, height = sensor or (65536, 65536)
    if x >= width or y >= height:
        raise ConfigError(f"{where}: pixel ({x}, {y}): must lie on the {width}x{height} sensor")
    return x, y

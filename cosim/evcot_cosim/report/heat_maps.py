# SPDX-License-Identifier: Apache-2.0
"""Heat maps: small pictures of the number of events per pixel."""

from __future__ import annotations

import base64
import io
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from evcot.tracks.log import DROPPED

from .material import Material

__all__ = ["CIVIDIS", "Heat", "heat_maps"]


CIVIDIS = base64.b64decode(  # 256 colours from dark to bright, red, green and blue
    "ACJNACNPACNQACRSACVUACZVACZXACdZAChbAChcACleACpgACpiACtkACxmACxnAC1pAC5rAC9tAC9vADBwADBwADFwADFwBDJwCDNwCzNwDjRwETVv"
    "FDZvFjZvGDdvGjhvHDhuHTluHzpuITtuIjtuJDxuJT1tJz1tKD5tKj9tKz9tLEBtLkFsL0JsMEJsMUNsMkRsNERsNUVsNkZsN0ZsOEdsOUhsOkhrO0lr"
    "PUprPktrP0trQExrQU1rQk1rQ05rRE9rRU9rRlBrR1FrSFFrSVJrSlNrS1RsTFRsTVVsTlZsTlZsT1dsUFhsUVhsUllsU1psVFpsVVttVlxtV11tWF1t"
    "WV5tWV9tWl9tW2BuXGFuXWFuXmJuX2NuYGRuYWRvYWVvYmZvY2ZvZGdvZWhwZmlwZ2lwaGpwaGtxaWtxamxxa21xbG1ybW5ybm9ybnBzb3BzcHFzcXJz"
    "cnN0c3N0dHR1dHV1dXV1dnZ2d3d2eHh2eXh3eXl3enp3e3t3fHt4fXx4fn14f314gH54gX94goB4g4B4hIF4hYJ4hYN4hoN4h4R4iIV4iYZ4ioZ4i4d4"
    "jIh4jYl4jol4j4p3kIt3kYx3kox3k413lI53lY93lo93l5B2mJF2mZJ2mpN2m5N2nJR2nZV1npZ1n5Z1oJd1oZh0opl0o5p0pJp0pZtzppxzp51zqJ5z"
    "qZ5yqp9yq6ByrKFxraJxrqJxr6NwsKRwsaVwsqZvs6ZvtKdvtahutqlut6ptuKttuattuqxsu61svK5rva9rvrBqv7BqwbFpwrJpw7NoxLRoxbVnxrVn"
    "x7ZmyLdlybhlyrlky7pkzLtjzbxizrxiz71h0L5g0r9g08Bf1MFe1cJe1sNd18Nc2MRb2cVa2sZa28dZ3MhY3slX38pW4MtV4cxU4sxT481S5M5R5c9Q"
    "5tBP6NFO6dJN6tNM69RL7NVK7dZI7tdH79hG8dlE8tpD89pC9NtA9dw/9t09+N47+d86+uA4++E2/eI0/eMz/eU0/eY2/ec3"
)


_CELLS_MAX = 512  # per side: of larger sensors several pixels make one cell
_RUN = 1 << 20  # events counted at a time
_FULL = 0.995  # of the cells with events: busier ones are as bright as this one
_HOT = 4  # times `full`: a busier cell is named


@dataclass(frozen=True)
class Heat:
    """One map.

    Attributes:
        title: what is counted.
        events: total number of events.
        full: number from which on a cell is brightest: all but a few hundredths of the cells that have events are darker.
        most: number on the busiest cell, whose first pixel is `busiest`, (x, y).
        width, height: in cells; cell_px: pixels to a cell, per side.
        source: the picture as a data URL, brightness logarithmic.
    """

    title: str
    events: int
    full: int
    most: int
    busiest: tuple[int, int]
    width: int
    height: int
    cell_px: int
    source: str

    @property
    def hot(self) -> bool:
        """Whether a single cell stands out so far that the scale leaves it out."""
        return self.most > _HOT * self.full


def heat_maps(material: Material) -> list[Heat]:
    """Maps of all events, of those removed by filters, and of those that no cluster of a side took. Sides whose filters removed
    the same events share a map."""
    maps = [_heat(material, "All events", None)]
    removed: list[tuple[NDArray[np.bool_], list[str]]] = []
    for side in material.sides:
        dropped = side.log.owner == DROPPED
        same = next((names for seen, names in removed if np.array_equal(seen, dropped)), None)
        if same is not None:
            same.append(side.name)
        elif dropped.any():
            removed.append((dropped, [side.name]))
    maps += [_heat(material, f"Removed by filters: {', '.join(names)}", dropped) for dropped, names in removed]
    maps += [_heat(material, f"In no track: {side.name}", side.log.owner == -1) for side in material.sides]
    return maps


def _heat(material: Material, title: str, chosen: NDArray[np.bool_] | None) -> Heat:
    recording, events = material.recording, material.events
    cell_px = -(-max(recording.width, recording.height) // _CELLS_MAX)
    width, height = -(-recording.width // cell_px), -(-recording.height // cell_px)
    counts = np.zeros(width * height, np.int64)
    for begin in range(0, len(events), _RUN):
        run = slice(begin, begin + _RUN)
        cell = (events.y[run] // cell_px).astype(np.int64) * width + events.x[run] // cell_px
        counts += np.bincount(cell if chosen is None else cell[chosen[run]], minlength=width * height)
    at = int(counts.argmax())
    busy = counts[counts > 0]
    full = int(np.quantile(busy, _FULL, method="higher")) if len(busy) else 1
    level = np.minimum(np.log1p(counts) * (255 / np.log1p(full)), 255)
    return Heat(
        title, int(counts.sum()), full, int(counts[at]), (at % width * cell_px, at // width * cell_px),
        width, height, cell_px, _png(level.astype(np.uint8).reshape(height, width)),
    )  # fmt: skip


def _png(levels: NDArray[np.uint8]) -> str:
    image = Image.fromarray(levels)
    image.putpalette(CIVIDIS)
    file = io.BytesIO()
    image.save(file, "PNG")
    return f"data:image/png;base64,{base64.b64encode(file.getvalue()).decode()}"

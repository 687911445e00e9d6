# SPDX-License-Identifier: Apache-2.0
"""Object detection in one frame: image of the pixels with events, median filter, connected components, bounding boxes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ...errors import RecordingError
from ...events import Events
from .config import FrameConfig
from .kernel import DETECTION

__all__ = ["Image", "detect", "fired"]

_PIXELS_MAX = 1 << 26
_EIGHT = np.ones((3, 3), bool)

Image = NDArray[np.bool_]


def fired(events: Events, margin_px: int) -> tuple[Image, int, int]:
    """The pixels with events, as the smallest image that holds them and a margin; and x, y of its first pixel.

    Raises:
        RecordingError: the image would have more than 2^26 pixels.
    """
    left, top = int(events.x.min()) - margin_px, int(events.y.min()) - margin_px
    width, height = int(events.x.max()) + margin_px + 1 - left, int(events.y.max()) + margin_px + 1 - top
    if width * height > _PIXELS_MAX:
        raise RecordingError(f"frame from t = {events.t_us[0]} us: spans {width}x{height} pixels: must be at most 2^26 in all")
    image = np.zeros((height, width), bool)
    image[events.y.astype(np.int64) - top, events.x.astype(np.int64) - left] = True
    return image, left, top


def detect(events: Events, config: FrameConfig) -> NDArray[np.void]:
    """Detect the objects in one or more events of a frame: (k,) of dtype `DETECTION`.

    The median filter keeps a pixel if most of the square around it is set. Components are 8-connected, and pieces at most
    `link_px` apart in x and in y are joined. An object's centre, width and height are those of its box, its radius is half the
    mean side; `n` is its number of pixels.
    """
    image, left, top = fired(events, config.median_px // 2 + config.link_px)
    clean = _median(image, config.median_px)
    y, x = np.nonzero(clean)
    labels, count = ndimage.label(_grown(clean, config.link_px), _EIGHT)
    of_pixel = labels[y, x]
    area = np.bincount(of_pixel, minlength=count + 1)
    good = (area >= config.area_min_px) & (area <= config.area_max_px)
    order = np.argsort(of_pixel, kind="stable")
    order = order[good[of_pixel[order]]]
    x, y, of_pixel = x[order], y[order], of_pixel[order]
    found = np.zeros(int(np.count_nonzero(good)), DETECTION)
    if not len(found):
        return found
    first = np.flatnonzero(np.append(True, of_pixel[1:] != of_pixel[:-1]))
    x0, x1 = np.minimum.reduceat(x, first), np.maximum.reduceat(x, first)
    y0, y1 = np.minimum.reduceat(y, first), np.maximum.reduceat(y, first)
    found["x"], found["y"] = left + (x0 + x1) / 2, top + (y0 + y1) / 2
    found["width"], found["height"] = x1 - x0 + 1, y1 - y0 + 1
    found["radius"] = (found["width"] + found["height"]) / 4
    found["after_us"] = float((events.t_us - events.t_us[0]).mean())
    found["n"] = area[good]
    return found


def _median(image: Image, side_px: int) -> Image:
    """Median filter over a square; for a binary image, a majority vote, computed from running sums."""
    if side_px == 1:
        return image
    kernel = np.ones(side_px, np.int32)
    count = ndimage.convolve1d(image.astype(np.int32), kernel, 0, mode="constant")
    count = ndimage.convolve1d(count, kernel, 1, mode="constant")
    return np.asarray(2 * count > side_px * side_px, np.bool_)


def _grown(image: Image, gap_px: int) -> Image:
    """Dilate the image so that pieces at most `gap_px` apart touch."""
    if gap_px == 0:
        return image
    # Each piece grows right and down by half the gap, left and up by the rest, so that exactly the gap is closed.
    return np.asarray(ndimage.maximum_filter(image.view(np.uint8), gap_px + 1, mode="constant").view(np.bool_))

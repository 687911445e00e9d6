# SPDX-License-Identifier: Apache-2.0
"""The frame pipeline: pixels with events in `frame_us`, median filter, connected components, bounding boxes, tracks.

In the log `radius` is half the mean side of the object's box, `n_ev` its pixels in the frame, `support` those in all frames.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from evcot.errors import ConfigError, RecordingError
from evcot.events import Events
from evcot.ranges import Range, check_ranges, ranges_of, setting
from evcot.trackers.detections import DETECTION, DetectionTracker, IdentityConfig

__all__ = ["FRAME_RANGES", "PRESETS", "FrameConfig", "FrameTracker", "candidate_us", "detect"]


@dataclass(frozen=True)
class FrameConfig(IdentityConfig):
    """Settings of the frame pipeline.

    Raises:
        ConfigError: a value outside its range, or a median filter of even side.
    """

    frame_us: int = setting(20_000, 1, 10**9, "length of a frame")
    median_px: int = setting(3, 1, 15, "side of the median filter's square, odd; 1 for none")
    link_px: int = setting(4, 0, 255, "widest gap, in pixels without an event, across which components still belong together")
    area_min_px: int = setting(12, 1, 2**31, "fewest pixels of an object")

    def __post_init__(self) -> None:
        check_ranges("frames", self)
        if self.median_px % 2 == 0:
            raise ConfigError(f"frames.median_px = {self.median_px}: must be odd, so that the square has a middle")


FRAME_RANGES: dict[str, Range] = ranges_of(FrameConfig)


PRESETS: dict[str, FrameConfig] = {
    # Contours are one or two pixels wide, which a median filter would remove.
    "discs": FrameConfig(visible_hits=4, frame_us=5_000, median_px=1, link_px=6, area_min_px=12),
    "traffic": FrameConfig(gate_px=30.0, smoothing_us=30_000, frame_us=20_000, median_px=3, link_px=18, area_min_px=20),
}


_PIXELS_MAX = 1 << 26
_EIGHT = np.ones((3, 3), bool)


def candidate_us(frame_us: int) -> int:
    """Silence after which a new object is dropped: two and a half frames, in microseconds, at least 20 ms."""
    return max(20_000, 5 * frame_us // 2)


class FrameTracker(DetectionTracker):
    """The frame pipeline as a stream; frames count from the first event, and frames without events are skipped."""

    def __init__(self, config: FrameConfig) -> None:
        super().__init__(config, candidate_us(config.frame_us))
        self.config = config
        self._first_us: int | None = None

    def frame_ends(self, t_us: NDArray[np.int64]) -> NDArray[np.int64]:
        """See `DetectionTracker.frame_ends`."""
        if self._first_us is None:
            self._first_us = int(t_us[0])
        return np.flatnonzero(np.diff((t_us - self._first_us) // self.config.frame_us)) + 1

    def detect(self, events: Events) -> NDArray[np.void]:
        """See `detect`."""
        return detect(events, self.config)


def detect(events: Events, config: FrameConfig) -> NDArray[np.void]:
    """Detect the objects in one or more events of a frame: (d,) of dtype `DETECTION`.

    The median filter keeps a pixel if most of the square around it is set. Components are 8-connected, and pieces at most
    `link_px` apart in x and in y are joined. An object's centre, width and height are those of its box, its radius is half the
    mean side; `n` is its number of pixels.

    Raises:
        RecordingError: the events span more than 2^26 pixels.
    """
    margin_px = config.median_px // 2 + config.link_px
    left, top = int(events.x.min()) - margin_px, int(events.y.min()) - margin_px
    width, height = int(events.x.max()) + margin_px + 1 - left, int(events.y.max()) + margin_px + 1 - top
    if width * height > _PIXELS_MAX:
        raise RecordingError(f"frame from t = {events.t_us[0]} us: spans {width}x{height} pixels: must be at most 2^26 in all")
    image = np.zeros((height, width), np.uint8)
    image[events.y.astype(np.int64) - top, events.x.astype(np.int64) - left] = 1
    if config.median_px > 1:
        image = ndimage.median_filter(image, config.median_px, mode="constant")
    # Each piece grows right and down by half the gap, left and up by the rest, so that exactly the gap is closed.
    labels, _ = ndimage.label(ndimage.maximum_filter(image, config.link_px + 1, mode="constant"), _EIGHT)
    labels[image == 0] = 0
    area = np.bincount(labels[image > 0])
    after_us = float((events.t_us - events.t_us[0]).mean())
    found = []
    for label, box in enumerate(ndimage.find_objects(labels), 1):
        if area[label] >= config.area_min_px:
            (y0, y1), (x0, x1) = ((side.start, side.stop) for side in box)
            centre = left + (x0 + x1 - 1) / 2, top + (y0 + y1 - 1) / 2
            found.append((*centre, (x1 - x0 + y1 - y0) / 4, x1 - x0, y1 - y0, after_us, area[label]))
    return np.array(found, DETECTION)

# SPDX-License-Identifier: Apache-2.0
"""The classical tracker of objects in frames: events of `frame_us` are accumulated, filtered, grouped and followed.

`detection` says what an object in a frame is, `identity` which objects of several frames are one.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...events import Events, Recording
from ...tracks.log import TrackLog
from ...tracks.tracking import track_recording
from .config import FrameConfig
from .detection import detect
from .framing import Framing
from .kernel import DETECTION
from .stream import DetectionTracker

__all__ = ["FrameTracker", "track"]


class FrameTracker(DetectionTracker):
    """The frame pipeline as a stream; frames count from the first event."""

    def __init__(self, config: FrameConfig) -> None:
        self.config = config
        super().__init__(config, Framing(config.frame_us), self._objects)

    def _objects(self, events: Events, frames: NDArray[np.void]) -> NDArray[np.void]:
        parts = [detect(events[frame["begin"] : frame["end"]], self.config) for frame in frames]
        frames["found_end"] = np.cumsum([len(part) for part in parts])
        frames["found"][1:] = frames["found_end"][:-1]
        return np.concatenate([np.empty(0, DETECTION), *parts])


def track(recording: Recording, config: FrameConfig, keep: NDArray[np.bool_] | None = None) -> TrackLog:
    """Run the frame pipeline over a recording, or over the events in it that filters let stay.

    Args:
        keep: (n,) bool, which events the tracker sees; None: all. The log numbers events as the recording does.

    In the log `radius` is half the mean side of the object's box, `n_ev` its pixels in the frame, and `support` those in all
    frames.
    """
    return track_recording("frames", FrameTracker(config), recording, keep)

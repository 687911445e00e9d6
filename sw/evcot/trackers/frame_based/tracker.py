# SPDX-License-Identifier: Apache-2.0
"""The classical frame-based tracker: events of `frame_us` are accumulated, filtered, grouped and tracked.

`detection` finds the objects in a frame, `identity` tracks them across frames.
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
    """Run the frame pipeline over a recording, or over a selection of its events.

    Args:
        keep: (n,) bool, mask of the events that the tracker sees; None for all. Event indices in the log are the recording's.

    In the log `radius` is half the mean side of the object's box, `n_ev` its pixels in the frame, and `support` those in all
    frames.
    """
    return track_recording("frames", FrameTracker(config), recording, keep)

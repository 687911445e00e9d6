# SPDX-License-Identifier: Apache-2.0
"""The registry of trackers by name, with their presets, behind one interface."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from ..filters.config import FilterConfig
from ..filters.run import filtered
from ..hardware.cot import CotTracker
from ..recordings.formats.source import Sensor
from ..tracks.tracking import FilteredTracker, Tracker
from . import presets as runs
from .config import RunConfig
from .frame_based import presets as frames
from .frame_based.tracker import FrameTracker
from .kalman import presets as kalman
from .kalman.tracker import KalmanTracker
from .mean_shift import presets as mean_shift
from .mean_shift.tracker import MeanShiftTracker
from .rct import presets as rct
from .rct.tracker import RctTracker

__all__ = ["ENGINES", "Engine"]

Start = Callable[[Any, FilterConfig, Sensor], Tracker]


@dataclass(frozen=True)
class Engine:
    """A registered tracker.

    Attributes:
        title: display name.
        presets: name -> settings; the first is the default.
        start: creates a tracker from settings, filters in front of it, and the sensor.
        filters: name of a preset -> the filters that belong to it.
    """

    title: str
    presets: Mapping[str, Any]
    start: Start
    filters: Mapping[str, FilterConfig] = field(default_factory=dict)


def _software(make: Callable[[Any, int, int], Tracker]) -> Start:
    """Make the `start` of a software tracker: filters are put in front only if any is enabled."""

    def start(settings: Any, filters: FilterConfig, sensor: Sensor) -> Tracker:
        tracker = make(settings, *sensor)
        return FilteredTracker(filtered((), filters, sensor).keep, tracker) if filters.enabled else tracker

    return start


def _hardware(run: RunConfig, filters: FilterConfig, sensor: Sensor) -> Tracker:
    """Create the golden model, which contains its filters, like the hardware."""
    return CotTracker(replace(runs.fit(run, *sensor), filters=filters).hardware(*sensor))


ENGINES: dict[str, Engine] = {
    "rct": Engine("Rectangular Cluster Tracker", rct.PRESETS, _software(RctTracker), rct.FILTERS),
    "kalman": Engine("extended objects by Kalman filters", kalman.PRESETS, _software(KalmanTracker)),
    "mean-shift": Engine("mean shift on packets of events", mean_shift.PRESETS, _software(lambda s, *_: MeanShiftTracker(s))),
    "frames": Engine("connected components of frames", frames.PRESETS, _software(lambda s, *_: FrameTracker(s))),
    "cot": Engine(
        "golden model of the hardware", runs.PRESETS, _hardware, {name: run.filters for name, run in runs.PRESETS.items()}
    ),
}

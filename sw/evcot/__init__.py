# SPDX-License-Identifier: Apache-2.0
"""Event-camera object tracking in software, and the golden model of the tracker in hardware.

These names are stable (docs/api.md); what is imported from deeper may change. They are loaded when they are first used.

Example:
    import evcot

    recording = evcot.read("drive.aedat4", to_us=2_000_000)
    log = evcot.track(recording)
    log.save_npz("log.npz")
    scene = evcot.simulate("highway", seed=1)
    print(evcot.evaluate(evcot.track(scene.recording), scene.truth).hota)
"""

from __future__ import annotations

from pathlib import Path as _Path
from typing import TYPE_CHECKING

from ._lazy import lazily as _lazily
from ._stale_kernels import forget_stale_kernels as _forget_stale_kernels
from ._stale_kernels import keep_kernels_in_cache as _keep_kernels_in_cache

if TYPE_CHECKING:
    from .api import evaluate, simulate, track
    from .api import filter_recording as filter
    from .errors import ConfigError, EvcotError, OutputError, RecordingError, RecordingWarning, ToolchainError, TrackLogError
    from .events import Events, Recording
    from .filters.config import FilterConfig
    from .hardware.config import CotConfig, SlotConfig
    from .hardware.contract import Shape
    from .metrics.rule import Rule, load_rule
    from .metrics.scores import Scores
    from .metrics.truth import GroundTruth, read_truth
    from .recordings.files import RecordingFile, open_recording, write_events
    from .recordings.files import read_recording as read
    from .recordings.files import write_recording as write
    from .scenes.registry import SCENES
    from .scenes.scene import Scene
    from .scenes.truth import Truth
    from .structured import EVENT_CD
    from .trackers.config import RunConfig
    from .trackers.engines import ENGINES, Engine
    from .trackers.presets import run_config
    from .tracks.formats.base import Boxes, FrameClock
    from .tracks.formats.of_log import boxes_of_log, log_of_boxes
    from .tracks.formats.registry import read_boxes, write_boxes
    from .tracks.log import DROPPED, TRACK, Kind, TrackLog
    from .tracks.tracking import Tracker

__all__ = [
    "DROPPED",
    "ENGINES",
    "EVENT_CD",
    "SCENES",
    "TRACK",
    "Boxes",
    "ConfigError",
    "CotConfig",
    "Engine",
    "EvcotError",
    "Events",
    "FilterConfig",
    "FrameClock",
    "GroundTruth",
    "Kind",
    "OutputError",
    "Recording",
    "RecordingError",
    "RecordingFile",
    "RecordingWarning",
    "Rule",
    "RunConfig",
    "Scene",
    "Scores",
    "Shape",
    "SlotConfig",
    "ToolchainError",
    "TrackLog",
    "TrackLogError",
    "Tracker",
    "Truth",
    "boxes_of_log",
    "evaluate",
    "filter",
    "load_rule",
    "log_of_boxes",
    "open_recording",
    "read",
    "read_boxes",
    "read_truth",
    "run_config",
    "simulate",
    "track",
    "write",
    "write_boxes",
    "write_events",
]

__version__ = "0.1.0"

_keep_kernels_in_cache()
_forget_stale_kernels(_Path(__file__).parent)

__getattr__, __dir__ = _lazily(
    __name__,
    {
        "api": ("evaluate", "filter_recording as filter", "simulate", "track"),
        "errors": (
            "ConfigError", "EvcotError", "OutputError", "RecordingError", "RecordingWarning", "ToolchainError", "TrackLogError",
        ),
        "events": ("Events", "Recording"),
        "filters.config": ("FilterConfig",),
        "hardware.config": ("CotConfig", "SlotConfig"),
        "hardware.contract": ("Shape",),
        "metrics.rule": ("Rule", "load_rule"),
        "metrics.scores": ("Scores",),
        "metrics.truth": ("GroundTruth", "read_truth"),
        "recordings.files": (
            "RecordingFile", "open_recording", "read_recording as read", "write_events", "write_recording as write",
        ),
        "scenes.registry": ("SCENES",),
        "scenes.scene": ("Scene",),
        "scenes.truth": ("Truth",),
        "structured": ("EVENT_CD",),
        "trackers.config": ("RunConfig",),
        "trackers.engines": ("ENGINES", "Engine"),
        "trackers.presets": ("run_config",),
        "tracks.formats.base": ("Boxes", "FrameClock"),
        "tracks.formats.of_log": ("boxes_of_log", "log_of_boxes"),
        "tracks.formats.registry": ("read_boxes", "write_boxes"),
        "tracks.log": ("DROPPED", "TRACK", "Kind", "TrackLog"),
        "tracks.tracking": ("Tracker",),
    },
)  # fmt: skip

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
    from .api import evaluate, lines, plot, render, simulate, track, tracker
    from .api import filter_recording as filter
    from .errors import (
        ConfigError,
        EngineError,
        EvcotError,
        OutputError,
        RecordingError,
        RecordingWarning,
        ToolchainError,
        TrackLogError,
    )
    from .events import Events, Recording
    from .filters.config import FilterConfig
    from .filters.hot_pixels import learn_hot_pixels
    from .filters.run import filtered as filter_blocks
    from .hardware.config import CotConfig, MotionConfig, SlotConfig
    from .hardware.contract import REGISTERS, Mode, Shape, State
    from .hardware.modules import MODULES
    from .hardware.motion.contract import MotionRegisters
    from .hardware.published.model import PublishedCascade, PublishedConfig, PublishedTracker
    from .hardware.published.model import decode as decode_published
    from .hardware.register_access import Registers
    from .hardware.registers import Transport, register_map
    from .hough.contract import HoughConfig
    from .metrics.rule import Rule, load_rule
    from .metrics.scores import Scores
    from .metrics.truth import GroundTruth, read_truth
    from .page import Page
    from .recordings.describe import describe
    from .recordings.files import RecordingFile, open_recording, write_events
    from .recordings.files import read_recording as read
    from .recordings.files import write_recording as write
    from .scenes.registry import SCENES
    from .scenes.truth import Scene, Truth
    from .structured import EVENT_CD
    from .ticks import TickedEvents
    from .trackers.config import RunConfig
    from .trackers.engines import ENGINES, Engine
    from .trackers.presets import run_config
    from .tracks.formats.base import Boxes, FrameClock
    from .tracks.formats.of_log import boxes_of_log, log_of_boxes
    from .tracks.formats.registry import read_boxes, write_boxes
    from .tracks.log import DROPPED, TRACK, Kind, TrackLog
    from .tracks.timeline import lifetimes
    from .tracks.track import Box, Track, Tracks
    from .tracks.tracking import Tracker

__all__ = [
    "DROPPED",
    "ENGINES",
    "EVENT_CD",
    "MODULES",
    "REGISTERS",
    "SCENES",
    "TRACK",
    "Box",
    "Boxes",
    "ConfigError",
    "CotConfig",
    "Engine",
    "EngineError",
    "EvcotError",
    "Events",
    "FilterConfig",
    "FrameClock",
    "GroundTruth",
    "HoughConfig",
    "Kind",
    "Mode",
    "MotionConfig",
    "MotionRegisters",
    "OutputError",
    "Page",
    "PublishedCascade",
    "PublishedConfig",
    "PublishedTracker",
    "Recording",
    "RecordingError",
    "RecordingFile",
    "RecordingWarning",
    "Registers",
    "Rule",
    "RunConfig",
    "Scene",
    "Scores",
    "Shape",
    "SlotConfig",
    "State",
    "TickedEvents",
    "ToolchainError",
    "Track",
    "TrackLog",
    "TrackLogError",
    "Tracker",
    "Tracks",
    "Transport",
    "Truth",
    "boxes_of_log",
    "decode_published",
    "describe",
    "evaluate",
    "filter",
    "filter_blocks",
    "learn_hot_pixels",
    "lifetimes",
    "lines",
    "load_rule",
    "log_of_boxes",
    "open_recording",
    "plot",
    "read",
    "read_boxes",
    "read_truth",
    "register_map",
    "render",
    "run_config",
    "simulate",
    "track",
    "tracker",
    "write",
    "write_boxes",
    "write_events",
]

__version__ = "0.2.0"

_keep_kernels_in_cache()
_forget_stale_kernels(_Path(__file__).parent)

__getattr__, __dir__ = _lazily(
    __name__,
    {
        "api": ("evaluate", "filter_recording as filter", "lines", "plot", "render", "simulate", "track", "tracker"),
        "errors": (
            "ConfigError", "EngineError", "EvcotError", "OutputError", "RecordingError", "RecordingWarning", "ToolchainError",
            "TrackLogError",
        ),
        "events": ("Events", "Recording"),
        "filters.config": ("FilterConfig",),
        "filters.hot_pixels": ("learn_hot_pixels",),
        "filters.run": ("filtered as filter_blocks",),
        "hardware.config": ("CotConfig", "MotionConfig", "SlotConfig"),
        "hardware.contract": ("REGISTERS", "Mode", "Shape", "State"),
        "hardware.modules": ("MODULES",),
        "hardware.motion.contract": ("MotionRegisters",),
        "hardware.published.model": ("PublishedCascade", "PublishedConfig", "PublishedTracker", "decode as decode_published"),
        "hardware.register_access": ("Registers",),
        "hardware.registers": ("Transport", "register_map"),
        "hough.contract": ("HoughConfig",),
        "metrics.rule": ("Rule", "load_rule"),
        "metrics.scores": ("Scores",),
        "metrics.truth": ("GroundTruth", "read_truth"),
        "page": ("Page",),
        "recordings.describe": ("describe",),
        "recordings.files": (
            "RecordingFile", "open_recording", "read_recording as read", "write_events", "write_recording as write",
        ),
        "scenes.registry": ("SCENES",),
        "scenes.truth": ("Scene", "Truth"),
        "structured": ("EVENT_CD",),
        "ticks": ("TickedEvents",),
        "trackers.config": ("RunConfig",),
        "trackers.engines": ("ENGINES", "Engine"),
        "trackers.presets": ("run_config",),
        "tracks.formats.base": ("Boxes", "FrameClock"),
        "tracks.formats.of_log": ("boxes_of_log", "log_of_boxes"),
        "tracks.formats.registry": ("read_boxes", "write_boxes"),
        "tracks.log": ("DROPPED", "TRACK", "Kind", "TrackLog"),
        "tracks.timeline": ("lifetimes",),
        "tracks.track": ("Box", "Track", "Tracks"),
        "tracks.tracking": ("Tracker",),
    },
)  # fmt: skip

# SPDX-License-Identifier: Apache-2.0
"""Rerun's .rrd: events as points, tracks as boxes, on the recording's time (the extra `rerun`)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, BinaryIO

import numpy as np

from ...errors import ConfigError
from ...events import Events
from ...recordings.formats.source import Sensor
from ...tracks.boxes import upright_sides
from .colours import EVENTS
from .states import Follower

__all__ = ["check_rerun", "write_rerun"]

_POINT_PX = 0.5  # radius


def check_rerun() -> None:
    """Raise ConfigError if Rerun's library is not installed."""
    try:
        import rerun  # noqa: F401
    except ImportError as error:
        raise ConfigError(".rrd: rerun-sdk must be installed: pip install 'evcot[rerun]'") from error


def write_rerun(
    file: BinaryIO, sensor: Sensor, pictures: Iterable[tuple[int, list[Events]]], followers: Sequence[Follower], zero_us: int,
    progress: Callable[[int, int], None] | None,
) -> None:  # fmt: skip
    """Write events and tracks up to each picture's time; the file must have a name."""
    import rerun

    stream = rerun.RecordingStream("evcot", recording_id="evcot", send_properties=False)
    stream.save(file.name)
    frame = rerun.Boxes2D(mins=[(-0.5, -0.5)], sizes=[sensor], colors=[(90, 98, 108)])
    stream.log("sensor", frame, static=True)
    for number, (now_us, part) in enumerate(pictures):
        stream.set_time("recording", duration=(now_us - zero_us) / 1e6)
        events = Events.joined(part)
        places = np.column_stack([events.x, events.y]).astype(np.float32)
        colours = np.array(EVENTS, np.uint8)[events.p]
        stream.log("events", rerun.Points2D(places, colors=colours, radii=_POINT_PX))
        for follower in followers:
            _log_side(rerun, stream, follower, number)
        if progress is not None:
            progress(number + 1, now_us - zero_us)
    stream.flush()
    stream.disconnect()


def _log_side(rerun: Any, stream: Any, follower: Follower, picture: int) -> None:
    states, trails = follower.at(picture)
    name, colour = follower.side.name, follower.side.colour
    centres = np.column_stack([states["x"], states["y"]])
    half = np.column_stack(upright_sides(states)) / 2  # Boxes2D has no angle
    labels = [str(track_id) for track_id in states["track_id"].tolist()]
    stream.log(f"{name}/boxes", rerun.Boxes2D(centers=centres, half_sizes=half, labels=labels, colors=[colour] * len(states)))
    lines = [list(trail) for trail in trails.values() if len(trail) > 1]
    stream.log(f"{name}/trails", rerun.LineStrips2D(lines, colors=[colour] * len(lines)))

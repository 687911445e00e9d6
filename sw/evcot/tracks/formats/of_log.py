# SPDX-License-Identifier: Apache-2.0
"""Boxes of a TrackLog, and a TrackLog of boxes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...errors import ConfigError, TrackLogError
from ..log import TRACK, Kind, TrackLog
from ..log_files import RecordRuns
from ..log_parts import sampled
from ..record import classes_at, upright_sides
from .base import BOX, FRAME_MAX, NOBODY, Boxes, FrameClock

__all__ = ["MAX_AGE_US", "boxes_of_log", "log_of_boxes"]

MAX_AGE_US = 60_000  # past which a track's newest state is no output, as in evaluation


def boxes_of_log(
    log: RecordRuns, clock: FrameClock, sensor: tuple[int, int] | None = None, *, until_us: int | None = None,
    max_age_us: int = MAX_AGE_US,
) -> Boxes:  # fmt: skip
    """The tracks at the times of all frames, from frame 1 to the end; a turned box as the upright rectangle around it.

    Args:
        until_us: the end; None: the log's last record.

    Returns:
        Boxes whose ids are the track ids plus 1, since the formats count from 1. Their class is that of the track's last
        verdict, -1 for none; 1 in a log without verdicts.

    Raises:
        ConfigError: a clock without the length of a frame.
        TrackLogError: the log begins so long after frame 1, or ends so long, that frames cannot be numbered.
    """
    if clock.frame_us is None:
        raise ConfigError("frame_us: must be given, the time from frame to frame (--frame-us)")
    end_us = until_us if until_us is not None else _last_us(log, clock.origin_us)
    count = int((end_us - clock.origin_us) / clock.frame_us) + 2
    if count > FRAME_MAX:
        raise TrackLogError(
            f"{count} frames from {clock.origin_us} to {end_us} us: must be at most {FRAME_MAX} (origin_us, frame_us)"
        )
    times_us = clock.times_us(np.arange(1, max(count, 0) + 1), "the log")
    times_us = times_us[times_us <= end_us]
    states = sampled(log.record_runs(), times_us, max_age_us)
    rows = np.zeros(len(states), BOX)
    rows["instant"], rows["id"] = states["sample"], states["track_id"] + 1
    rows["width"], rows["height"] = upright_sides(states)
    rows["left"], rows["top"] = states["x"] - rows["width"] / 2, states["y"] - rows["height"] / 2
    rows["confidence"], rows["class_id"], rows["visibility"], rows["counted"] = states["confidence"], 1, 1.0, True
    if len(log.verdicts):
        rows["class_id"] = classes_at(log.verdicts, states["track_id"], times_us[states["sample"]])
    return Boxes(times_us, rows, sensor, class_names=log.class_names)


def _last_us(log: RecordRuns, otherwise_us: int) -> int:
    for records in log.record_runs():
        if len(records):
            otherwise_us = int(records["t_us"][-1])
    return otherwise_us


def log_of_boxes(path: Path | str, boxes: Boxes) -> TrackLog:
    """Tracks as a log: a track is there at each instant with a box of it, and gone at the next without one.

    Confidences are clipped to 0 to 1; velocities are unknown.

    Raises:
        TrackLogError: detections, which have no ids.
    """
    rows = boxes.rows
    if (rows["id"] == NOBODY).any():
        row = int(np.argmax(rows["id"] == NOBODY))
        raise TrackLogError(f"{path}: {boxes.place(row)}: id = {NOBODY}: must be a track's: detections are no tracks")
    rows = rows[np.lexsort((rows["instant"], rows["id"]))]
    follows = np.zeros(len(rows), np.bool_)
    follows[1:] = (rows["id"][1:] == rows["id"][:-1]) & (rows["instant"][1:] == rows["instant"][:-1] + 1)
    states = _records(rows)
    states["t_us"] = boxes.instants_us[rows["instant"]]
    states["kind"] = np.where(follows, Kind.MOVED, Kind.BORN)
    last = np.append(~follows[1:], True)[: len(rows)]
    ends = states[last]
    ends["kind"] = Kind.LOST
    ends["t_us"] = _after(boxes.instants_us)[rows["instant"][last]]
    records = np.concatenate((ends, states))
    return TrackLog(Path(path).name, records[np.argsort(records["t_us"], kind="stable")], np.empty(0, np.int16))


def _records(rows: NDArray[np.void]) -> NDArray[np.void]:
    records = np.zeros(len(rows), TRACK)
    records["track_id"], records["other_id"] = rows["id"], -1
    for axis, low, side in (("x", "left", "width"), ("y", "top", "height")):
        records[axis], records[side] = rows[low] + rows[side] / 2, rows[side]
    records["radius"] = np.maximum(rows["width"], rows["height"]) / 2
    records["confidence"] = np.clip(rows["confidence"], 0.0, 1.0)
    return records


def _after(instants_us: NDArray[np.int64]) -> NDArray[np.int64]:
    """The instant after each; after the last one, as long as usual."""
    step_us = int(np.median(np.diff(instants_us))) if len(instants_us) > 1 else 1
    return np.append(instants_us[1:], instants_us[-1:] + step_us)

# SPDX-License-Identifier: Apache-2.0
"""Named moments of a run: the third merge, a time, an event, the first difference between hardware and model."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from evcot.errors import ConfigError
from evcot.events import Recording
from evcot.hardware.config import CotConfig, MotionConfig
from evcot.hardware.golden import track
from evcot.tracks.log import Kind

from ..names import MOMENTS
from .summary import SUMMARY, read_summary

__all__ = ["Moment", "find_moment"]

_KINDS = {"birth": Kind.BORN, "move": Kind.MOVED, "merge": Kind.MERGED, "loss": Kind.LOST}


@dataclass(frozen=True)
class Moment:
    """One moment of a run.

    Attributes:
        event_index: the event that causes it; for a loss, which is caused by time, the next event.
        name: text for messages and markers.
        kind: kind of its record, or None.
        track_id: track of its record, or -1.
    """

    event_index: int
    name: str
    kind: Kind | None = None
    track_id: int = -1


def find_moment(text: str, recording: Recording, config: CotConfig | MotionConfig, folder: Path | None = None) -> Moment:
    """The moment named by a text, in the syntax of `MOMENTS`. Records are the golden model's, which equal the hardware's.

    Args:
        config: of the hardware.
        folder: folder of the run; needed only for a mismatch.

    Raises:
        ConfigError: no such moment; the message lists the valid ones.
    """
    what, colon, number = text.partition(":")
    events = recording.events
    if what in _KINDS:
        records = track(recording, config).of_kind(_KINDS[what])
        n = _whole(text, number if colon else "1")
        if not 1 <= n <= len(records):
            rule = f"must be from 1 to {len(records)}" if len(records) else f"there is no {what} in this run"
            raise ConfigError(f"--around {text}: {rule}")
        record = records[n - 1]
        index = min(int(record["event_index"]), len(events) - 1)
        return Moment(index, f"{what} {n}", _KINDS[what], int(record["track_id"]))
    if what == "event":
        index = _whole(text, number)
        if index >= len(events):
            raise ConfigError(f"--around {text}: must be from event:0 to event:{len(events) - 1}")
        return Moment(index, f"event {index}")
    if what == "time":
        return _at(text, number, recording)
    if text == "mismatch":
        return Moment(_mismatch(folder), "mismatch")
    raise ConfigError(f"--around {text}: must be {MOMENTS}")


def _whole(text: str, number: str) -> int:
    if not (number.isascii() and number.isdigit() and len(number) < 16):
        raise ConfigError(f"--around {text}: must be {MOMENTS}")
    return int(number)


def _at(text: str, number: str, recording: Recording) -> Moment:
    try:
        ms = float(number)
    except ValueError as error:
        raise ConfigError(f"--around {text}: must be {MOMENTS}") from error
    since_us = recording.events.t_us - recording.events.t_us[0]
    if not (math.isfinite(ms) and 0 <= 1000 * ms <= since_us[-1]):
        raise ConfigError(f"--around {text}: must be from time:0 to time:{since_us[-1] / 1000:g}")
    return Moment(int(np.searchsorted(since_us, round(1000 * ms))), f"{ms:g} ms")


def _mismatch(folder: Path | None) -> int:
    """The event of the first difference between hardware and model in the run of this folder."""
    if folder is None:
        raise ConfigError("--around mismatch: needs the folder of a run, whose summary says where it is")
    found = read_summary(folder / SUMMARY).get("mismatch")
    if found is None:
        raise ConfigError("--around mismatch: there is none: hardware and model agreed in this run")
    return int(found["event_index"])

# SPDX-License-Identifier: Apache-2.0
"""Named moments of a run: the merge of a track, a time, an event, the first difference between hardware and model."""

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

from . import MOMENTS
from .summary import SUMMARY, read_summary

__all__ = ["Moment", "find_moment"]

_KINDS = {"birth": Kind.BORN, "move": Kind.MOVED, "merge": Kind.MERGED, "loss": Kind.LOST}

_IDS_LISTED = 10  # in a message


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
        if not len(records):
            raise ConfigError(f"--around {text}: there is no {what} in this run")
        own = np.flatnonzero(records["track_id"] == _whole(text, number)) if colon else np.zeros(1, np.int64)
        if not len(own):
            ids = _listed(np.unique(records["track_id"]).tolist())
            raise ConfigError(f"--around {text}: must be the id of a track with a {what}: {ids}")
        record = records[own[0]]
        track_id, index = int(record["track_id"]), min(int(record["event_index"]), len(events) - 1)
        return Moment(index, f"{what} {track_id}", _KINDS[what], track_id)
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


def _listed(ids: list[int]) -> str:
    """Ids in words; of many, the first and the last."""
    few = [*map(str, ids)] if len(ids) <= _IDS_LISTED else [*map(str, ids[: _IDS_LISTED - 1]), "…", str(ids[-1])]
    return ", ".join(few)


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

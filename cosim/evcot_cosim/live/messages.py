# SPDX-License-Identifier: Apache-2.0
"""Frames of the live view (the newest event of every active pixel, and the clusters), and the messages between server and page.

All numbers are little-endian; every array begins at a multiple of 4 bytes.

Text messages are JSON objects with a `type`: to the page `hello` (the first message of every run, describing it) and `figures`
(twice a second), to the server `play` (what to play next, see `wish_in`). The first byte of a binary message is its kind.

FRAME (1), server to page: 32 bytes, then arrays.

    offset  type  what
    0       u8    1
    1       u8    version of this layout, 4
    2       u16   k, number of clusters
    4       u32   number of the frame
    8       u32   n, number of events
    12      u32   events hidden by newer ones of the same pixel
    16      f64   time of the newest event, us since the first event of the run
    24      f32   u, unit of the ages, us
    28      u32   0
    then    k times: u32 track id (its low 32 bits), f32 x, f32 y, f32 width, f32 height (px), f32 angle (rad), f32 vx, f32 vy
            (px/s), f32 confidence, f32 time since birth (s), u32 which tracker: 0, or 1, 2, … of those beside it, u32 class so
            far: a place in the `labels` of `hello`
            u16[n] x, u16[n] y, u16[n] age: the event happened age * u before the newest one
            u8[n]  bit 0: polarity; bit 1: a filter removed the event

DRAWN (2), page to server: u8 2, three bytes 0, u32 number of the frame that has been drawn.
"""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evcot._numba_private import njit
from evcot.recordings.formats.source import Sensor
from evcot.tracks.log import DROPPED

from .player import Wish
from .session import Step
from .visible_clusters import Clusters

__all__ = ["Frame", "FrameMaker", "drawn_number", "pack_frame", "wish_in"]


@dataclass(frozen=True)
class Frame:
    """Events since the previous frame, one per pixel, and the clusters.

    Attributes:
        number: from 0 on.
        t_us: time of the newest event.
        events_t_us, x, y: (n,) times and places, in time order.
        on, filtered: (n,) bool, polarity, and whether a filter removed the event.
        hidden: number of events hidden by newer ones of the same pixel.
        clusters: the visible clusters.
        beside: those of the trackers beside it.
        arrived_s: (k,) arrival times of its packets.
    """

    number: int
    t_us: int
    events_t_us: NDArray[np.int64]
    x: NDArray[np.uint16]
    y: NDArray[np.uint16]
    on: NDArray[np.bool_]
    filtered: NDArray[np.bool_]
    hidden: int
    clusters: Clusters
    beside: Sequence[Clusters]
    arrived_s: NDArray[np.float64]


class FrameMaker:
    """Makes the frames for one subscriber.

    Args:
        first: number of its first frame.
    """

    def __init__(self, sensor: Sensor, first: int = 0) -> None:
        self._width = sensor[0]
        self._seen = np.full(sensor[0] * sensor[1], -1, np.int64)
        self._number = first - 1

    def make(self, steps: Sequence[Step], clusters: Clusters, beside: Sequence[Clusters] = ()) -> Frame:
        """The next frame, from at least one step."""
        self._number += 1
        t_us, x, y, p = (np.concatenate([getattr(step.events, name) for step in steps]) for name in ("t_us", "x", "y", "p"))
        owner = np.concatenate([step.owner for step in steps])
        newest = np.empty(len(t_us), np.bool_)
        _mark_newest(x, y, self._width, self._number, self._seen, newest)
        chosen = np.flatnonzero(newest)
        return Frame(
            self._number, int(t_us[-1]), t_us[chosen], x[chosen], y[chosen], p[chosen] == 1, owner[chosen] == DROPPED,
            len(t_us) - len(chosen), clusters, beside, np.array([step.arrived_s for step in steps]),
        )  # fmt: skip


@njit(cache=True, nogil=True)
def _mark_newest(x, y, width, number, seen, newest):  # type: ignore[no-untyped-def]
    """Mark events that are the last of their pixel; `seen`: per pixel, number of the last frame with an event there."""
    for back in range(len(x)):
        i = len(x) - 1 - back
        cell = np.int64(y[i]) * width + np.int64(x[i])
        newest[i] = seen[cell] != number
        seen[cell] = number


_FRAME, _DRAWN, _VERSION = 1, 2, 4
_HEAD = struct.Struct("<BBHIIIdf4x")
_DRAWN_MESSAGE = struct.Struct("<B3xI")
_STATE = ("x", "y", "width", "height", "angle", "vx", "vy", "confidence")
_CLUSTER = np.dtype([("id", "<u4"), *((name, "<f4") for name in _STATE), ("age_s", "<f4"), ("lane", "<u4"), ("label", "<u4")])
_AGE_MAX = (1 << 16) - 1
_CLUSTERS_MAX = (1 << 16) - 1
_PLAY: dict[str, Any] = {"type": str, "engine": str, "preset": (str, type(None)), "hardware": bool, "at_s": (int, float)}
_AT_MAX_S = 1e9


def pack_frame(frame: Frame, first_us: int) -> bytes:
    """Encode a frame as a message; `first_us`: time of the run's first event."""
    lanes = [_clusters(frame, lane, of) for lane, of in enumerate((frame.clusters, *frame.beside))]
    clusters = np.concatenate(lanes)[:_CLUSTERS_MAX]
    age_us = frame.t_us - frame.events_t_us
    unit_us = max(int(age_us.max()) / _AGE_MAX, 1e-3) if len(age_us) else 1.0
    age = np.minimum(np.round(age_us / unit_us), _AGE_MAX).astype("<u2")
    head = _HEAD.pack(
        _FRAME, _VERSION, len(clusters), frame.number & 0xFFFFFFFF, len(age), frame.hidden, frame.t_us - first_us, unit_us
    )
    flags = frame.on.astype(np.uint8) | frame.filtered.astype(np.uint8) << 1
    return b"".join([head, clusters.tobytes(), *map(_padded, (frame.x.astype("<u2"), frame.y.astype("<u2"), age, flags))])


def _clusters(frame: Frame, lane: int, of: Clusters) -> NDArray[np.void]:
    clusters = np.empty(len(of.states), _CLUSTER)
    clusters["id"] = of.states["track_id"] & 0xFFFFFFFF
    for name in _STATE:
        clusters[name] = of.states[name]
    clusters["age_s"] = np.maximum(frame.t_us - of.birth_us, 0) / 1e6
    clusters["lane"], clusters["label"] = lane, of.label
    return clusters


def drawn_number(message: bytes | str) -> int | None:
    """The number of the frame in a DRAWN message; None for any other message."""
    if isinstance(message, str) or len(message) != _DRAWN_MESSAGE.size or message[0] != _DRAWN:
        return None
    number: int = _DRAWN_MESSAGE.unpack(message)[1]
    return number


def wish_in(message: str) -> Wish | None:
    """The wish in a `play` message; None for anything else.

    `{"type": "play", "engine": "rct", "preset": "plain" or null, "hardware": false, "at_s": 1.5}`, all five keys and no other.
    """
    try:
        told: Any = json.loads(message)
    except (ValueError, RecursionError):
        return None
    if not isinstance(told, dict) or told.keys() != _PLAY.keys():
        return None
    if not all(isinstance(told[key], kind) for key, kind in _PLAY.items()) or told["type"] != "play":
        return None
    at_s = told["at_s"]
    if isinstance(at_s, bool) or not (math.isfinite(at_s) and 0 <= at_s <= _AT_MAX_S):
        return None
    return Wish(told["engine"], told["preset"], told["hardware"], float(at_s))


def _padded(array: NDArray[np.uint8] | NDArray[np.uint16]) -> bytes:
    data = array.tobytes()
    return data + bytes(-len(data) % 4)

# SPDX-License-Identifier: Apache-2.0
"""Messages between server and page. All numbers are little-endian; every array begins at a multiple of 4 bytes.

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
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .frame import Frame
from .player import Wish
from .visible_clusters import Clusters

__all__ = ["drawn_number", "pack_frame", "wish_in"]

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

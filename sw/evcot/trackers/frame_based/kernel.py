# SPDX-License-Identifier: Apache-2.0
"""Compiled kernels of the track management: prediction, assignment costs, and the update with a frame.

A frame, here, is a set of events and the detections in it: the pixels of some milliseconds, or a packet of events.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..._numba_private import step
from ...tracks.log import Kind

__all__ = ["CURSOR", "DETECTION", "FRAME", "RECORDS_PER_TRACK", "TRACKED", "Rules", "distances", "follow", "own", "settle"]

Table = NDArray[Any]

DETECTION = np.dtype(
    [
        ("x", "<f8"),  # centre, pixels
        ("y", "<f8"),
        ("radius", "<f8"),  # half the side of its window, pixels
        ("width", "<f8"),  # of the object, pixels
        ("height", "<f8"),
        ("after_us", "<f8"),  # mean time of its events after the frame's first
        ("n", "<i8"),  # its points: events or pixels
    ]
)

FRAME = np.dtype(
    [
        ("begin", "<i8"),  # its events: the first, and the one after the last
        ("end", "<i8"),
        ("found", "<i8"),  # its detections, in the same way
        ("found_end", "<i8"),
    ]
)

TRACKED = np.dtype(
    [
        ("x", "<f8"),  # centre, pixels, `before_us` before `last_us`
        ("y", "<f8"),
        ("velocity_x", "<f8"),  # pixels per second
        ("velocity_y", "<f8"),
        ("radius", "<f8"),
        ("width", "<f8"),
        ("height", "<f8"),
        ("before_us", "<f8"),
        ("last_us", "<i8"),  # last event of the frame in which it was last detected
        ("n", "<i8"),  # points in that frame
        ("support", "<i8"),  # points in all frames
        ("hits", "<i8"),  # frames in which it was detected
        ("track_id", "<i8"),  # -1 until it is visible
        ("slot", "<i8"),
    ]
)

CURSOR = np.dtype(
    [
        ("live", "<i8"),  # tracks
        ("births", "<i8"),  # tracks that became visible so far: the next track id
        ("index", "<i8"),  # events before the arrays at hand
        ("records", "<i8"),  # in the buffer
    ]
)


class Rules(NamedTuple):
    """`config.IdentityConfig` in the form used by the kernel."""

    gate_px: float
    smoothing_us: float
    visible_hits: int
    candidate_us: int
    lifetime_us: int


RECORDS_PER_TRACK = 2  # per frame: a life may end before the frame and another begin in it
BORN, MOVED, LOST = int(Kind.BORN), int(Kind.MOVED), int(Kind.LOST)
_OUTSIDE = 1e3  # cost of a pair outside the gate, in gates


@step
def _write(rules: Rules, row: Any, kind: int, index: int, t_us: int, track: Any) -> None:
    """Write a record with a track's predicted position at the end of the frame in which it was last detected."""
    ahead_s = 1e-6 * track.before_us
    row.t_us = t_us
    row.event_index = index
    row.kind = kind
    row.track_id = track.track_id
    row.slot = track.slot
    row.x = track.x + track.velocity_x * ahead_s
    row.y = track.y + track.velocity_y * ahead_s
    row.radius = track.radius
    row.width = track.width
    row.height = track.height
    row.angle = 0.0
    row.vx = track.velocity_x
    row.vy = track.velocity_y
    row.confidence = track.hits / (track.hits + rules.visible_hits)
    row.n_ev = track.n
    row.support = track.support
    row.other_id = -1


@step
def _end_of_life_us(rules: Rules, track: Any) -> int:
    return track.last_us + (rules.lifetime_us if track.track_id >= 0 else rules.candidate_us)  # type: ignore[no-any-return]


@njit(cache=True, nogil=True)
def _end_lives(
    rules: Rules, cur: Any, tracks: Table, slot_taken: Table, until_us: int, ts: Table, frame: Any, out: Table
) -> None:
    """Remove the tracks whose life has ended by `until_us`, with LOST records in order of time."""
    first = cur.records
    kept = 0
    for i in range(cur.live):
        end_us = _end_of_life_us(rules, tracks[i])
        if end_us > until_us:
            if kept < i:
                tracks[kept] = tracks[i]
            kept += 1
            continue
        slot_taken[tracks[i].slot] = False
        if tracks[i].track_id >= 0:
            at = cur.records
            while at > first and out[at - 1].t_us > end_us:
                out[at] = out[at - 1]
                at -= 1
            next_event = frame.begin + np.searchsorted(ts[frame.begin : frame.end], end_us)
            _write(rules, out[at], LOST, cur.index + next_event, end_us, tracks[i])
            cur.records += 1
    cur.live = kept


@njit(cache=True, nogil=True, inline="always")
def _elapsed_us(track: Any, seen: Any, first_us: int) -> float:
    """Time from a track's state to a detection in the frame that begins at `first_us`."""
    return (first_us - track.last_us) + seen.after_us + track.before_us  # type: ignore[no-any-return]


@njit(cache=True, nogil=True)
def distances(rules: Rules, cursor: Table, tracks: Table, found: Table, first_us: int) -> Table:
    """(live, k) assignment costs: distance of a detection from a track's prediction, in pixels; plus one gate for a track that
    is not yet visible, so that visible tracks take precedence; outside the gate more than all other pairs together."""
    live = cursor[0].live
    cost = np.empty((live, len(found)))
    for i in range(live):
        track = tracks[i]
        behind = rules.gate_px if track.track_id < 0 else 0.0
        for k in range(len(found)):
            elapsed_s = 1e-6 * _elapsed_us(track, found[k], first_us)
            off_x = found[k].x - (track.x + track.velocity_x * elapsed_s)
            off_y = found[k].y - (track.y + track.velocity_y * elapsed_s)
            apart_px = np.sqrt(off_x * off_x + off_y * off_y)
            cost[i, k] = apart_px + behind if apart_px <= rules.gate_px else _OUTSIDE * len(found) * rules.gate_px
    return cost


@step
def _pair_without_choice(rules: Rules, cost: Table, partner: Table) -> bool:
    """Pair all that are within a gate; returns whether the assignment is unambiguous."""
    partner[:] = -1
    for i in range(cost.shape[0]):
        chosen = -1
        for k in range(cost.shape[1]):
            if cost[i, k] <= 2.0 * rules.gate_px:
                if chosen >= 0 or partner[k] >= 0:
                    return False
                chosen = k
                partner[k] = i
    return True


@step
def _correct(rules: Rules, track: Any, seen: Any, first_us: int, last_us: int) -> None:
    """A critically damped g-h filter: memory fades with one time constant, independent of the frame rate.

    E. Brookner, "Tracking and Kalman Filtering Made Easy", 1998, section 1.2.6: g = 1 - theta^2, h = (1 - theta)^2. Until the
    memory is filled, the position is the mean of the detections.
    """
    elapsed_us = _elapsed_us(track, seen, first_us)
    elapsed_s = 1e-6 * elapsed_us
    fading = np.exp(-elapsed_us / rules.smoothing_us) if rules.smoothing_us > 0.0 else 0.0
    gain = max(1.0 - fading * fading, 1.0 / (track.hits + 1))
    track.x += track.velocity_x * elapsed_s
    track.y += track.velocity_y * elapsed_s
    off_x = seen.x - track.x
    off_y = seen.y - track.y
    track.x += gain * off_x
    track.y += gain * off_y
    if elapsed_s > 0.0:
        track.velocity_x += (1.0 - fading) ** 2 * off_x / elapsed_s
        track.velocity_y += (1.0 - fading) ** 2 * off_y / elapsed_s
    track.radius += gain * (seen.radius - track.radius)
    track.width += gain * (seen.width - track.width)
    track.height += gain * (seen.height - track.height)
    track.n = seen.n
    track.support += seen.n
    track.hits += 1
    _mark(track, seen, first_us, last_us)


@step
def _mark(track: Any, seen: Any, first_us: int, last_us: int) -> None:
    track.last_us = last_us
    track.before_us = (last_us - first_us) - seen.after_us


@step
def _seed(cur: Any, tracks: Table, slot_taken: Table, seen: Any, first_us: int, last_us: int) -> None:
    slot = 0
    while slot_taken[slot]:
        slot += 1
    slot_taken[slot] = True
    track = tracks[cur.live]
    cur.live += 1
    track.x = seen.x
    track.y = seen.y
    track.velocity_x = 0.0
    track.velocity_y = 0.0
    track.radius = seen.radius
    track.width = seen.width
    track.height = seen.height
    track.n = seen.n
    track.support = seen.n
    track.hits = 1
    track.track_id = -1
    track.slot = slot
    _mark(track, seen, first_us, last_us)


@njit(cache=True, nogil=True)
def settle(
    rules: Rules, cursor: Table, tracks: Table, slot_taken: Table, ts: Table, frame: Any, found: Table, partner: Table,
    out: Table,
) -> None:  # fmt: skip
    """Update each detection's partner, given as the index of a track, or start a new track where it is -1."""
    cur = cursor[0]
    first_us, last_us = ts[frame.begin], ts[frame.end - 1]
    for k in range(len(found)):
        if partner[k] >= 0:
            _correct(rules, tracks[partner[k]], found[k], first_us, last_us)
        elif cur.live < len(tracks):
            _seed(cur, tracks, slot_taken, found[k], first_us, last_us)
    _end_lives(rules, cur, tracks, slot_taken, last_us, ts, frame, out)
    for i in range(cur.live):
        track = tracks[i]
        if track.last_us != last_us:
            continue
        kind = MOVED
        if track.track_id < 0:
            if track.hits < rules.visible_hits:
                continue
            track.track_id = cur.births
            cur.births += 1
            kind = BORN
        _write(rules, out[cur.records], kind, cur.index + frame.end - 1, last_us, track)
        cur.records += 1


@njit(cache=True, nogil=True)
def own(
    rules: Rules, cursor: Table, tracks: Table, ts: Table, xs: Table, ys: Table, begin: int, end: int, owner: Table
) -> None:
    """Assign each event to the nearest visible track whose window, at its predicted position, holds it."""
    live = cursor[0].live
    for e in range(begin, end):
        owner[e] = -1
        nearest_px = np.inf
        for i in range(live):
            track = tracks[i]
            if track.track_id < 0 or ts[e] >= _end_of_life_us(rules, track):
                continue
            ahead_s = 1e-6 * ((ts[e] - track.last_us) + track.before_us)
            off_x = abs(xs[e] - (track.x + track.velocity_x * ahead_s))
            off_y = abs(ys[e] - (track.y + track.velocity_y * ahead_s))
            apart_px = max(off_x, off_y)
            if apart_px <= track.radius and apart_px < nearest_px:
                nearest_px = apart_px
                owner[e] = track.slot


@njit(cache=True, nogil=True)
def follow(
    rules: Rules, cursor: Table, tracks: Table, slot_taken: Table,
    ts: Table, xs: Table, ys: Table, owned: int, owner: Table,
    frames: Table, found: Table, frame: int, out: Table,
) -> tuple[int, bool]:  # fmt: skip
    """Update the tracks with frames from `frame` on; events before `owned` already have an owner.

    Returns:
        The frame at which it stopped, and whether that frame's assignment is ambiguous, so that `settle` must be called for
        it; otherwise all frames are done, or `out` could overflow.
    """
    cur = cursor[0]
    partner = np.empty(len(found), np.int64)
    while frame < len(frames):
        if cur.records + RECORDS_PER_TRACK * len(tracks) > len(out):
            return frame, False
        at = frames[frame]
        own(rules, cursor, tracks, ts, xs, ys, max(at.begin, owned), at.end, owner)
        _end_lives(rules, cur, tracks, slot_taken, ts[at.begin], ts, at, out)
        seen = found[at.found : at.found_end]
        cost = distances(rules, cursor, tracks, seen, ts[at.begin])
        if not _pair_without_choice(rules, cost, partner[: len(seen)]):
            return frame, True
        settle(rules, cursor, tracks, slot_taken, ts, at, seen, partner, out)
        frame += 1
    return frame, False

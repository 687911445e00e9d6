# SPDX-License-Identifier: Apache-2.0
"""The adaptive tracker, for streams of events and for recordings. See docs/adaptive.md for the algorithm."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..._numba_private import njit, step
from ...events import Events, Recording
from ...tracks.log import TrackLog
from ...tracks.tracking import track_recording
from ..compiled import CompiledTracker
from .config import AdaptiveConfig
from .layout import CELL_BITS, NEAR, NOBODY, UNSET_US, Rules, World, make_rules, make_world
from .life import RECORDS_PER_PACKET, close_packet, open_packet
from .restless import epoch_of, restless, rests

__all__ = ["SIGHTING", "AdaptiveTracker", "feed", "track"]


Table = NDArray[Any]


@step
def _away(o: Any, x: int, y: int) -> float:
    """The distance of a pixel from an object's middle, in half sides."""
    return float(max(abs(x - o.x) / o.half_x, abs(y - o.y) / o.half_y))


@step
def _owner(world: World, x: int, y: int) -> int:
    """The object in whose box or gate a pixel lies; of several, the one to whose middle it is closest in half sides."""
    near = world.near[y >> CELL_BITS, x >> CELL_BITS]
    owner = NOBODY
    for k in range(NEAR):
        i = near[k]
        if i == NOBODY:
            break
        o = world.objects[i]
        inside = abs(x - o.x) <= o.half_x + o.gate and abs(y - o.y) <= o.half_y + o.gate
        if inside and (owner == NOBODY or _away(o, x, y) < _away(world.objects[owner], x, y)):
            owner = i
    return owner


@njit(cache=True, nogil=True)
def feed(rules: Rules, world: World, ts: Table, xs: Table, ys: Table, begin: int, owner: Table, out: Table) -> int:
    """Track events from `begin` on until all are done or `out` could overflow; returns the number done."""
    run = world.run[0]
    seen, noted, first_us = world.seen, world.noted, run.first_us
    if run.packet_end_us == UNSET_US and len(ts) > begin:
        first_us = run.first_us = ts[begin]
    most = RECORDS_PER_PACKET * len(world.objects)
    end_us, index = run.packet_end_us, run.index
    for e in range(begin, len(ts)):
        t_us = ts[e]
        if t_us >= end_us:
            run.index = index
            while t_us >= run.packet_end_us:
                if run.records + most > len(out):
                    return e
                if open_packet(rules, world, t_us, out):
                    break
            end_us = run.packet_end_us
        x, y = int(xs[e]), int(ys[e])
        i = NOBODY
        index += 1
        if rests(noted, x, y, epoch_of(t_us, first_us)):
            seen[y, x] = t_us
            world.pixels[0, y >> CELL_BITS, x >> CELL_BITS] |= world.bits[y & 7, x & 7]
            if world.near[y >> CELL_BITS, x >> CELL_BITS, 0] != NOBODY:
                i = _owner(world, x, y)
                if i != NOBODY:
                    world.objects[i].packet_events += 1
        owner[e] = i
    run.index = index
    if len(ts) > begin:
        run.last_us = ts[-1]
    return len(ts)


SIGHTING = np.dtype([(name, np.float64) for name in ("half_x", "half_y", "speed_px_s")])


class AdaptiveTracker(CompiledTracker):
    """The adaptive tracker as a stream; see `CompiledTracker`."""

    def __init__(self, config: AdaptiveConfig, width: int, height: int) -> None:
        self.config = config
        self._rules = make_rules(config, width, height)
        self._world = make_world(config.max_objects, width, height)
        super().__init__(width, height, self._world.run, RECORDS_PER_PACKET * config.max_objects)

    @property
    def noise_hz(self) -> float | None:
        """Events per pixel and second of the background, as estimated so far; None until there were enough."""
        noise_hz = float(self._world.run["noise"][0])
        return noise_hz if noise_hz >= 0.0 else None

    def sightings(self) -> NDArray[np.void]:
        """The visible objects as they are now, (k,) of dtype `SIGHTING`."""
        world = self._world
        visible = np.flatnonzero(world.objects["alive"] & (world.objects["track_id"] >= 0) & (world.objects["away"] < 0))
        seen = np.empty(len(visible), SIGHTING)
        state = world.state[visible]
        seen["half_x"], seen["half_y"] = state[:, 0, 2], state[:, 1, 2]
        seen["speed_px_s"] = np.hypot(state[:, 0, 1], state[:, 1, 1])
        return seen

    def restless(self) -> NDArray[np.bool_]:
        """The pixels that are ignored because they never rest, (height, width)."""
        run = self._world.run
        return restless(self._world.noted, int(run["last_us"][0]), int(run["first_us"][0]))

    @property
    def settled(self) -> int:
        """See `tracking.Tracker`: the events before the open packet."""
        return int(self._world.run["settled"][0])

    def _continue(self, events: Events, begin: int, owner: NDArray[np.int16]) -> int:
        return feed(self._rules, self._world, events.t_us, events.x, events.y, begin, owner, self._buffer)

    def _close(self, t_us: int) -> None:
        lasted_us = t_us - int(self._run["packet_end_us"][0] - self._run["packet_us"][0])
        close_packet(self._rules, self._world, t_us, lasted_us, self._buffer)


def track(recording: Recording, config: AdaptiveConfig, keep: NDArray[np.bool_] | None = None) -> TrackLog:
    """Run the adaptive tracker over a recording, or over a selection of its events.

    Args:
        keep: (n,) bool, mask of the events that the tracker sees; None for all. Event indices in the log are the recording's.

    In the log `radius` is the mean of the box's half sides on the sensor, `support` the events that the object accumulated,
    and `n_ev` those in the packet.
    """
    return track_recording("adaptive", AdaptiveTracker(config, recording.width, recording.height), recording, keep)

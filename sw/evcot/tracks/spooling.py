# SPDX-License-Identifier: Apache-2.0
"""Track a recording of any length into a spool, with checkpoints: a killed process's work is continued bit for bit."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..digest import EventsDigest
from ..errors import RecordingError
from ..events import Events
from ..unfinished import CHECKPOINT_EVENTS, Unfinished
from .spool import LogSpool
from .tally import Tally
from .tracking import Tracker, class_names_of, take_verdicts

__all__ = ["Tracked", "rest_of", "track_into"]


@dataclass(frozen=True)
class Tracked:
    """A finished tracker, its log, what was counted in it, and its verdicts."""

    tracker: Tracker
    log: LogSpool | None
    tally: Tally
    verdicts: NDArray[np.void]


def track_into(
    work: Unfinished | None,
    engine: str,
    start: Callable[[], Tracker],
    blocks: Iterator[Events],
    every: int = CHECKPOINT_EVENTS,
    resumed: Callable[[int], None] | None = None,
) -> Tracked:
    """Feed a recording to a tracker; its log goes into the folder of `work`.

    Memory does not depend on the recording's length.

    Args:
        work: None keeps no log, and counts alone.
        start: makes a tracker before its first event.
        blocks: all events of the recording; those before a checkpoint are read and compared with it, and not tracked again.
        every: events from one checkpoint to the next; 0 makes none.
        resumed: called with the number of events that an earlier process has tracked.

    Raises:
        RecordingError: the recording has other events than those that were tracked before the checkpoint.
    """
    made_of = EventsDigest()
    state = None if work is None else work.state
    tracker = start() if state is None else state["tracker"]
    log = None if work is None else LogSpool(work.folder, "log", None if state is None else state["log"])
    tally = Tally() if log is None else log.tally
    add = tally.add if log is None else log.add
    if work is not None and log is not None:
        work.held.callback(log.close)
    at = tally.events
    if state is not None and resumed is not None:
        resumed(at)
    for block in rest_of(blocks, made_of, at, "" if state is None else state["digest"]):
        made_of.add(block)
        add(*tracker.feed(block))
        if work is not None and log is not None and every and tally.events - at >= every:
            at = tally.events
            work.save({"tracker": tracker, "log": log.state(), "digest": made_of.hex()})
    add(tracker.finish(), np.empty(0, np.int16))
    verdicts = take_verdicts(tracker)
    if log is not None:
        log.engine, log.recording = engine, made_of.hex()
        log.verdicts, log.class_names = verdicts, class_names_of(tracker)
    return Tracked(tracker, log, tally, verdicts)


def rest_of(blocks: Iterator[Events], made_of: EventsDigest, count: int, digest: str) -> Iterator[Events]:
    """The events after the first `count`, which are added to `made_of`.

    Raises:
        RecordingError: the first events have not this digest.
    """
    for block in blocks:
        if not count:
            yield block
            continue
        done = min(count, len(block))
        made_of.add(block[:done])
        count -= done
        if not count and made_of.hex() != digest:
            raise RecordingError(f"events before the checkpoint: digest = {made_of.hex()!r}: must be as before, {digest!r}")
        if done < len(block):
            yield block[done:]
    if count:
        raise RecordingError(f"{count} events fewer than before the checkpoint: must be the same recording")

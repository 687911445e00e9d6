# SPDX-License-Identifier: Apache-2.0
"""`evcot track`: a recording through one tracker, into a track log."""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict

import numpy as np

from evcot.errors import ConfigError
from evcot.events import Events
from evcot.trackers.engines import ENGINES
from evcot.tracks.formats.of_log import boxes_of_log
from evcot.tracks.formats.registry import box_format, write_boxes
from evcot.tracks.log import DROPPED, Kind, TrackLog
from evcot.tracks.tracking import signed_log_of

from ...tables import print_table
from ..options import window_from
from .clock import clock_from
from .filters import filters_from, save_learned
from .opening import open_from
from .progress import Progress
from .settings import configured, plain, say_seen

__all__ = ["run"]


def run(options: argparse.Namespace, _arguments: Sequence[str]) -> int:
    """Track a recording; 0."""
    window = window_from(options)
    if options.boxes is not None:
        _check_boxes(options)
    with open_from(options, options.recording) as file:
        settings, filters = configured(options, file.sensor)
        filters = filters_from(options, filters, file.blocks(*window), file.sensor)
        sensor, first_us = file.sensor, file.t0_us
        tracker = ENGINES[options.engine].start(settings, filters, sensor)
        with Progress(file.name, None, enabled=not (options.quiet or options.json)) as progress:
            log = signed_log_of(options.engine, tracker, _counted(file.blocks(*window, required=True), progress))
    if options.output is not None:
        log.save(options.output, force=options.force)
    if options.csv is not None:
        log.write_csv(options.csv, force=options.force)
    save_learned(options)
    say_seen(tracker, quiet=options.quiet)
    found = _found(log)
    if options.boxes is not None:
        clock = clock_from(options, first_us)
        write_boxes(options.boxes, boxes_of_log(log, clock, sensor), clock, options.boxes_format, force=options.force)
        found["frame_1_at_us"] = clock.origin_us
    if options.json:
        said = {"engine": options.engine, "settings": plain(settings), "filters": asdict(filters)}
        print(json.dumps(found | said, indent=2, allow_nan=False))
    elif not options.quiet:
        print_table([(name.replace("_", " "), "" if value is None else f"{value:,}") for name, value in found.items()])
    return 0


def _check_boxes(options: argparse.Namespace) -> None:
    """Raise ConfigError, before the work, for boxes that could not be written."""
    box_format(options.boxes, options.boxes_format)
    if clock_from(options).frame_us is None:
        raise ConfigError("--boxes: the time from frame to frame must be given (--frame-us)")


def _counted(blocks: Iterator[Events], progress: Progress) -> Iterator[Events]:
    done, first_us, begin_s = 0, None, time.perf_counter()
    for block in blocks:
        yield block
        if len(block):
            done += len(block)
            first_us = int(block.t_us[0]) if first_us is None else first_us
            progress.update(done, int(block.t_us[-1]) - first_us, done / (time.perf_counter() - begin_s))


def _found(log: TrackLog) -> dict[str, int | float | None]:
    """What a person wants to know first."""
    count = {kind: len(log.of_kind(kind)) for kind in Kind}
    return {
        "events": len(log.owner),
        "owned": int(np.count_nonzero(log.owner >= 0)),
        "passed": int(np.count_nonzero(log.owner == -1)),
        "filtered": int(np.count_nonzero(log.owner == DROPPED)),
        "tracks": count[Kind.BORN],
        "merged": count[Kind.MERGED],
        "lost": count[Kind.LOST],
        "alive_at_the_end": count[Kind.BORN] - count[Kind.MERGED] - count[Kind.LOST],
        "longest_track_s": _longest_s(log),
    }


def _longest_s(log: TrackLog) -> float | None:
    """From the first record of a track to its last; None without a track."""
    if not len(log.records):
        return None
    track_id, t_us = log.records["track_id"], log.records["t_us"]
    _, begin = np.unique(track_id, return_index=True)
    _, end = np.unique(track_id[::-1], return_index=True)
    return round(float((t_us[::-1][end] - t_us[begin]).max()) / 1e6, 6)

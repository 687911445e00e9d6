# SPDX-License-Identifier: Apache-2.0
"""`evcot track`: a recording through one tracker, into a track log."""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import asdict

import numpy as np

from evcot.errors import ConfigError
from evcot.events import Events
from evcot.recordings.files import RecordingFile
from evcot.trackers.engines import ENGINES
from evcot.tracks.formats.of_log import boxes_of_log
from evcot.tracks.formats.registry import box_format, write_boxes
from evcot.tracks.log import Kind
from evcot.tracks.log_files import check_log_path, save_log, write_csv
from evcot.tracks.spool import LogSpool
from evcot.tracks.spooling import track_into
from evcot.tracks.tally import Tally
from evcot.tracks.tracking import Tracker
from evcot.unfinished import unfinished

from ...tables import print_table
from ..options import clock_from, window_from
from .files import open_from, say_resumed, weights_from, work_key
from .progress import Progress, counted_ahead
from .settings import configured, filters_from, plain, say_seen

__all__ = ["run"]


# How the table calls what --json names otherwise.
_LABELS = {
    "owned": "in tracks",
    "passed": "in no track",
    "filtered": "filtered out",
    "merged": "ended in a merge",
    "longest_track_s": "longest track",
    "frame_1_at_us": "frame 1 at (us)",
}


def run(options: argparse.Namespace, _arguments: Sequence[str]) -> int:
    """Track a recording; 0."""
    window = window_from(options)
    if options.boxes is not None:
        _check_boxes(options)
    if options.checkpoint < 0:
        raise ConfigError(f"--checkpoint {options.checkpoint}: must not be negative")
    if options.output is not None:
        check_log_path(options.output)
    weights = weights_from(options)
    outputs = [path for path in (options.output, options.csv, options.boxes) if path is not None]
    with open_from(options, options.recording) as file, ExitStack() as held:
        settings, filters = configured(options, file.sensor)
        given = filters_from(options, file.blocks(*window), file.sensor)
        filters = given.on(filters)
        sensor, first_us = file.sensor, file.t0_us

        def key() -> str:
            classes = weights and weights.checksum
            return work_key(
                file.path, "track", options.engine, settings, filters, sensor, window, options.skip_damaged, classes
            )  # fmt: skip

        # The state of another package's tracker cannot be read back safely.
        every = 0 if ENGINES[options.engine].plug_in else options.checkpoint

        def start() -> Tracker:
            if weights is None:
                return ENGINES[options.engine].start(settings, filters, sensor)
            from evcot.recognition.tracker import start_classifying  # with Numba

            return start_classifying(options.engine, settings, filters, sensor, weights)

        work = held.enter_context(unfinished(outputs[0], key)) if outputs else None
        with (
            Progress(file.name, None, enabled=not (options.quiet or options.json)) as progress,
            counted_ahead(progress, lambda: open_from(options, options.recording), window),
        ):
            progress.note("preparing the tracker (compiled the first time, up to a minute)")
            done = track_into(
                work, options.engine, start, _counted(file.blocks(*window, required=True), progress), every,
                _say(options, file),
            )  # fmt: skip
        found = _found(done.tally)
        if weights is not None:
            found["classified"] = len(np.unique(done.verdicts["track_id"]))
        if done.log is not None:
            _write(options, done.log)
        given.save_learned()
        say_seen(done.tracker, quiet=options.quiet)
        if options.boxes is not None and done.log is not None:
            clock = clock_from(options, first_us)
            boxes = boxes_of_log(done.log, clock, sensor)
            write_boxes(options.boxes, boxes, clock, options.boxes_format, force=options.force)
            found["frame_1_at_us"] = clock.origin_us
    if options.json:
        said = {"engine": options.engine, "settings": plain(settings), "filters": asdict(filters)}
        print(json.dumps(found | said, indent=2, allow_nan=False))
    elif not options.quiet:
        print_table([(_LABELS.get(name, name.replace("_", " ")), _text(name, value)) for name, value in found.items()])
        if not outputs:
            print("nothing was saved: -o LOG.npz writes the track log, --boxes its boxes")
    return 0


def _text(name: str, value: float | None) -> str:
    if value is None:
        return "none"
    return f"{value:,.3f} s" if name.endswith("_s") else f"{value:,}"


def _say(options: argparse.Namespace, file: RecordingFile) -> Callable[[int], None] | None:
    return None if options.quiet else lambda events: say_resumed(file.name, events)


def _write(options: argparse.Namespace, log: LogSpool) -> None:
    if options.output is not None:
        save_log(log, options.output, force=options.force)
    if options.csv is not None:
        write_csv(log, options.csv, force=options.force)


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


def _found(tally: Tally) -> dict[str, int | float | None]:
    """What a person wants to know first."""
    count = tally.kinds
    return {
        "events": tally.events,
        "owned": tally.owned,
        "passed": tally.passed,
        "filtered": tally.filtered,
        "tracks": count[Kind.BORN],
        "merged": count[Kind.MERGED],
        "lost": count[Kind.BORN] - count[Kind.MERGED] - tally.alive,  # for good: LOST of one that is found again is none
        "alive_at_the_end": tally.alive,
        "longest_track_s": None if tally.longest_us is None else round(tally.longest_us / 1e6, 6),
    }

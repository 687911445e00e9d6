# SPDX-License-Identifier: Apache-2.0
"""`evcot boxes`: tracks in the field's formats."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import replace

from evcot.metrics.sampling import checked_runs
from evcot.tracks.formats.of_log import boxes_of_log
from evcot.tracks.formats.registry import box_format, is_boxes, read_boxes, write_boxes
from evcot.tracks.log_files import in_the_name_of, open_log

from ...standard_streams import as_file
from ..options import clock_from, sensor_from

__all__ = ["run"]


def run(options: argparse.Namespace, _arguments: Sequence[str]) -> int:
    """Write tracks in another format; 0."""
    clock, sensor, source = clock_from(options), sensor_from(options), as_file(options.source)
    kind = box_format(options.target, options.format)
    if options.source_format is not None or is_boxes(source):
        boxes = read_boxes(source, clock, options.source_format)
        boxes = replace(boxes, sensor=sensor or boxes.sensor)
    else:
        log = open_log(source)
        with in_the_name_of(source):
            for _ in checked_runs(log.record_runs()):
                pass
            boxes = boxes_of_log(log, clock, sensor)
    write_boxes(options.target, boxes, clock, kind.NAME, force=options.force)
    frames, tracks = len(boxes.instants_us), len(set(boxes.rows["id"].tolist()))
    if options.json:
        said = {
            "boxes": str(options.target),
            "format": kind.NAME,
            "count": len(boxes.rows),
            "instants": frames,
            "tracks": tracks,
        }
        print(json.dumps(said, indent=2))
    elif not options.quiet:
        print(f"{len(boxes.rows):,} boxes of {tracks:,} tracks at {frames:,} instants in {options.target}, {kind.TITLE}")
    return 0

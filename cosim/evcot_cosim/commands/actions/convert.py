# SPDX-License-Identifier: Apache-2.0
"""`evcot convert`: a recording, or a part of it, in another format."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path

from evcot.recordings.files import format_for, write_events

from ..options import window_from
from .opening import open_from
from .spinner import Counting

__all__ = ["run"]


def run(options: argparse.Namespace, _arguments: Sequence[str]) -> int:
    """Write a recording in another format; 0."""
    from_us, to_us = window_from(options)
    source, target = options.source, options.target
    kind = format_for(target, options.format)
    shown = not (options.quiet or options.json)
    with Counting(f"writing {target}", enabled=shown) as counting, open_from(options, source) as file:
        sensor = file.sensor
        blocks = counting.watched(file.blocks(from_us, to_us, required=True), file.t0_us)
        count = write_events(target, sensor, blocks, kind.name, force=options.force)
    said = sys.stderr if target == Path("/dev/stdout") else sys.stdout
    if options.json:
        written = {"recording": str(target), "format": kind.name, "events": count, "width": sensor[0], "height": sensor[1]}
        print(json.dumps(written, indent=2), file=said)
    elif shown:
        print(f"{count:,} events in {target}, {kind.title}", file=said)
    return 0

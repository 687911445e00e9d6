# SPDX-License-Identifier: Apache-2.0
"""`evcot info` and `evcot convert`: what is in a recording, and the same recording in another format."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Sequence
from datetime import UTC, datetime
from pathlib import Path

from evcot.recordings.describe import PEAK_WINDOW_US, Description, PixelFigures, describe
from evcot.recordings.files import format_for, write_events
from evcot.recordings.formats import WRITABLE

from .counting import Counting
from .options import open_from, recording_options, window_from
from .parsing import add_command, input_path, output_option

__all__ = ["add"]

_EXAMPLES_INFO = """
evcot info drive.aedat4
evcot info drive.raw --from 1000 --to 2000 --json
"""

_EXAMPLES_CONVERT = """
evcot convert drive.bag drive.aedat4
evcot convert drive.aedat4 part.csv --from 500 --to 900
evcot convert events.txt drive.raw --format evt3 --sensor 640x480
"""

_EARLIEST_DATE_US = 946_684_800_000_000  # times from the year 2000 on are dates; smaller ones count from some start
_LATEST_DATE_US = 4_102_444_800_000_000  # 2100


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the commands to the command line."""
    info = add_command(commands, "info", "describe a recording: sensor, length, rates, busiest pixels", _EXAMPLES_INFO)
    info.add_argument("recording", type=input_path, metavar="FILE", help="a recording in any format that evcot reads")
    recording_options(info)
    info.add_argument("--json", action="store_true", help="print every figure as JSON")
    info.set_defaults(command=_info)

    convert = add_command(commands, "convert", "write a recording, or a part of it, in another format", _EXAMPLES_CONVERT)
    convert.add_argument("source", type=input_path, metavar="A", help="a recording in any format that evcot reads")
    output_option(convert, "target", metavar="B", help="what to write; its suffix tells the format")
    convert.add_argument("--format", metavar="NAME", help=f"{', '.join(WRITABLE)} (default: by B's suffix)")
    recording_options(convert)
    convert.add_argument("--json", action="store_true", help="print what was written as JSON")
    convert.add_argument("-q", "--quiet", action="store_true", help="print nothing")
    convert.set_defaults(command=_convert)


def _info(options: argparse.Namespace, _arguments: Sequence[str]) -> int:
    window = window_from(options)
    with Counting(f"reading {options.recording}") as counting, open_from(options, options.recording) as file:
        found = describe(file, *window, progress=counting.update)
    if options.json:
        print(json.dumps({"file": str(options.recording)} | found.to_dict(), indent=2))
        return 0
    rows = _rows(found, options.recording)
    width = max(len(name) for name, _ in rows)
    for name, value in rows:
        print(f"{name:{width}}  {value}")
    return 0


def _rows(found: Description, path: Path) -> list[tuple[str, str]]:
    """The table: (what, value)."""
    return [
        ("file", str(path)),
        ("format", found.format),
        *found.details.items(),
        ("sensor", f"{found.width}x{found.height} pixels" + found.assumes_sensor * ", the smallest that holds every event"),
        ("events", f"{found.events:,}"),
        ("first event", _moment(found.first_us)),
        ("duration", f"{found.duration_us / 1e6:,.6f} s"),
        *_rate_rows(found),
        ("ON events", _percent(found.on_share)),
        *(_pixel_rows(found.pixels) if found.pixels is not None else ()),
        *(("left out", f"{count:,} events: {why}") for why, count in found.left_out.items()),
    ]


def _rate_rows(found: Description) -> Iterator[tuple[str, str]]:
    if found.mean_rate is not None:
        yield "mean rate", _rate(found.mean_rate)
    if found.peak_rate is not None:
        yield "peak rate", f"{_rate(found.peak_rate)}, over {PEAK_WINDOW_US // 1000} ms"


def _pixel_rows(pixels: PixelFigures) -> Iterator[tuple[str, str]]:
    yield "silent pixels", _percent(pixels.silent)
    if pixels.median_interval_us is not None:
        yield "pixel interval", f"{_duration(pixels.median_interval_us)} from event to event of a pixel, median"
    busiest = (f"({pixel.x}, {pixel.y}) {100 * pixel.share:.3g} %" for pixel in pixels.busiest)
    yield "busiest pixels", ", ".join(busiest)


def _moment(t_us: int) -> str:
    """A time as the file has it; one that may be a date, as that too."""
    seconds = f"{t_us / 1e6:,.6f} s"
    if not _EARLIEST_DATE_US <= t_us < _LATEST_DATE_US:
        return seconds
    return f"{datetime.fromtimestamp(t_us / 1e6, UTC):%Y-%m-%d %H:%M:%S} UTC ({seconds})"


def _duration(us: int) -> str:
    return f"{us} us" if us < 1000 else f"{us / 1e3:.3g} ms" if us < 1_000_000 else f"{us / 1e6:.3g} s"


def _rate(events_per_s: float) -> str:
    for unit, factor in (("G", 1e9), ("M", 1e6), ("k", 1e3)):
        if events_per_s >= factor:
            return f"{events_per_s / factor:.4g} {unit} events/s"
    return f"{events_per_s:.3g} events/s"


def _percent(share: float) -> str:
    return f"{100 * share:.1f} %"


def _convert(options: argparse.Namespace, _arguments: Sequence[str]) -> int:
    from_us, to_us = window_from(options)
    source, target = options.source, options.target
    kind = format_for(target, options.format)
    shown = not (options.quiet or options.json)
    with Counting(f"writing {target}", enabled=shown) as counting, open_from(options, source) as file:
        sensor = file.sensor
        blocks = counting.watched(file.blocks(from_us, to_us, required=True), file.t0_us)
        count = write_events(target, sensor, blocks, kind.name, force=options.force)
    if options.json:
        written = {"recording": str(target), "format": kind.name, "events": count, "width": sensor[0], "height": sensor[1]}
        print(json.dumps(written, indent=2))
    elif shown:
        print(f"{count:,} events in {target}, {kind.title}")
    return 0

# SPDX-License-Identifier: Apache-2.0
"""`evcot info`: describe a recording."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from evcot.recordings.describe import PEAK_WINDOW_US, Description, PixelFigures, describe

from ..options import window_from
from .files import done_each, open_from
from .spinner import Counting

__all__ = ["run"]

_SIZES_PER_BURST = 1 / 3  # that an object may move; see docs/recordings.md, measured in tests/sw/trackers/test_engines.py


_EARLIEST_DATE_US = 946_684_800_000_000  # times from the year 2000 on are dates; smaller ones count from some start
_LATEST_DATE_US = 4_102_444_800_000_000  # 2100


def run(options: argparse.Namespace, _arguments: Sequence[str]) -> int:
    """Describe recordings; 0, or 2 where one cannot be described."""
    several = len(options.recordings) > 1
    described = 0

    def describe_one(path: Path) -> dict[str, Any]:
        nonlocal described
        with Counting(f"reading {path}") as counting, open_from(options, path) as file:
            found = describe(file, *window, progress=counting.update)
        if not options.json:
            if described:
                print()
            _print(_rows(found, path))
        described += 1
        return {"file": str(path)} | found.to_dict()

    window = window_from(options)
    reports, code = done_each(options, options.recordings, describe_one)
    if options.json:
        print(json.dumps(reports if several else reports[0], indent=2))
    return code


def _print(rows: list[tuple[str, str]]) -> None:
    width = max(len(name) for name, _ in rows)
    for name, value in rows:
        print(f"{name:{width}}  {value}")


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
        *(("remark", what) for what in found.remarks),
    ]


def _rate_rows(found: Description) -> Iterator[tuple[str, str]]:
    if found.mean_rate is not None:
        yield "mean rate", _rate(found.mean_rate)
    if found.burst_us is not None:
        sizes_per_s = _SIZES_PER_BURST * 1e6 / found.burst_us
        limit = f"the default follows most objects of up to {sizes_per_s:.2g} times their size a second"
        yield "bursts", f"events come in bursts of one time, every {found.burst_us / 1e3:.3g} ms on average: {limit}"
    if found.peak_rate is not None:
        yield "peak rate", f"{_rate(found.peak_rate)}, over {PEAK_WINDOW_US // 1000} ms"


def _pixel_rows(pixels: PixelFigures) -> Iterator[tuple[str, str]]:
    yield "silent pixels", _percent(pixels.silent)
    if pixels.median_interval_us is not None:
        yield "pixel interval", f"{_duration(pixels.median_interval_us)} between two events of a pixel, median"
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

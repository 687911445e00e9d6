# SPDX-License-Identifier: Apache-2.0
"""`evcot render`: a film of tracks over events."""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Sequence

from evcot.pictures.films import Look, render, side_of
from evcot.pictures.films.film import check_suffix, picture_times

from .progress import Progress
from .tracked import tracked_from

__all__ = ["run"]


def run(options: argparse.Namespace, _arguments: Sequence[str]) -> int:
    """Write a film; 0."""
    look = Look(options.speed, options.fps, options.decay, options.width)
    check_suffix(options.output)
    begin_s = time.perf_counter()
    with tracked_from(options) as tracked:
        last_us = max(int(block.t_us[-1]) for block in tracked.blocks() if len(block))
        window = tracked.from_us, last_us
        total = len(picture_times(window, look))
        sides = [side_of(place, log.name, log.log) for place, log in enumerate(tracked.logs)]
        with Progress(options.output.name, total, enabled=not (options.quiet or options.json)) as progress:

            def told(pictures: int, t_us: int) -> None:
                rate = pictures / (time.perf_counter() - begin_s)
                progress.advance(pictures, f"{t_us / 1e6:.3f} s shown, {rate:.0f} pictures/s")

            render(tracked.blocks(), tracked.sensor, sides, options.output, window, look, told, force=options.force)
    took_s = time.perf_counter() - begin_s
    if options.json:
        print(json.dumps({"file": str(options.output), "pictures": total, "seconds": took_s}))
    elif not options.quiet:
        print(f"{options.output}: {total:,} pictures in {took_s:.1f} s")
    return 0

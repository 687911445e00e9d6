# SPDX-License-Identifier: Apache-2.0
"""`evcot filter A B`: a recording through the filters, into another recording."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from evcot.errors import ConfigError
from evcot.filters.chain import Total
from evcot.filters.contract import Filter
from evcot.filters.run import filtered
from evcot.recordings.files import format_for, write_events
from evcot.trackers.config import RunConfig, load_toml

from ...standard_streams import format_name
from ..options import window_from
from .files import open_from
from .settings import filters_from
from .spinner import Counting

__all__ = ["run"]


def run(options: argparse.Namespace, _arguments: Sequence[str]) -> int:
    """Write what the filters let through; 0."""
    window = window_from(options)
    kind = format_for(options.target, format_name(options.target))  # refused before the recording is read
    shown = not (options.quiet or options.json)
    with Counting(f"writing {options.target}", enabled=shown) as counting, open_from(options, options.source) as file:
        run = load_toml(options.config, RunConfig()) if options.config else RunConfig()
        given = filters_from(options, file.blocks(*window), file.sensor)
        config = given.on(run.filters)
        if not config.enabled and not options.learn_hot_pixels:
            raise ConfigError("no filter is on: see `evcot filter --help`")
        source = counting.watched(file.blocks(*window, required=True), file.t0_us)
        blocks = filtered(source, config, file.sensor, run.hardware.tick_us)
        kept = write_events(options.target, file.sensor, blocks, kind.name, force=options.force)
    given.save_learned()
    if options.json:
        print(json.dumps(_summary(blocks.totals, kept) | {"config": asdict(config)}, indent=2))
    elif shown:
        _print(blocks.totals, kept)
    return 0


def _summary(totals: dict[Filter, Total], kept: int) -> dict[str, Any]:
    rows = [{"filter": which.name.lower(), **total._asdict()} for which, total in totals.items()]
    return {"seen": _seen(totals, kept), "kept": kept, "filters": rows}


def _seen(totals: dict[Filter, Total], kept: int) -> int:
    """How many events the recording has; without a filter, as many as it keeps."""
    return next(iter(totals.values()), Total(kept, 0)).seen


def _print(totals: dict[Filter, Total], kept: int) -> None:
    """A row per filter, and what is left of it all; shares are of what reached the filter."""
    print(f"{'filter':10}  {'events in':>13}  {'dropped':>13}  {'share':>6}")
    seen = _seen(totals, kept)
    for name, total in [*((which.name.lower(), total) for which, total in totals.items()), ("all", Total(seen, seen - kept))]:
        print(f"{name:10}  {total.seen:13,}  {total.dropped:13,}  {total.dropped / max(1, total.seen):6.1%}")

# SPDX-License-Identifier: Apache-2.0
"""`evcot filter A B`: a recording through the filters, into another recording."""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from evcot.config import FilterConfig, RunConfig, load_toml
from evcot.contract import Filter
from evcot.errors import ConfigError
from evcot.events import Events
from evcot.files import format_for, write_events
from evcot.filters.chain import Total
from evcot.filters.hot_pixels import Pixels, learn_hot_pixels, load_hot_pixels, save_hot_pixels
from evcot.filters.run import filtered
from evcot.presets import for_sensor

from .options import open_from, recording_options, window_from

__all__ = ["add"]


def milliseconds(text: str) -> int:
    """Milliseconds as whole microseconds; less than one is none only where it says 0. The name is what argparse prints."""
    ms = float(text)
    if not math.isfinite(ms) or (ms != 0 and round(1000 * ms) == 0):
        raise ValueError(text)
    return round(1000 * ms)


def region(text: str) -> tuple[int, ...]:
    """`X0,Y0,X1,Y1`. The name is what argparse prints."""
    return tuple(int(part) for part in text.split(","))


# option -> (field of FilterConfig, type, argument, help)
_NUMBERS: dict[str, tuple[str, Callable[[str], Any], str, str]] = {
    "--refractory": ("refractory_us", milliseconds, "MS", "silence each pixel for so long after an event"),
    "--activity": ("activity_us", milliseconds, "MS", "keep events that a neighbour preceded by at most so long"),
    "--activity-support": ("activity_support", int, "N", "how many neighbours (default: 1)"),
    "--recent": ("recent_us", milliseconds, "MS", "keep events near one of the last few, at most so old"),
    "--recent-radius": ("recent_radius", int, "PX", "how near (default: 4)"),
    "--recent-support": ("recent_support", int, "N", "near how many (default: 1)"),
    "--recent-depth": ("recent_depth", int, "N", "of how many last events (default: 32)"),
    "--decay-tau": ("decay_tau_us", milliseconds, "MS", "keep events whose neighbours' weights, decaying so, add up"),
    "--decay-epsilon": ("decay_epsilon", float, "W", "weight up to which an event is forgotten (default: 0.1)"),
    "--decay-support": ("decay_support", float, "W", "sum of weights that an event needs (default: 1)"),
}


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the command line."""
    parser = commands.add_parser("filter", help="take noise, hot pixels or a region out of a recording")
    parser.add_argument("source", type=Path, metavar="A", help="the recording, in any format that evcot reads")
    parser.add_argument("target", type=Path, metavar="B", help="what to write; its suffix tells the format")
    recording_options(parser)
    parser.add_argument("--config", type=Path, metavar="TOML", help="its table [filters]; the options below come on top")
    parser.add_argument("--region", type=region, metavar="X0,Y0,X1,Y1", help="keep these columns and rows, the last ones too")
    parser.add_argument("--polarity", choices=("on", "off"), help="keep events of this polarity")
    parser.add_argument("--hot-pixels", type=Path, metavar="FILE", help="silence the pixels listed there, one `x y` a line")
    parser.add_argument(
        "--learn-hot-pixels", nargs="?", const="", metavar="FILE",
        help="find hot pixels in the recording and silence them; with a FILE also list them there",
    )  # fmt: skip
    for option, (field, kind, metavar, meaning) in _NUMBERS.items():
        parser.add_argument(option, dest=field, type=kind, metavar=metavar, help=meaning)
    parser.add_argument("--json", action="store_true", help="print what was done as JSON instead of a table")
    parser.add_argument("-q", "--quiet", action="store_true", help="print nothing")
    parser.set_defaults(command=_filter)


def _filter(options: argparse.Namespace, _arguments: Sequence[str]) -> int:
    window = window_from(options)
    kind = format_for(options.target)  # refused before the recording is read
    with open_from(options, options.source) as file:
        run = load_toml(options.config, for_sensor(file.sensor[0])) if options.config else RunConfig()
        config = _with_hot_pixels(_on_top(run.filters, options), options, file.blocks(*window), file.sensor)
        if not config.enabled and options.learn_hot_pixels is None:
            raise ConfigError("no filter is on: see `evcot filter --help`")
        blocks = filtered(file.blocks(*window, required=True), config, file.sensor, run.cot.tick_us)
        kept = write_events(options.target, file.sensor, blocks, kind.name)
    if options.json:
        print(json.dumps(_summary(blocks.totals, kept) | {"config": asdict(config)}, indent=2))
    elif not options.quiet:
        _print(blocks.totals, kept)
    return 0


def _on_top(config: FilterConfig, options: argparse.Namespace) -> FilterConfig:
    """The configuration with what the options say."""
    given = {name: getattr(options, name) for name in ("region", "polarity", *(field for field, *_ in _NUMBERS.values()))}
    return replace(config, **{name: value for name, value in given.items() if value is not None})


def _with_hot_pixels(
    config: FilterConfig, options: argparse.Namespace, blocks: Iterable[Events], sensor: tuple[int, int]
) -> FilterConfig:
    """The configuration with the hot pixels that are listed, and those that are found in the blocks."""
    listed = load_hot_pixels(options.hot_pixels, sensor) if options.hot_pixels else ()
    learned: Pixels = ()
    if options.learn_hot_pixels is not None:
        learned = learn_hot_pixels(blocks, sensor)
        if options.learn_hot_pixels:
            save_hot_pixels(options.learn_hot_pixels, learned, sensor)
    return replace(config, hot_pixels=config.hot_pixels + listed + learned)


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

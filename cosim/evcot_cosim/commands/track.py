# SPDX-License-Identifier: Apache-2.0
"""`evcot track`: a recording through one tracker, into a track log."""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np

from evcot.config import RunConfig, load_toml, load_tracker
from evcot.contract import DROPPED, Kind
from evcot.engines import ENGINES
from evcot.errors import ConfigError
from evcot.events import Events
from evcot.filters.config import FilterConfig
from evcot.presets import for_sensor
from evcot.ranges import read_value
from evcot.tracking import log_of
from evcot.tracklog import TrackLog

from ..progress import Progress
from .filter_options import filter_options, filters_from
from .options import open_from, recording_options, window_from
from .tables import print_table

__all__ = ["add"]


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the command line."""
    parser = commands.add_parser("track", help="track the objects in a recording")
    parser.add_argument("recording", type=Path, metavar="FILE", help="the recording, in any format that evcot reads")
    engines = "; ".join(f"{name}: {engine.title}" for name, engine in ENGINES.items())
    parser.add_argument("--engine", choices=ENGINES, default="rct", help=f"{engines} (default: rct)")
    parser.add_argument("--preset", metavar="NAME", help="of the engine, see `evcot presets --engine` (default: its first)")
    parser.add_argument("--config", type=Path, metavar="TOML", help="its table of the engine's name overrides the preset")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="another setting; again for more")
    parser.add_argument("-o", "--output", type=Path, metavar="LOG.npz", help="write the track log")
    parser.add_argument("--csv", type=Path, metavar="LOG.csv", help="write its records as text")
    recording_options(parser)
    filter_options(parser)
    parser.add_argument("--json", action="store_true", help="print what was found as JSON instead of a table")
    parser.add_argument("-q", "--quiet", action="store_true", help="no progress, no table")
    parser.set_defaults(command=_track)


def _track(options: argparse.Namespace, _arguments: Sequence[str]) -> int:
    window = window_from(options)
    with open_from(options, options.recording) as file:
        settings, filters = _configured(options, file.sensor)
        filters = filters_from(options, filters, file.blocks(*window), file.sensor)
        tracker = ENGINES[options.engine].start(settings, filters, file.sensor)
        with Progress(file.name, None, enabled=not (options.quiet or options.json)) as progress:
            log = log_of(options.engine, tracker, _counted(file.blocks(*window, required=True), progress))
    if options.output is not None:
        log.save_npz(options.output)
    if options.csv is not None:
        log.write_csv(options.csv)
    found = _found(log)
    if options.json:
        configured = {"engine": options.engine, "settings": _plain(settings), "filters": asdict(filters)}
        print(json.dumps(found | configured, indent=2, allow_nan=False))
    elif not options.quiet:
        print_table([(name.replace("_", " "), "" if value is None else f"{value:,}") for name, value in found.items()])
    return 0


def _configured(options: argparse.Namespace, sensor: tuple[int, int]) -> tuple[Any, FilterConfig]:
    """The engine's settings and the filters in front: the preset, with the file's and then the options' changes."""
    presets = ENGINES[options.engine].presets
    if options.preset not in (None, *presets):
        raise ConfigError(f"--preset {options.preset}: must be one of {', '.join(presets)} with --engine {options.engine}")
    name = options.preset or (for_sensor(sensor[0]).name if options.engine == "cot" else next(iter(presets)))
    settings = presets[name]
    if isinstance(settings, RunConfig):
        if options.set:
            raise ConfigError("--set: must not be given with --engine cot: its registers stand in the file of --config")
        settings = load_toml(options.config, settings) if options.config else settings
        return settings, settings.filters
    filters = ENGINES[options.engine].filters.get(name, FilterConfig())
    if options.config:
        settings, filters = load_tracker(options.config, options.engine, settings, filters)
    return _changed(options, settings), filters


def _changed(options: argparse.Namespace, settings: Any) -> Any:
    known = asdict(settings)
    for setting in options.set:
        key, equals, text = (part.strip() for part in setting.partition("="))
        if not equals or key not in known:
            raise ConfigError(f"--set {setting}: must be KEY=VALUE with a key among {', '.join(known)}")
        settings = replace(settings, **{key: read_value(f"{options.engine}.{key}", text, known[key])})
    return settings


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


def _plain(settings: Any) -> dict[str, Any]:
    return settings.to_dict() if isinstance(settings, RunConfig) else asdict(settings)

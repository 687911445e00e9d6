# SPDX-License-Identifier: Apache-2.0
"""`evcot plot` and `evcot render`: a recording with its track logs, or the folder of a run, as a figure or a film."""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from evcot.errors import ConfigError
from evcot.events import Events
from evcot.pictures.films import RERUN, Look, render, side_of
from evcot.pictures.films.film import check_suffix, picture_times
from evcot.pictures.plots import Log, Material, density, plot
from evcot.pictures.style import COLUMN_MM
from evcot.recordings.formats.source import Sensor
from evcot.tracks.log import TrackLog
from evcot.tracks.log_files import Extent

from ...lockstep.run_file import RUN_FILE, read_run_file
from ...lockstep.summary import SUMMARY, read_summary
from ...standard_streams import as_file
from ..options import RUN_DEFAULT, RUN_LOGS, window_from
from .files import check_logs, log_of_run, open_from, run_extent
from .progress import Progress

__all__ = ["draw", "film"]


def draw(options: argparse.Namespace, _arguments: Sequence[str]) -> int:
    """Draw a figure; 0."""
    with _tracked_from(options) as tracked:
        counts, _, last_us = density(tracked.blocks(0), tracked.sensor)
        material = Material(counts, tracked.logs, tracked.from_us, last_us, tracked.first_us)
        width_mm = COLUMN_MM[options.columns] if options.width is None else options.width
        kinds = tuple(kind.strip() for kind in options.kind.split(","))
        plot(material, options.output, kinds, width_mm=width_mm, height_mm=options.height, dpi=options.dpi, force=options.force)
    if options.json:
        print(json.dumps({"file": str(options.output), "panels": kinds, "logs": [log.name for log in tracked.logs]}))
    elif not options.quiet:
        print(f"{options.output}: {', '.join(kinds)} of {', '.join(log.name for log in tracked.logs)}")
    return 0


def film(options: argparse.Namespace, _arguments: Sequence[str]) -> int:
    """Write a film; 0."""
    look = Look(options.speed, options.fps, options.decay, options.width)
    check_suffix(options.output)
    begin_s = time.perf_counter()
    with _tracked_from(options) as tracked:
        last_us = max(int(block.t_us[-1]) for block in tracked.blocks(0) if len(block))
        window = tracked.from_us, last_us
        total = len(picture_times(window, look))
        sides = [side_of(place, log.name, log.log) for place, log in enumerate(tracked.logs)]
        with Progress(options.output.name, total, enabled=not (options.quiet or options.json)) as progress:

            def told(pictures: int, t_us: int) -> None:
                rate = pictures / (time.perf_counter() - begin_s)
                progress.advance(pictures, f"{t_us / 1e6:.3f} s shown, {rate:.0f} pictures/s")

            before_us = 0 if options.output.suffix.lower() == RERUN else look.fade_us
            render(tracked.blocks(before_us), tracked.sensor, sides, options.output, window, look, told, force=options.force)
    took_s = time.perf_counter() - begin_s
    if options.json:
        print(json.dumps({"file": str(options.output), "pictures": total, "seconds": took_s}))
    elif not options.quiet:
        print(f"{options.output}: {total:,} pictures in {took_s:.1f} s")
    return 0


@dataclass(frozen=True)
class _Tracked:
    """A recording that was tracked.

    Attributes:
        blocks: the events of the window, and of so many us before it, in blocks; every call gives them again.
        first_us: time of the recording's first event.
        from_us: where the window begins, on the recording's clock.
        logs: one or more, of the whole recording.
    """

    name: str
    sensor: Sensor
    blocks: Callable[[int], Iterator[Events]]
    first_us: int
    from_us: int
    logs: tuple[Log, ...]


@contextmanager
def _tracked_from(options: argparse.Namespace) -> Iterator[_Tracked]:
    """What the options name, as long as the block lasts.

    Raises:
        ConfigError: no log, or a name that no log of a run has.
        RecordingError, TrackLogError: something that cannot be read.
    """
    window = window_from(options)
    run = options.source / RUN_FILE
    if not run.is_file():
        if not options.logs:
            raise ConfigError(f"{options.source}: is no folder of a run: the recording's track logs must be given after it")
        with open_from(options, options.source) as file:
            logs = _named([as_file(Path(log)) for log in options.logs])
            first_us = file.t0_us
            extents = [Extent.of(file.blocks(required=True))]
            if window != (0, None):  # the log may be of this part alone
                extents.append(Extent.of(file.blocks(*window, required=True)))
            _check(options.logs, logs, str(options.source), extents)

            def blocks(before_us: int) -> Iterator[Events]:
                return file.blocks(*_earlier(window, before_us), required=True)

            yield _Tracked(file.name, file.sensor, blocks, first_us, first_us + window[0], logs)
        return
    for log in options.logs:
        if log not in RUN_LOGS:
            raise ConfigError(f"{log}: must be one of {', '.join(RUN_LOGS)} with the folder of a run")
    described = read_run_file(run)
    if described is None:
        raise ConfigError(f"{run}: has no table [run]: must be written by `evcot cosim`")
    recording, name = described.source.read(), described.source.name
    described.check(run, recording.events)
    recording.window(*window)  # must have events
    first_us = int(recording.events.t_us[0])
    paths = [log_of_run(options.source, log) for log in options.logs or RUN_DEFAULT]
    logs = _named(paths)
    summary = read_summary(options.source / SUMMARY) if (options.source / SUMMARY).is_file() else {}
    _check(paths, logs, described.source.recording, [run_extent(recording.events, [log.log for log in logs], summary)])
    sensor = recording.width, recording.height

    def events(before_us: int) -> Iterator[Events]:
        return iter([recording.window(*_earlier(window, before_us)).events])

    yield _Tracked(name, sensor, events, first_us, first_us + window[0], logs)


def _earlier(window: tuple[int, int | None], before_us: int) -> tuple[int, int | None]:
    return max(0, window[0] - before_us), window[1]


def _check(paths: Sequence[Path | str], logs: tuple[Log, ...], recording: str, extents: Sequence[Extent]) -> None:
    check_logs(((Path(path), log.log) for path, log in zip(paths, logs, strict=True)), recording, *extents)


def _named(paths: list[Path]) -> tuple[Log, ...]:
    """Logs by their files' names; two of one name are told apart by their folders."""
    stems = [path.stem for path in paths]
    names = [str(path.with_suffix("")) if stems.count(path.stem) > 1 else path.stem for path in paths]
    return tuple(Log(name, TrackLog.load(path)) for name, path in zip(names, paths, strict=True))

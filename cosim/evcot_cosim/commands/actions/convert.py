# SPDX-License-Identifier: Apache-2.0
"""`evcot convert`: a recording, or a part of it, in another format."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from evcot.errors import ConfigError, OutputError, reason_of
from evcot.recordings.files import format_for, write_events
from evcot.recordings.formats.source import WritableFormat

from ..options import window_from
from .files import done_each, open_from
from .spinner import Counting

__all__ = ["run"]


def run(options: argparse.Namespace, _arguments: Sequence[str]) -> int:
    """Write recordings in another format; 0, or 2 where one cannot be written."""
    window = window_from(options)
    if len(options.sources) == 1:
        kind = format_for(options.target, options.format)
        written = [_convert(options, options.sources[0], options.target, kind, window)]
        code = 0
    else:
        kind, targets = _targets(options)
        with _folder(options.target):

            def convert(source: Path) -> dict[str, Any]:
                options.claims.write(f"{source}: output", targets[source], force=options.force)
                return _convert(options, source, targets[source], kind, window)

            written, code = done_each(options, options.sources, convert)
    if options.json:
        print(json.dumps(written if len(options.sources) > 1 else written[0], indent=2))
    return code


def _convert(
    options: argparse.Namespace, source: Path, target: Path, kind: WritableFormat, window: tuple[int, int | None]
) -> dict[str, Any]:
    shown = not (options.quiet or options.json)
    with Counting(f"writing {target}", enabled=shown) as counting, open_from(options, source) as file:
        sensor = file.sensor
        blocks = counting.watched(file.blocks(*window, required=True), file.t0_us)
        count = write_events(target, sensor, blocks, kind.name, force=options.force)
    if shown:
        print(f"{count:,} events in {target}, {kind.title}")
    return {"recording": str(target), "format": kind.name, "events": count, "width": sensor[0], "height": sensor[1]}


def _targets(options: argparse.Namespace) -> tuple[WritableFormat, dict[Path, Path]]:
    """Of several recordings the format, and a file in the folder for each.

    Raises:
        ConfigError: no format.
        OutputError: two files of one name, also where capitals do not count, or a folder that is none.
    """
    folder = options.target
    if options.format is None:
        raise ConfigError(f"--format: must be given with several recordings, for the files in {folder}")
    if folder.exists() and not folder.is_dir():
        raise OutputError(f"output {folder}: exists: must be a folder with several recordings")
    kind = format_for(folder, options.format)
    targets: dict[Path, Path] = {}
    taken: dict[str, Path] = {}
    for source in options.sources:
        target = folder / f"{source.stem}{kind.suffix}"
        other = taken.setdefault(target.name.casefold(), source)
        if other is not source:
            raise OutputError(f"{other} and {source}: would both be written as {target}: must have different names")
        targets[source] = target
    return kind, targets


@contextmanager
def _folder(path: Path) -> Iterator[None]:
    """The folder, made if it is not there, and removed again if nothing was written."""
    is_new = not path.exists()
    try:
        path.mkdir(exist_ok=True)
    except OSError as error:
        raise OutputError(f"output {path}: cannot be made: {reason_of(error, path)}") from error
    try:
        yield
    finally:
        if is_new and not any(path.iterdir()):
            path.rmdir()

# SPDX-License-Identifier: Apache-2.0
"""What the commands that simulate hardware work on: events, module and configuration, from options or from a run.toml."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from evcot.digest import digest
from evcot.errors import ConfigError
from evcot.events import Events, Recording
from evcot.hardware.config import with_module
from evcot.recordings.formats.source import Sensor
from evcot.trackers.config import RunConfig, load_toml, module_in
from evcot.trackers.presets import run_config

from ...devices.base import Stalls, check_addresses
from ...lockstep.run_file import RUN_FILE, RunFile, Source, read_run_file
from ..options import DEFAULT_SCENE, sensor_from
from .settings import FilterOptions, check_learning, filters_from

__all__ = ["Job", "job_from"]


@dataclass(frozen=True)
class Job:
    """What a command that simulates works on.

    Attributes:
        name: what is made of it is called by this.
        folder: of the run that is looked at again, if it is one.
        seed: of the stall patterns.
        filters: what the options say about filters; it is in `config`.
        more: whether `recording` holds only the first events of the source.
    """

    source: Source
    recording: Recording
    config: RunConfig
    name: str
    seed: int | None
    folder: Path | None
    filters: FilterOptions
    more: bool = False

    @property
    def stalls(self) -> Stalls:
        """The stall patterns."""
        return Stalls.seeded(self.seed)

    @property
    def run_file(self) -> RunFile:
        """All that makes the run again."""
        return self.run_file_of(digest(self.recording.events))

    def run_file_of(self, digest: str) -> RunFile:
        """As `run_file`, with the digest of all events."""
        return RunFile(self.source, self.seed, digest, self.config)


def job_from(
    options: argparse.Namespace,
    window: tuple[int, int | None] = (0, None),
    until_us: int | None = None,
    claim: Callable[[str], None] | None = None,
    *,
    most: int | None = None,
) -> Job:
    """What the options say, changing the run that --config or the input folder describes.

    Args:
        window: the part of the recording that is taken, (from, to) in us after its first event. Of a run that was made of a
            part, that part is taken unless this says more than (0, None).
        until_us: what comes so long after the first event is not needed, and need not be read.
        claim: told the job's name before anything long begins, to claim what is written under that name.
        most: events that are held in memory; None: all.

    Raises:
        ConfigError, RecordingError: something that the user can mend.
    """
    check_learning(options)
    if options.stalls is not None and options.stalls < 0:
        raise ConfigError(f"--stalls {options.stalls}: must not be negative")
    folder = _run_folder(options)
    given, config_file = (options.recording, options.config) if folder is None else (None, folder / RUN_FILE)
    described = read_run_file(config_file) if config_file else None
    source = _source(options, given, described.source if described else None, window)
    if until_us is not None and not described:
        source = replace(source, to_us=until_us)
    name = folder.name if folder else source.name
    if source.truth_file is not None:
        options.claims.read(source.truth_file)
    if claim is not None:
        claim(name)
    recording, more = (source.read(), False) if most is None else source.begin(most)
    if described and source == described.source and not more:
        described.check(config_file, recording.events)
    seed = described.stalls if described and options.stalls is None else options.stalls

    sensor = recording.width, recording.height
    config = _config(options, config_file, sensor)
    filters = filters_from(options, _all_of(source) if more else [recording.events], sensor)
    if config.software_filters is not None:
        config = replace(config, software_filters=filters.on(config.software_filters))
    config = replace(config, filters=filters.on(config.filters))
    check_addresses(sensor, config.hardware, recording.name)
    return Job(source, recording, config, name, seed, folder, filters, more)


def _all_of(source: Source) -> Iterator[Events]:
    with source.opened() as file:
        yield from source.blocks(file)


def _run_folder(options: argparse.Namespace) -> Path | None:
    """The folder of a run where the input is one; its run.toml then stands for --config."""
    if options.recording is None or not (Path(options.recording) / RUN_FILE).is_file():
        return None
    for option in ("config", "preset", "slots"):
        if getattr(options, option) is not None:
            raise ConfigError(f"--{option}: must not be given with the folder of a run, which has its own configuration")
    return Path(options.recording)


def _source(options: argparse.Namespace, given: str | None, described: Source | None, window: tuple[int, int | None]) -> Source:
    """Where the events come from: what is described, with what the options say instead."""
    if options.seed is not None and options.seed < 0:
        raise ConfigError(f"--seed {options.seed}: must not be negative")
    base = described if described and given is None else Source.named(given or DEFAULT_SCENE)
    sensor = sensor_from(options)
    if sensor is not None:
        base = replace(base, width=sensor[0], height=sensor[1])
    if window != (0, None):
        base = replace(base, from_us=window[0], to_us=window[1])
    if options.seed is not None:
        base = replace(base, seed=options.seed)
    if options.struct is not None:
        base = replace(base, struct=options.struct)
    return replace(base, skip_damaged=True) if options.skip_damaged else base


def _config(options: argparse.Namespace, file: Path | None, sensor: Sensor) -> RunConfig:
    """The preset, with what the file and the options change, without the options of filters."""
    module = options.hardware or (file and module_in(file)) or None
    config = run_config(*sensor, options.preset, options.slots, hardware=module if options.preset is None else options.hardware)
    if file is not None:
        config = load_toml(file, config)
        if options.hardware:
            config = replace(config, hardware=with_module(config.hardware, options.hardware))
    return config

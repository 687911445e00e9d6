# SPDX-License-Identifier: Apache-2.0
"""run.toml: everything that determines a run of the hardware, so that it can be repeated bit for bit.

Its table `[run]` names the events; the rest is a complete configuration (see
`evcot.trackers.config.load_toml`).
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass, fields, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import tomli_w

import evcot
from evcot.digest import digest
from evcot.errors import ConfigError
from evcot.events import Events, Recording
from evcot.hardware.config import MotionConfig
from evcot.hardware.contract import Mode
from evcot.metrics.truth import truth_beside
from evcot.outputs import RUN_FILE, written_aside
from evcot.recordings.files import Damage, RecordingFile, open_recording
from evcot.scenes import Scene, Truth
from evcot.scenes.registry import SCENES, check_source, simulate_scene
from evcot.toml_file import read_toml
from evcot.trackers.config import RunConfig, load_toml

from ..standard_streams import as_file

__all__ = [
    "RUN_FILE",
    "SUMMARY",
    "RunFile",
    "Source",
    "config_tables",
    "made_again",
    "read_run_file",
    "run_toml",
    "write_run_file",
]

SUMMARY = "summary.json"  # beside run.toml

HEAD_EVENTS = 1 << 18  # of a long recording, in memory
_HEAD = "# Made by evcot. `evcot cosim --config FILE` repeats the run; [run] names the source of the events.\n"


@dataclass(frozen=True)
class Source:
    """The source of a run's events.

    Attributes:
        recording: a file, or a scene's name.
        is_scene: whether `recording` names a scene instead of a file.
        seed: seed of a scene.
        from_us, to_us: the part to use, relative to the first event; to_us None for all.
        width, height: sensor size, overriding the file's; 0 for the file's.
        skip_damaged: whether damaged parts of the file are left out.
        struct: of a MATLAB file, the struct of events; empty for the usual one.
    """

    recording: str
    is_scene: bool = False
    seed: int = 1
    from_us: int = 0
    to_us: int | None = None
    width: int = 0
    height: int = 0
    skip_damaged: bool = False
    struct: str = ""

    @classmethod
    def named(cls, name: str) -> Source:
        """The source for a name on the command line: a file if it exists, else a scene of that name.

        Raises:
            RecordingError: neither a file nor a scene.
        """
        check_source(name)
        return cls(name, is_scene=not Path(name).exists())

    @property
    def name(self) -> str:
        """Name for files and titles made from the events."""
        return self.recording if self.is_scene else Path(self.recording).stem

    @property
    def path(self) -> Path:
        """The recording's file; that of standard input is temporary."""
        return as_file(Path(self.recording))

    @property
    def truth_file(self) -> Path | None:
        """The truth beside a recording; None for a scene, and where there is none."""
        return None if self.is_scene else truth_beside(Path(self.recording))

    def read(self) -> Recording:
        """The events.

        Raises:
            ConfigError: invalid seed of the scene.
            RecordingError: as `open_recording`.
        """
        if self.is_scene:
            return _scene(self.recording, self.seed).recording.window(self.from_us, self.to_us)
        with self.opened() as file:
            return file.read(self.from_us, self.to_us)

    def opened(self) -> RecordingFile:
        """The file; not of a scene.

        Raises:
            RecordingError: as `open_recording`.
        """
        sensor = (self.width, self.height) if self.width else None
        damage: Damage = "skip" if self.skip_damaged else "refuse"
        return open_recording(self.path, sensor, damage=damage, struct=self.struct or None)

    def blocks(self, file: RecordingFile) -> Iterator[Events]:
        """The events of the opened file, block by block."""
        return file.blocks(self.from_us, self.to_us, required=True)

    def begin(self, most: int) -> tuple[Recording, bool]:
        """All events, and False; where a file has more than `most`, its first `HEAD_EVENTS`, and True.

        Raises:
            ConfigError, RecordingError: as `read`.
        """
        if self.is_scene:
            return self.read(), False
        with self.opened() as file:
            parts, count = [Events.empty()], 0
            for block in self.blocks(file):
                parts.append(block[: most - count].kept())
                count += len(block)
                if count > most:
                    break
            head = Events.joined(parts)
            if count > most:
                head = head[:HEAD_EVENTS].kept()
            return Recording(head, *file.sensor, file.name), count > most

    def scene_truth(self) -> Truth | None:
        """The complete ground truth of a scene; None for a file."""
        return _scene(self.recording, self.seed).truth if self.is_scene else None

    def absolute(self) -> Source:
        """The same source, independent of the current folder."""
        return self if self.is_scene else replace(self, recording=str(Path(self.recording).absolute()))


@lru_cache(maxsize=1)
def _scene(name: str, seed: int) -> Scene:
    """Simulate a scene, once for both its events and its truth."""
    return simulate_scene(name, seed)


@dataclass(frozen=True)
class RunFile:
    """Contents of run.toml.

    Attributes:
        source: source of the events.
        stalls: seed of the stall patterns; None never stalls.
        digest: digest of the events, see `evcot.digest`; empty if not computed.
        config: both trackers' configurations.
    """

    source: Source
    stalls: int | None
    digest: str
    config: RunConfig

    def check(self, path: Path, events: Events) -> None:
        """Raise ConfigError, naming the file, if these are not the events of the run."""
        if self.digest and digest(events) != self.digest:
            changed = f"must be that of {self.source.recording}, which has changed since: {digest(events)!r}"
            raise ConfigError(f"{path}: run.digest = {self.digest!r}: {changed}")


def run_toml(run: RunFile) -> str:
    """The text of run.toml."""
    plain, source = asdict(Source("")), asdict(run.source.absolute())
    name, kind = source.pop("recording"), "scene" if source.pop("is_scene") else "recording"
    source = {field: value for field, value in source.items() if value != plain[field]}
    stalls = {} if run.stalls is None else {"stalls": run.stalls}
    tables = config_tables(run.config)
    tables = {
        "name": tables.pop("name"),
        "hardware": tables.pop("hardware"),
        "software": tables.pop("software"),
        "run": {kind: name, **source, **stalls, "digest": run.digest},
        **tables,
    }
    return _HEAD + tomli_w.dumps(tables)


def config_tables(config: RunConfig) -> dict[str, Any]:
    """The complete configuration as the tables of a file for `--config`."""
    values = _without_none(config.to_dict())
    hardware = values.pop("hardware")
    tick_us = {"tick_us": hardware["tick_us"]}
    tables = {
        "name": values.pop("name"),
        "hardware": hardware["module"],
        "software": values.pop("software"),
        "shape": hardware["shape"],
    }
    if isinstance(config.hardware, MotionConfig):
        modes = {} if set(hardware["modes"]) == {Mode.SEEDED} else {"modes": hardware["modes"]}
        return {**tables, "motion": {**tick_us, **modes, **hardware["registers"]}, **values}
    slots = hardware["slots"]
    if all(slot == slots[0] for slot in slots):
        return {**tables, "cot": {**tick_us, **slots[0]}, **values}
    return {**tables, "cot": tick_us, "slot": slots, **values}


def write_run_file(path: Path, run: RunFile) -> None:
    """Write run.toml.

    Raises:
        OutputError: it cannot be written.
    """
    with written_aside(path) as file:
        file.write(run_toml(run).encode())


def read_run_file(path: Path) -> RunFile | None:
    """Read run.toml, or None where a configuration has no table `[run]`.

    The table names a `scene`, or a `recording`: a file whose path is relative to the folder of run.toml, not to the current
    folder.

    Raises:
        ConfigError: as `load_toml`, or an invalid table `[run]`; the message starts with the file's name, and says if another
            version of evcot made the run.
    """
    try:
        config = load_toml(path, RunConfig())
    except ConfigError as error:
        if made_by(path.parent) in ("", evcot.__version__):
            raise
        raise ConfigError(f"{error}; {made_again(path.parent)}") from error
    run = read_toml(path).get("run")
    if run is None:
        return None
    of_source = {field.name: field.type for field in fields(Source) if field.name != "is_scene"}
    wanted = of_source | {"scene": "str", "stalls": "int", "digest": "str"}
    if not isinstance(run, dict):
        raise ConfigError(f"{path}: [run] must be a table, not {run!r}")
    for key, value in run.items():
        kind = wanted.get(key)
        if kind is None:
            raise ConfigError(f"{path}: [run]: unknown field {key!r}: must be one of {', '.join(sorted(wanted))}")
        if type(value).__name__ != str(kind).removesuffix(" | None") or (type(value) is int and value < 0):
            raise ConfigError(f"{path}: run.{key} = {value!r}: must be {_MEANING[str(kind).removesuffix(' | None')]}")
    if ("recording" in run) == ("scene" in run):
        raise ConfigError(f"{path}: [run]: must have either recording, a file, or scene, one of {', '.join(SCENES)}")
    scene = run.pop("scene", None)
    if scene is not None and scene not in SCENES:
        raise ConfigError(f"{path}: run.scene = {scene!r}: must be one of {', '.join(SCENES)}")
    name = scene or str(path.absolute().parent / run.pop("recording"))
    stalls, known = run.pop("stalls", None), run.pop("digest", "")
    return RunFile(Source(name, is_scene=scene is not None, **run), stalls, known, config)


def made_by(folder: Path) -> str:
    """The version of evcot that made a run, as its summary says; empty if unknown."""
    try:
        return str(json.loads((folder / SUMMARY).read_text(encoding="utf-8"))["versions"]["evcot"])
    except (OSError, ValueError, LookupError, TypeError):
        return ""


def made_again(folder: Path) -> str:
    """Why a run does not fit, and what to do about it."""
    made, now = made_by(folder) or "an unknown version of evcot", evcot.__version__
    why = (
        f"it was changed, or an earlier state of evcot {now} wrote it" if made == now else f"it is of {made}, and this is {now}"
    )
    return f"{why}: run `evcot cosim` on its recording again"


_MEANING = {"str": "text", "int": "a whole number, not negative", "bool": "true or false"}


def _without_none(value: Any) -> Any:
    """Remove entries that are None, which TOML cannot represent; their defaults are None."""
    if isinstance(value, dict):
        return {key: _without_none(entry) for key, entry in value.items() if entry is not None}
    return [_without_none(entry) for entry in value] if isinstance(value, list | tuple) else value

# SPDX-License-Identifier: Apache-2.0
"""The folder of a sweep: its specification, the store, the report. What evcot did not write there is never touched."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from evcot.errors import ConfigError
from evcot.outputs import RUN_FILE, folder_written_aside, is_own_file, remade, written_aside

from .spec import Spec, read_spec, spec_toml
from .store import RUNS

__all__ = ["JUNIT", "MISMATCHES", "PLAYBACK", "REPORT", "SPEC", "begin", "folder_names", "spec_of", "write_own"]

SPEC, REPORT, JUNIT = "sweep.toml", "report.html", "junit.xml"
PLAYBACK, MISMATCHES = "playback", "mismatches"  # folders
_HEAD = (
    "# Made by evcot. `evcot sweep SPEC -o FOLDER` goes on with the sweep in this folder; sweep.toml is what was asked for.\n"
)


def folder_names() -> list[str]:
    """The files that a sweep replaces in its folder."""
    return [RUN_FILE, SPEC, REPORT, JUNIT]


def begin(folder: Path, spec: Spec) -> None:
    """Make the folder of a sweep, or go on in one; its runs stay when the specification has changed.

    Raises:
        OutputError: it is somebody else's, or cannot be written.
    """
    text = _HEAD + spec_toml(spec)
    path = folder / SPEC
    if is_own_file(path) and path.read_text(encoding="utf-8") == text:
        return
    with folder_written_aside(folder, "sweep") as aside:
        (aside / SPEC).write_text(text, encoding="utf-8")
        (aside / RUN_FILE).write_text(_HEAD, encoding="utf-8")


def write_own(path: Path, text: str) -> None:
    """Write a file of the folder again, unless somebody has changed it.

    Raises:
        OutputError: it was changed, or cannot be written.
    """
    with written_aside(path, force=is_own_file(path)) as file:
        file.write(text.encode())
    remade(path)


def spec_of(folder: Path) -> Spec:
    """The specification of a sweep's folder.

    Raises:
        ConfigError: it is not the folder of a sweep.
    """
    if not (folder / SPEC).is_file() or not (folder / RUNS).is_dir():
        raise ConfigError(f"{folder}: is no folder of a sweep: must hold {SPEC} and {RUNS}, as `evcot sweep` writes them")
    return read_spec(str(folder / SPEC))


def counted(status: Mapping[str, str]) -> dict[str, int]:
    """Status -> number of runs."""
    counts: dict[str, int] = {}
    for each in status.values():
        counts[each] = counts.get(each, 0) + 1
    return counts

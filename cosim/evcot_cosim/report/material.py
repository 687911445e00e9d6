# SPDX-License-Identifier: Apache-2.0
"""Input of a report: a recording, the log of each engine, the ground truth, and the figures of the run."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from evcot.errors import ConfigError
from evcot.events import Events, Recording
from evcot.hardware.modules import MODULES
from evcot.tracks.log import TrackLog

from ..lockstep.truth import Truth

__all__ = ["PAIR", "Difference", "Material", "RunComparison", "Side", "side_name", "side_names"]

PAIR = ("a", "b")  # names of the two runs' hardware in a comparison


@dataclass(frozen=True)
class Side:
    """One engine: its name in the report (hardware, model, software, or one of its own) and its log.

    Attributes:
        run: what `evcot waves` is given to show the waveform of its tracks; None where there is none.
    """

    name: str
    log: TrackLog
    run: str | None = None


class Difference(NamedTuple):
    """A figure of two runs: its name, both values and their difference as text, and which is better: a, b or neither."""

    title: str
    a: str
    b: str
    apart: str
    best: str


@dataclass(frozen=True)
class RunComparison:
    """Two runs side by side.

    Attributes:
        names: of the runs.
        headline: which run is better, in a few words.
        figures: of the hardware; those that are equal have no better one.
        settings: rows of (setting, value in A, value in B), only those that differ.
        settings_count: number of settings.
        commands: what made the runs.
        same: whether the two runs' hardware decided alike in everything.
    """

    names: tuple[str, str]
    headline: str
    figures: list[Difference]
    settings: list[tuple[str, str, str]]
    settings_count: int
    commands: tuple[str, str]
    same: bool


@dataclass(frozen=True)
class Material:
    """Input of a report.

    Attributes:
        recording: the recording; if a mismatch ended the run, only its decided part is shown.
        summary: contents of `summary.json`; every part of it may be missing.
        sides: the engines, each under a name of its own: letters, digits, `_`.
        truth: the ground truth within the events' time, or None if unknown.
        comparison: what two runs are compared by, where the sides are those of two runs.
        files: the files beside the page that belong to the run: name and size in bytes.
    """

    recording: Recording
    summary: Mapping[str, Any]
    sides: tuple[Side, ...]
    truth: Truth | None = None
    comparison: RunComparison | None = None
    files: tuple[tuple[str, int], ...] = ()

    def __post_init__(self) -> None:
        names = [side.name for side in self.sides]
        for name in names:
            if not re.fullmatch(r"[a-z][a-z0-9_]*", name) or name == "truth" or names.count(name) > 1:
                raise ConfigError(f"sides: {name!r}: must be a name of its own, of lower-case letters, digits and _")
        decided = {len(side.log.owner) for side in self.sides}
        if len(decided) > 1 or max(decided, default=0) > len(self.recording.events):
            lengths = ", ".join(f"{side.name}: {len(side.log.owner)}" for side in self.sides)
            raise ConfigError(
                f"{self.recording.name}: {len(self.recording.events)} events, logs of {lengths}: must be of the same recording"
            )

        if self.truth is not None:
            object.__setattr__(self, "truth", self.truth.within(*self.span_us))

    @property
    def pair(self) -> tuple[str, str]:
        """The sides that the summary's agreement is about; in it they are called hardware and software."""
        return ("hardware", "software") if self.comparison is None else PAIR

    @property
    def events(self) -> Events:
        """The events that all sides decided."""
        return self.recording.events[: min((len(side.log.owner) for side in self.sides), default=len(self.recording.events))]

    @property
    def span_us(self) -> tuple[int, int]:
        """Time of the first and of the last event; (0, 0) without any."""
        t_us = self.events.t_us
        return (int(t_us[0]), int(t_us[-1])) if len(t_us) else (0, 0)


def side_names(taken: Sequence[str], logs: Sequence[tuple[str, str]]) -> list[str]:
    """Names of sides for logs, given as engine and name of the file: after their engine, else their file."""
    names: list[str] = []
    for engine, stem in logs:
        slug = _slug(side_name(engine, stem, engine))
        offered = [slug, _slug(stem), *(f"{slug}_{i}" for i in range(2, len(taken) + len(names) + 3))]
        names.append(next(name for name in offered if name not in taken and name not in names))
    return names


def side_name(engine: str, stem: str, otherwise: str) -> str:
    """The side that a log is of: `evcot cosim` writes those of the hardware and of its golden model under these names."""
    return stem if engine in MODULES and stem in ("hardware", "model") else otherwise


def _slug(text: str) -> str:
    """A side's name: `truth` is another's."""
    name = re.sub(r"[^a-z0-9_]", "_", text.lower())
    return name if name[:1].isalpha() and name != "truth" else f"log_{name}"

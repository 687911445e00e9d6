# SPDX-License-Identifier: Apache-2.0
"""What a report tells about: a recording, what each engine made of it, the truth, and the figures of the run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from evcot.errors import ConfigError
from evcot.events import Events, Recording
from evcot.metrics import GroundTruth, Rule, Scores, evaluate, load_rule, read_truth, rule_for
from evcot.tracklog import TrackLog

__all__ = ["Material", "Side", "Truth", "truth_beside"]


@dataclass(frozen=True)
class Side:
    """One engine's share: its name in the report (hardware, model or software) and its log."""

    name: str
    log: TrackLog


@dataclass(frozen=True)
class Truth:
    """A ground truth and the rule by which tracks are held against it."""

    objects: GroundTruth
    rule: Rule

    @classmethod
    def read(cls, path: Path, sensor: tuple[int, int], rule: str | None = None) -> Truth:
        """Read a CSV file, by a rule's name or file, or the one with its columns; errors as of `read_truth` and `load_rule`."""
        chosen = load_rule(rule) if rule else rule_for(path)
        chosen = chosen.on(chosen.sensor or sensor)
        return cls(read_truth(path, chosen), chosen)

    @property
    def words(self) -> str:
        """How tracks are held against it, for people."""
        return f"{len(self.objects.ids)} objects at {len(self.objects.instants_us):,} instants; {self.rule.title}."

    def within(self, from_us: int, to_us: int) -> Truth:
        """That part of it between two moments, both included."""
        first, end = (int(i) for i in np.searchsorted(self.objects.instants_us, (from_us, to_us + 1)))
        objects = self.objects.objects
        chosen = objects[(objects["frame"] >= first) & (objects["frame"] < end)].copy()
        chosen["frame"] -= first
        return replace(self, objects=GroundTruth(self.objects.instants_us[first:end], chosen, self.objects.ids))

    def scores(self, log: TrackLog) -> Scores | None:
        """See `evaluate`; None where there is no instant to hold the log against."""
        return evaluate(log, self.objects, self.rule) if len(self.objects.instants_us) else None


def truth_beside(recording: Path) -> Path | None:
    """The truth that `evcot simulate` writes beside a recording, if it is there."""
    path = recording.with_name(f"{recording.stem}.truth.csv")
    return path if path.is_file() else None


@dataclass(frozen=True)
class Material:
    """All that a report is made of.

    Attributes:
        recording: what ran; of a run that a mismatch ended, the part that was decided is shown.
        summary: as of `summary.json`; every part of it may be missing.
        sides: one, two or none.
        truth: None where nobody knows it.
    """

    recording: Recording
    summary: Mapping[str, Any]
    sides: tuple[Side, ...]
    truth: Truth | None = None

    def __post_init__(self) -> None:
        decided = {len(side.log.owner) for side in self.sides}
        if len(decided) > 1 or max(decided, default=0) > len(self.recording.events):
            lengths = ", ".join(f"{side.name}: {len(side.log.owner)}" for side in self.sides)
            raise ConfigError(
                f"{self.recording.name}: {len(self.recording.events)} events, logs of {lengths}: must be of the same recording"
            )

    @property
    def events(self) -> Events:
        """The events that all sides decided."""
        return self.recording.events[: min((len(side.log.owner) for side in self.sides), default=len(self.recording.events))]

    @property
    def span_us(self) -> tuple[int, int]:
        """Time of the first and of the last event; (0, 0) without any."""
        t_us = self.events.t_us
        return (int(t_us[0]), int(t_us[-1])) if len(t_us) else (0, 0)

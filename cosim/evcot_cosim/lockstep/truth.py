# SPDX-License-Identifier: Apache-2.0
"""The ground truth of a run's recording, if known: that of a scene, or from a file."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from evcot.errors import EvcotError, RecordingWarning
from evcot.events import Recording
from evcot.metrics import GroundTruth, Rule, evaluate, load_rule, read_truth, rule_for
from evcot.metrics.truth import ground_truth_of
from evcot.scenes import Truth as SceneTruth
from evcot.tracks.log import TrackLog

from .run_file import Source

__all__ = ["Truth", "scene_truth", "truth_of"]

_INSTANTS_MAX = 3_000  # that are scored: all those of a scene of 6 s; scoring takes about a second for each side


@dataclass(frozen=True)
class Truth:
    """A ground truth and the rule by which tracks are evaluated against it."""

    objects: GroundTruth
    rule: Rule

    @classmethod
    def read(cls, path: Path, sensor: tuple[int, int], rule: str | None = None) -> Truth:
        """Read a CSV file by a rule, given by name or file or detected by its columns; errors as `read_truth`, `load_rule`."""
        chosen = load_rule(rule) if rule else rule_for(path)
        chosen = chosen.on(chosen.sensor or sensor)
        return cls(read_truth(path, chosen), chosen)

    def within(self, from_us: int, to_us: int) -> Truth:
        """The part between two times, inclusive; very many instants are subsampled evenly."""
        first, end = (int(i) for i in np.searchsorted(self.objects.instants_us, (from_us, to_us + 1)))
        step = max(1, -(-(end - first) // _INSTANTS_MAX))
        objects = self.objects.objects
        frame = objects["frame"] - first
        chosen = objects[(frame >= 0) & (objects["frame"] < end) & (frame % step == 0)].copy()
        chosen["frame"] = (chosen["frame"] - first) // step
        instants_us = self.objects.instants_us[first:end:step]
        return replace(self, objects=GroundTruth(instants_us, chosen, self.objects.ids))

    def figures(self, logs: Mapping[str, TrackLog]) -> dict[str, Any] | None:
        """What summary.json has of a truth: the number of objects, how many there are at a time, the rule, the scores of logs.

        None if the truth has no instant.

        Args:
            logs: by side.
        """
        instants = len(self.objects.instants_us)
        if not instants:
            return None
        counted = self.objects.objects["counted"]
        return {
            "objects": len(np.unique(self.objects.objects["object"][counted])),
            "alive_mean": float(np.count_nonzero(counted)) / instants,
            "rule": self.words,
            "scores": {side: evaluate(log, self.objects, self.rule).to_dict() for side, log in logs.items()},
        }

    @property
    def words(self) -> str:
        """Description of the evaluation rule."""
        used = len(self.objects.instants_us)
        step_ms = float(np.median(np.diff(self.objects.instants_us))) / 1e3 if used > 1 else 0.0
        by = self.rule.title or "as its rule says"
        count = len(self.objects.ids)
        return f"{count} object{'s' * (count != 1)} at {used:,} instants, {step_ms:.3g} ms apart: {by}."


def truth_of(source: Source, recording: Recording) -> Truth | None:
    """The truth of a run's recording: that of its scene, or of the file beside a recording (`metrics.truth`).

    An unusable file is ignored with a warning.
    """
    sensor = recording.width, recording.height
    scene = source.scene_truth()
    if scene is not None:
        return scene_truth(scene, sensor)
    beside = source.truth_file
    try:
        return Truth.read(beside, sensor) if beside is not None else None
    except EvcotError as error:
        warnings.warn(f"the report goes without the truth: {error}", RecordingWarning, stacklevel=2)
        return None


def scene_truth(truth: SceneTruth, sensor: tuple[int, int]) -> Truth:
    """The truth of a scene, with the rule of scenes; very many instants are subsampled evenly."""
    t_us = truth.samples["t_us"]
    instants_us = np.unique(t_us)
    step = max(1, -(-len(instants_us) // _INSTANTS_MAX))  # text takes its time
    kept = replace(truth, samples=truth.samples[np.isin(t_us, instants_us[::step])])
    rule = load_rule("scene").on(sensor)
    return Truth(ground_truth_of(kept, rule), rule)

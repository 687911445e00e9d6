# SPDX-License-Identifier: Apache-2.0
"""A member of the field: one recording with its truth, the rule that scores it, and how the truth is known."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from evcot.events import Recording
from evcot.metrics import load_rule
from evcot.metrics.rule import Rule
from evcot.metrics.truth import OBJECT, GroundTruth

__all__ = ["TRUTH_STEP_US", "Absent", "Entry", "Member", "nothing_there", "scene_rule"]

TRUTH_STEP_US = 20_000


class Absent(Exception):
    """What a member is made of is not at hand; the message says what."""


@dataclass(frozen=True, eq=False)
class Member:
    """One recording of the field.

    Attributes:
        family: the family that it belongs to.
        name: its own, different from all others in the family.
        recording: the events, in memory.
        truth: where the objects are; empty where nothing is to be seen.
        rule: how tracks are compared with the truth; its `sensor` is the recording's.
        obtained: how the truth is known, and its error where it is not exact.
        alternatives: other truths that are as right; the one counts in which the tracks score best.
    """

    family: str
    name: str
    recording: Recording
    truth: GroundTruth
    rule: Rule
    obtained: str
    alternatives: tuple[GroundTruth, ...] = ()

    @property
    def empty(self) -> bool:
        """Whether there is no object at all, so that every track is false."""
        return not len(self.truth.objects)


@dataclass(frozen=True)
class Entry:
    """A member that is not built yet.

    Attributes:
        family, name: of the member.
        source: families of one source share a recording or a generator, and are left out together.
        build: makes the member; raises `Absent`.
    """

    family: str
    name: str
    source: str
    build: Callable[[], Member]


def scene_rule(recording: Recording) -> Rule:
    """The rule for simulated scenes, with the sensor of a recording."""
    return load_rule("scene").on((recording.width, recording.height))


def nothing_there(begin_us: int, end_us: int) -> GroundTruth:
    """The truth of a recording without objects."""
    return GroundTruth(np.arange(begin_us, end_us, TRUTH_STEP_US, dtype=np.int64), np.zeros(0, OBJECT), ())

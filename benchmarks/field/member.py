# SPDX-License-Identifier: Apache-2.0
"""A member of the field: one recording with its truth, the rule that scores it, and how the truth is known. Kept in files."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

import evcot.scenes
from evcot.events import Events, Recording
from evcot.metrics import load_rule
from evcot.metrics.rule import Rule
from evcot.metrics.truth import OBJECT, GroundTruth

__all__ = ["FOLDER", "TRUTH_STEP_US", "Absent", "Entry", "Member", "kept", "nothing_there", "scene_rule"]


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


FOLDER = Path(__file__).parents[2] / "build" / "field"
_COLUMNS = "t_us", "x", "y", "p"


def kept(key: str, make: Callable[[], Member], *makers: str) -> Callable[[], Member]:
    """A builder that makes a member, whose rule is `scene_rule`, once for a key and a state of the sources.

    Args:
        key: says all that the member is made from.
        makers: modules of this package that make it, besides those that make all.
    """

    def build() -> Member:
        path = FOLDER / "members" / f"{hashlib.sha256(f'{_sources(*makers)} {key}'.encode()).hexdigest()[:24]}.npz"
        if path.is_file():
            return _load(path)
        member = make()
        path.parent.mkdir(parents=True, exist_ok=True)
        events, truth = member.recording.events, member.truth
        aside = path.with_suffix(f".{os.getpid()}.part")  # another process may build the same
        with aside.open("wb") as file:
            np.savez(
                file,
                names=np.array([member.family, member.name, member.recording.name, member.obtained]),
                sensor=np.array([member.recording.width, member.recording.height]),
                instants_us=truth.instants_us,
                objects=truth.objects,
                ids=np.array(truth.ids),
                **{name: getattr(events, name) for name in _COLUMNS},
            )
        aside.replace(path)
        return member

    return build


def _load(path: Path) -> Member:
    with np.load(path) as saved:
        family, name, recording_name, obtained = saved["names"].tolist()
        recording = Recording(Events(*(saved[column] for column in _COLUMNS)), *saved["sensor"].tolist(), recording_name)
        truth = GroundTruth(saved["instants_us"], saved["objects"], tuple(saved["ids"].tolist()))
    return Member(family, name, recording, truth, scene_rule(recording), obtained)


@cache
def _sources(*makers: str) -> str:
    """A digest of the sources that a member is made by."""
    digest = hashlib.sha256()
    scenes, here = Path(evcot.scenes.__path__[0]), Path(__file__).parent
    for source in (*sorted(scenes.glob("*.py")), *(here / f"{name}.py" for name in ("member", *makers))):
        digest.update(source.read_bytes())
    return digest.hexdigest()

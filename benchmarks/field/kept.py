# SPDX-License-Identifier: Apache-2.0
"""Members that take long to make, kept in build/field/members until what makes them changes."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np

import evcot.scenes
from evcot.events import Events, Recording
from evcot.metrics.truth import GroundTruth
from field.member import Member, scene_rule

__all__ = ["FOLDER", "kept"]

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
    for source in (*sorted(scenes.glob("*.py")), *(here / f"{name}.py" for name in ("kept", "member", *makers))):
        digest.update(source.read_bytes())
    return digest.hexdigest()

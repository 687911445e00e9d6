# SPDX-License-Identifier: Apache-2.0
"""Two recordings of one object each, a pendulum and a hand, whose paths `reference` finds offline; as they are and changed.

`python benchmarks/field_of_tests.py --references` writes the paths, and pictures to look at, to build/field.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import lru_cache

from evcot.events import Recording
from evcot.recordings.files import read_recording
from field.member import TRUTH_STEP_US, Absent, Entry, Member, scene_rule
from field.reference import Reference, Scale, reference
from field.transforms import at_speed, backwards, transposed
from shared import SHARED

__all__ = ["RECORDED", "entries", "recorded", "reference_of"]

RECORDED: Mapping[str, tuple[str, Scale]] = {
    "pendulum": ("pendulum_dvs128.aedat", Scale(size_px=16, window_us=30_000, neighbours=5)),
    "hand": ("hand_dvs128.aedat4", Scale(size_px=45, window_us=60_000, neighbours=8)),
}

Change = Callable[[Member], Member]

_CHANGES: Mapping[str, Change] = {
    "as recorded": lambda member: member,
    "backwards": backwards,
    "transposed": transposed,
    "x 2": lambda member: at_speed(member, 2),
}


def recorded(name: str) -> Recording:
    """One of `RECORDED`."""
    path = SHARED / RECORDED[name][0]
    if not path.is_file():
        raise Absent(f"{path.name} is not in {SHARED}")
    return read_recording(path)


@lru_cache(maxsize=2)
def reference_of(name: str) -> Reference:
    """The reference path of one of `RECORDED`."""
    return reference(recorded(name), RECORDED[name][1], TRUTH_STEP_US)


def entries(_seed: int, quick: bool) -> Iterator[Entry]:
    """Two families."""
    for family in RECORDED:
        for name, change in list(_CHANGES.items())[: 1 if quick else None]:
            yield Entry(f"{family}, recorded", name, family, _builder(family, name, change))


def _builder(family: str, name: str, change: Change) -> Callable[[], Member]:
    def build() -> Member:
        recording, path = recorded(family), reference_of(family)
        how = f"found offline, looking ahead; {path.error}"
        member = Member(f"{family}, recorded", name, recording, path.truth(), scene_rule(recording), how)
        return replace(change(member), name=name)

    return build

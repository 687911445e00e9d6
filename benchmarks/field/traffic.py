# SPDX-License-Identifier: Apache-2.0
"""The recorded motorway, its hot pixel left in: as it is, and changed in space, in time, by loss and noise, and crowded."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace

from evcot.metrics import load_rule, read_truth
from evcot.recordings.files import read_recording
from field.member import Absent, Entry, Member
from field.transforms import (
    at_speed,
    backwards,
    doubled,
    halved,
    noisy,
    spliced,
    thinned,
    transposed,
    upside_down,
)
from shared import SHARED

__all__ = ["SOURCE", "entries", "traffic"]

SOURCE = "traffic_outbound"
_FILES = f"{SOURCE}.aedat4", f"{SOURCE}_gt.csv"
_CROWD_PX = (40, 40)  # cars of the one between the cars of the other: 3 % of a box lies in another
_OBTAINED = "boxes that came with the recording, a frame every 40 ms"

Change = Callable[[Member], Member]


def traffic() -> Member:
    """The recording as it is."""
    recording, truth = (SHARED / name for name in _FILES)
    for path in (recording, truth):
        if not path.is_file():
            raise Absent(f"{path.name} is not in {SHARED}")
    rule = load_rule("traffic")
    return Member("traffic, space", "as recorded", read_recording(recording), read_truth(truth, rule), rule, _OBTAINED)


def _oncoming(member: Member) -> Member:
    return spliced(member, upside_down(member), (member.recording.width, 0))


def entries(seed: int, quick: bool) -> Iterator[Entry]:
    """Four families."""
    random = (seed, 1)  # of what is drawn: which events are lost or added
    families: dict[str, Mapping[str, Change]] = {
        "traffic, space": {
            "as recorded": lambda member: member,
            "upside down": upside_down,
            "transposed": transposed,
            "half the size": halved,
            "twice the size": lambda member: doubled(member, random),
        },
        "traffic, time": {
            "backwards": backwards,
            "x 0.25": lambda member: at_speed(member, 0.25),
            "x 0.5": lambda member: at_speed(member, 0.5),
            "x 2": lambda member: at_speed(member, 2),
            "x 4": lambda member: at_speed(member, 4),
        },
        "traffic, loss and noise": {
            "30 % lost": lambda member: thinned(member, 0.3, random),
            "60 % lost": lambda member: thinned(member, 0.6, random),
            "1 Hz a pixel": lambda member: noisy(member, 1, random),
            "5 Hz a pixel": lambda member: noisy(member, 5, random),
        },
        "traffic, crowd": {
            "two, 40 px apart": lambda member: spliced(member, member, _CROWD_PX),
            "oncoming beside it": _oncoming,
        },
    }
    for family, changes in families.items():
        for name, change in list(changes.items())[: 1 if quick else None]:
            yield Entry(family, name, SOURCE, _builder(family, name, change))


def _builder(family: str, name: str, change: Change) -> Callable[[], Member]:
    def build() -> Member:
        changed = change(traffic())
        how = _OBTAINED if name == "as recorded" else f"{_OBTAINED}, changed exactly as the events"
        return replace(changed, family=family, name=name, obtained=how)

    return build

# SPDX-License-Identifier: Apache-2.0
"""A field of recordings with known truth, in families, so that a tracker is tried on what it was not tuned on.

Example:
    from field import members

    for member in members(seed_set=1):
        log = evcot.track(member.recording)
        evcot.evaluate(log, member.truth, member.rule)
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from field import digits, hard, recorded, second, simulated, traffic
from field.member import Absent, Entry, Member

__all__ = ["Absent", "Entry", "Member", "entries", "members"]

_PARTS = (traffic, recorded, digits, simulated, second, hard)


def entries(seed_set: int, quick: bool = False) -> list[Entry]:
    """All members, not built yet, family by family. Equal seed sets give identical members; quick: one or few a family."""
    return [entry for part in _PARTS for entry in part.entries(seed_set, quick)]


def members(seed_set: int, families: Iterable[str] | None = None, quick: bool = False) -> Iterator[Member]:
    """The members, each built when it is asked for; what is made of recordings or packages that are absent is left out.

    Args:
        families: their names; None: all.
    """
    chosen = None if families is None else set(families)
    for entry in entries(seed_set, quick):
        if chosen is None or entry.family in chosen:
            try:
                member = entry.build()
            except Absent:
                continue
            yield member

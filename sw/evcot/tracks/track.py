# SPDX-License-Identifier: Apache-2.0
"""The tracks of a log as objects: when each was born and ended, its path, and its box at any time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, overload

import numpy as np
from numpy.typing import NDArray

from ..dataframes import Columns, Tabular
from .record import Kind

__all__ = ["Box", "Track", "Tracks"]


class Box(NamedTuple):
    """A track's box: centre and sides in pixels, 0 at the middle of the first pixel; angle in rad, as of `TrackLog.records`."""

    x: float
    y: float
    width: float
    height: float
    angle: float


@dataclass(frozen=True, eq=False)
class Track:
    """One track, from its birth to its last record. While it is lost before it is found again, it has no box.

    Attributes:
        records: (k,) of dtype `TRACK`, all that the log has of it, in time order.
    """

    records: NDArray[np.void]

    def __repr__(self) -> str:
        end = "still alive" if self.ended_us is None else f"ended at {self.ended_us:,} us"
        into = "" if self.merged_into is None else f" in {self.merged_into}"
        return f"<Track {self.id}: born at {self.born_us:,} us, {end}{into}, {len(self.path):,} states>"

    @property
    def id(self) -> int:
        """Its `track_id`; narrow ids of hardware may be used again by a later track."""
        return int(self.records["track_id"][0])

    @property
    def born_us(self) -> int:
        """Time of its birth; in a log that was cut out of a longer one, of its first record."""
        return int(self.records["t_us"][0])

    @property
    def ended_us(self) -> int | None:
        """Time at which it was lost for good, or absorbed by another track; None: alive at the end of the log."""
        return int(self.records["t_us"][-1]) if _is_end(self.records["kind"][-1]) else None

    @property
    def merged_into(self) -> int | None:
        """Id of the track that absorbed it; None if none did."""
        return int(self.records["other_id"][-1]) if self.records["kind"][-1] == Kind.MERGED else None

    @property
    def path(self) -> NDArray[np.void]:
        """Its states, (k,) of dtype `TRACK`, in time order. Each holds until the next record."""
        states: NDArray[np.void] = self.records[~_is_end(self.records["kind"])]
        return states

    def box_at(self, t_us: int) -> Box | None:
        """The box at a time, after all records of that time; None before the birth, while it is lost, and from its end on."""
        last = int(np.searchsorted(self.records["t_us"], t_us, "right")) - 1
        if last < 0 or _is_end(self.records["kind"][last]):
            return None
        return Box(*(float(self.records[name][last]) for name in Box._fields))


class Tracks(Sequence[Track], Tabular):
    """The tracks of a log in order of birth; `TrackLog.tracks`.

    A data frame has one row per track: `id`, `born_us`, `ended_us` and `merged_into`, of which the last two may be missing.

    Args:
        records: (m,) of dtype `TRACK`, in time order, which do not change.
    """

    def __init__(self, records: NDArray[np.void]) -> None:
        order = np.argsort(records["track_id"], kind="stable")
        begins = records["kind"][order] == Kind.BORN
        begins[:1] = True
        begins[1:] |= np.diff(records["track_id"][order]) != 0
        first = np.flatnonzero(begins)
        end = np.append(first[1:], len(order))[: len(first)]
        in_time = np.argsort(order[first])
        self._records, self._order = records, order
        self._first, self._end = first[in_time], end[in_time]  # of each track, in `_order`

    def __len__(self) -> int:
        return len(self._first)

    @overload
    def __getitem__(self, which: int) -> Track: ...

    @overload
    def __getitem__(self, which: slice) -> list[Track]: ...

    def __getitem__(self, which: int | slice) -> Track | list[Track]:
        """The track at a place in the order of birth, which is not always its id; or several."""
        if isinstance(which, slice):
            return [self[place] for place in range(*which.indices(len(self)))]
        place = range(len(self))[which]
        return Track(self._records[self._order[self._first[place] : self._end[place]]])

    def __repr__(self) -> str:
        return f"<Tracks: {len(self):,}>"

    def _columns(self) -> Columns:
        first, last = (self._records[self._order[place]] for place in (self._first, self._end - 1))
        return {
            "id": first["track_id"],
            "born_us": first["t_us"],
            "ended_us": np.ma.masked_array(last["t_us"], ~_is_end(last["kind"])),
            "merged_into": np.ma.masked_array(last["other_id"], last["kind"] != Kind.MERGED),
        }


def _is_end(kind: NDArray[np.uint8]) -> NDArray[np.bool_]:
    return np.asarray((kind == Kind.LOST) | (kind == Kind.MERGED))

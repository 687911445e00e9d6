# SPDX-License-Identifier: Apache-2.0
"""TrackLog: the result of every engine, whether software, golden model or hardware."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from pkgutil import resolve_name
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..dataframes import Columns, Tabular
from . import PARQUET
from .log_files import save_log, write_csv, write_npz
from .npz import NpzFile
from .parquet import LogFile
from .record import DROPPED, TRACK, VERDICT, ClassNames, Kind, no_verdicts
from .track import Tracks

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..events import Recording

__all__ = ["DROPPED", "TRACK", "VERDICT", "Kind", "TrackLog"]

_RUN = 1 << 16


@dataclass(frozen=True, eq=False)
class TrackLog(Tabular):
    """Births, moves, merges and losses of all tracks, and the owner of each event; one row per record in a data frame, with the
    number of a `Kind` as `kind`.

    Attributes:
        engine: name of the engine that wrote it, such as "rct"; the module, such as "cot_motion", for RTL and golden model.
        records: (m,) of dtype `TRACK`, in chronological order. `kind` is a `Kind`. `event_index` is
            the event that caused the record; for LOST, which is caused by a timeout, the next event, so that all records with
            event_index <= i give the state after event i. `other_id` is the survivor of a MERGED track, else -1.
            `t_us` is in the recording's microseconds. `x`, `y` is the position, in pixels, 0 at the middle of the first pixel;
            `width`, `height` are the sides of the object's box, which is centred there, by the extent of the object, in pixels;
            `angle` is that of the box's width against the sensor's rows, from x towards y, in rad, 0 for engines whose boxes do
            not turn. `radius` is half the side of the engine's search window, in pixels. `vx`, `vy` is the velocity in pixels
            per second, 0 until it is known. `confidence` is from 0 to 1: e / (e + e0), where e is the evidence for the object
            and e0 the evidence from which on the engine makes an object visible.
        owner: (n,) int16, one per event: the slot that took it, -1 if none did, -2 if a
            filter dropped it.
        recording: the fingerprint of the events (`digest.digest`); empty if it was not computed.
        verdicts: (k,) of dtype `VERDICT`, in chronological order: the classes of tracks, if the tracker had a classifier.
        class_names: the names of these classes by number; a class without a name is shown by its number.
    """

    engine: str
    records: NDArray[np.void]
    owner: NDArray[np.int16]
    recording: str = ""
    verdicts: NDArray[np.void] = field(default_factory=no_verdicts)
    class_names: ClassNames = field(default_factory=dict)

    @classmethod
    def empty(cls, engine: str) -> TrackLog:
        """A log without events or records."""
        return cls(engine, np.empty(0, TRACK), np.empty(0, np.int16))

    def of_kind(self, kind: Kind) -> NDArray[np.void]:
        """The records of one kind, (k,) of dtype `TRACK`."""
        chosen: NDArray[np.void] = self.records[self.records["kind"] == kind]
        return chosen

    @cached_property
    def tracks(self) -> Tracks:
        """The tracks as objects, in order of birth."""
        return Tracks(self.records)

    def plot(self, recording: Recording | None = None, panels: Sequence[str] = ("tracks",)) -> Figure:
        """Draw the tracks as a figure of Matplotlib, which a notebook shows; `evcot.plot` writes one with several logs.

        Args:
            recording: the recording of the log, whose events are drawn in grey; None: the tracks alone.
            panels: names of `evcot plot --kind`, from top to bottom.

        Raises:
            ConfigError: no such panel, or the log has more events than the recording.
        """
        figure: Figure = resolve_name("evcot.pictures.picture:log_figure")(self, recording, panels)
        return figure

    def _repr_html_(self) -> str:
        """The log in a notebook: a line, and a picture of its tracks."""
        shown: str = resolve_name("evcot.pictures.picture:log_html")(self)
        return shown

    def _columns(self) -> Columns:
        return {name: self.records[name] for name in TRACK.names or ()}

    def record_runs(self) -> Iterator[NDArray[np.void]]:
        """All records, run by run, as `reading.RecordRuns`."""
        for begin in range(0, len(self.records), _RUN):
            yield self.records[begin : begin + _RUN]

    def count_owners(self) -> int:
        """Number of owners."""
        return len(self.owner)

    def __repr__(self) -> str:
        tracks = len(self.of_kind(Kind.BORN))
        return f"<TrackLog {self.engine}: {tracks:,} tracks, {len(self.records):,} records, {len(self.owner):,} events>"

    def save(self, path: Path | str, *, force: bool = False) -> None:
        """Write the log in the format of the suffix: .npz, .parquet, or .csv, which has no owners and cannot be read again.

        Raises:
            OutputError: an unknown suffix, the file exists (without `force`), or it cannot be written.
            TrackLogError: pyarrow is not installed.
        """
        save_log(self, path, force=force)

    @classmethod
    def load(cls, path: Path | str, *, owners: bool = True) -> TrackLog:
        """Read a log that `save` wrote.

        Args:
            owners: False leaves them out of a Parquet file's log, most of the memory of a long one.

        Raises:
            TrackLogError: the file is missing, damaged, or not a TrackLog.
        """
        if Path(path).suffix.lower() != PARQUET:
            return cls.load_npz(path)
        file = LogFile(path)
        return cls(file.engine, *file.read(owners=owners), file.recording, file.verdicts, file.class_names)

    def save_npz(self, path: Path | str, *, force: bool = False) -> None:
        """Write the log, compressed; equal logs give identical files.

        Args:
            force: replace a file that exists.

        Raises:
            OutputError: the file exists, or cannot be written.
        """
        write_npz(self, path, force=force)

    @classmethod
    def load_npz(cls, path: Path | str) -> TrackLog:
        """Read a log written by `save_npz`.

        Raises:
            TrackLogError: the file is missing, damaged, or not a TrackLog.
        """
        file = NpzFile(path)
        return cls(file.engine, *file.read(), file.recording, file.verdicts, file.class_names)

    def write_csv(self, path: Path | str, *, force: bool = False) -> None:
        """Write the records as CSV: a header, kinds by name, every number with the fewest digits that round-trip exactly.

        Args:
            force: replace a file that exists.

        Raises:
            OutputError: the file exists, or cannot be written.
        """
        write_csv(self, path, force=force)

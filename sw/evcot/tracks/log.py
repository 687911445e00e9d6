# SPDX-License-Identifier: Apache-2.0
"""TrackLog: what every engine returns, whether it is software, model or hardware."""

from __future__ import annotations

import zipfile
import zlib
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import TrackLogError
from ..outputs import note_input, written_aside

__all__ = ["DROPPED", "TRACK", "Kind", "TrackLog"]

DROPPED = -2  # owner of an event that a filter took out; -1 is one that passed through all trackers


class Kind(IntEnum):
    """What a record of the TrackLog tells."""

    BORN = 0
    MOVED = 1
    MERGED = 2
    LOST = 3


TRACK = np.dtype(
    [
        ("t_us", "<i8"),
        ("event_index", "<i8"),
        ("kind", "u1"),
        ("track_id", "<i8"),
        ("slot", "<i2"),
        ("x", "<f8"),
        ("y", "<f8"),
        ("radius", "<f8"),
        ("n_ev", "<i4"),
        ("support", "<i8"),
        ("other_id", "<i8"),
    ]
)

# What a file holds: array -> its dtype, None for text, and how many dimensions it has.
_ARRAYS: dict[str, tuple[np.dtype[Any] | None, int]] = {
    "engine": (None, 0),
    "recording": (None, 0),
    "records": (TRACK, 1),
    "owner": (np.dtype(np.int16), 1),
}

_CSV_ROWS = 1 << 16  # formatted at a time


@dataclass(frozen=True, eq=False)
class TrackLog:
    """Births, moves, merges and losses of all tracks, and who took each event.

    Attributes:
        engine: name of the engine that wrote it: "rct", "cot-model" or "cot-rtl".
        records: (m,) of dtype `TRACK`, in the order in which they happened. `kind` is a `Kind`. `event_index` is
            the event that caused the record; for LOST, which time causes, the next event, so that "everything with
            event_index <= i" is the state after event i. `other_id` is the survivor of a MERGED track, else -1.
            `x`, `y`, `radius` in pixels, `t_us` in the recording's microseconds.
        owner: (n,) int16, one per event: the slot that took it, -1 where it passed through, -2 where a
            filter took it out.
        recording: the fingerprint of the events (`digest.digest`); empty where nobody took it.
    """

    engine: str
    records: NDArray[np.void]
    owner: NDArray[np.int16]
    recording: str = ""

    @classmethod
    def empty(cls, engine: str) -> TrackLog:
        """The log of an engine that saw nothing."""
        return cls(engine, np.empty(0, TRACK), np.empty(0, np.int16))

    def of_kind(self, kind: Kind) -> NDArray[np.void]:
        """The records of one kind, (k,) of dtype `TRACK`."""
        chosen: NDArray[np.void] = self.records[self.records["kind"] == kind]
        return chosen

    def save_npz(self, path: Path | str, *, force: bool = False) -> None:
        """Write the log, compressed; the same log gives the same bytes.

        Args:
            force: replace a file that exists.

        Raises:
            OutputError: the file exists, or cannot be written.
        """
        arrays = {"engine": np.array(self.engine), "records": self.records, "owner": self.owner}
        if self.recording:
            arrays["recording"] = np.array(self.recording)
        with written_aside(Path(path), force=force) as file:
            np.savez_compressed(file, allow_pickle=False, **arrays)

    @classmethod
    def load_npz(cls, path: Path | str) -> TrackLog:
        """Read what `save_npz` wrote.

        Raises:
            TrackLogError: the file is missing, damaged, or no TrackLog.
        """
        note_input(path)
        try:
            with open(path, "rb") as file:
                if not zipfile.is_zipfile(file):
                    raise TrackLogError(f"{path}: is not an npz file, or is cut off")
                # The array reader trusts what it is given: whether that is whole must be known before.
                with zipfile.ZipFile(file) as archive:
                    damaged = archive.testzip()
                if damaged:
                    raise TrackLogError(f"{path}: is damaged: wrong checksum of {damaged}")
                file.seek(0)
                with np.load(file, allow_pickle=False) as content:
                    stored = {name: content[name] for name in content.files}
        except OSError as error:
            raise TrackLogError(f"{path}: cannot be read: {error.strerror or error}") from error
        except TrackLogError:
            raise
        except (zipfile.BadZipFile, zlib.error, EOFError, ValueError, RuntimeError) as error:
            raise TrackLogError(f"{path}: is damaged: {' '.join(str(error).split()) or 'ends too soon'}") from error
        stored.setdefault("recording", np.array(""))
        for name, (dtype, ndim) in _ARRAYS.items():
            array = stored.get(name)
            if array is None:
                raise TrackLogError(f"{path}: has no array {name}: must have engine, records, owner")
            if array.ndim != ndim or (array.dtype.kind != "U" if dtype is None else array.dtype != dtype):
                raise TrackLogError(f"{path}: {name} is {array.ndim}-d {array.dtype}: must be {ndim}-d {dtype or 'text'}")
        return cls(str(stored["engine"]), stored["records"], stored["owner"], str(stored["recording"]))

    def write_csv(self, path: Path | str, *, force: bool = False) -> None:
        """Write the records as CSV: a header, kinds by name, every number in the fewest digits that give it back exactly.

        Args:
            force: replace a file that exists.

        Raises:
            OutputError: the file exists, or cannot be written.
        """
        names = np.array([kind.name for kind in Kind])
        with written_aside(Path(path), force=force) as file:
            file.write((",".join(TRACK.names or ()) + "\n").encode())
            for begin in range(0, len(self.records), _CSV_ROWS):
                rows = self.records[begin : begin + _CSV_ROWS]
                columns = [
                    names[rows["kind"]].tolist() if name == "kind" else [repr(value) for value in rows[name].tolist()]
                    for name in TRACK.names or ()
                ]
                file.write("".join(",".join(row) + "\n" for row in zip(*columns, strict=True)).encode())

# SPDX-License-Identifier: Apache-2.0
"""Track logs as npz files, which `writing.write_npz` writes: their arrays, whole or run by run."""

from __future__ import annotations

import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from ..errors import TrackLogError
from ..outputs import note_input
from . import CSV
from .record import TRACK, VERDICT, class_names_from, no_verdicts

__all__ = ["NpzFile"]

_ROWS = 1 << 16  # read at a time
_OWNER = np.dtype(np.int16)

# Arrays in a file: name -> dtype, None for text, and number of dimensions.
_ARRAYS: dict[str, tuple[np.dtype[Any] | None, int]] = {
    "engine": (None, 0),
    "recording": (None, 0),
    "records": (TRACK, 1),
    "owner": (_OWNER, 1),
    "verdicts": (VERDICT, 1),
    "class_names": (None, 0),
}
_OPTIONAL = "recording", "verdicts", "class_names"


class NpzFile:
    """A log as an npz file.

    Attributes:
        path, engine, recording, class_names: the file; as of `TrackLog`.

    Raises:
        TrackLogError: the file is missing, damaged, or not a TrackLog.
    """

    def __init__(self, path: Path | str) -> None:
        self.path = Path(path)
        note_input(path)
        said = {"engine": "", "recording": "", "class_names": "{}"}
        self._lengths: dict[str, int] = {}
        with self._opened() as archive:
            # The array reader trusts its input, so the checksum must be verified before.
            damaged = archive.testzip()
            if damaged:
                raise TrackLogError(f"{path}: is damaged: wrong checksum of {damaged}")
            there = {name.removesuffix(".npy") for name in archive.namelist()}
            for name, (dtype, ndim) in _ARRAYS.items():
                if name not in there:
                    if name in _OPTIONAL:
                        continue
                    raise TrackLogError(f"{path}: has no array {name}: must have engine, records, owner")
                with archive.open(f"{name}.npy") as member:
                    shape, found = _header(member)
                    self._check(name, shape, found, dtype, ndim)
                    if dtype is None:
                        said[name] = str(np.frombuffer(member.read(), found)[0]) if found.itemsize else ""
                    else:
                        self._lengths[name] = shape[0]
        self.engine, self.recording = said["engine"], said["recording"]
        self.class_names = class_names_from(said["class_names"], self.path)

    def _check(self, name: str, shape: tuple[int, ...], found: np.dtype[Any], dtype: np.dtype[Any] | None, ndim: int) -> None:
        lacking = [field for field in (dtype.names if dtype else None) or () if field not in (found.names or ())]
        if found.names and lacking:
            rule = "must be a log of this version: track the recording again"
            raise TrackLogError(f"{self.path}: {name} lacks {', '.join(lacking)}: {rule}")
        if len(shape) != ndim or (found.kind != "U" if dtype is None else found != dtype):
            raise TrackLogError(f"{self.path}: {name} is {len(shape)}-d {found}: must be {ndim}-d {dtype or 'text'}")

    def record_runs(self) -> Iterator[NDArray[np.void]]:
        """All records, run by run; every call gives them again."""
        yield from self._runs("records", TRACK)

    def count_owners(self) -> int:
        """Number of owners, one for each event."""
        return self._lengths["owner"]

    def owner_runs(self) -> Iterator[NDArray[np.int16]]:
        """All owners, run by run; every call gives them again."""
        yield from self._runs("owner", _OWNER)

    def read(self) -> tuple[NDArray[np.void], NDArray[np.int16]]:
        """All records and owners, in memory."""
        records, owner = np.empty(self._lengths["records"], TRACK), np.empty(self._lengths["owner"], _OWNER)
        for name, whole in (("records", records), ("owner", owner)):
            done = 0
            for run in self._runs(name, whole.dtype):
                whole[done : done + len(run)] = run
                done += len(run)
        return records, owner

    @property
    def verdicts(self) -> NDArray[np.void]:
        """See `TrackLog`."""
        return np.concatenate([no_verdicts(), *(self._runs("verdicts", VERDICT) if "verdicts" in self._lengths else [])])

    def _runs(self, name: str, dtype: np.dtype[Any]) -> Iterator[NDArray[Any]]:
        left = self._lengths[name]
        with self._opened() as archive, archive.open(f"{name}.npy") as member:
            _header(member)
            while left:
                count = min(left, _ROWS)
                data = member.read(count * dtype.itemsize)
                if len(data) < count * dtype.itemsize:
                    raise TrackLogError(f"{self.path}: is damaged: {name} ends too soon")
                yield np.frombuffer(data, dtype).copy()
                left -= count

    @contextmanager
    def _opened(self) -> Iterator[zipfile.ZipFile]:
        try:
            with open(self.path, "rb") as file:
                if not zipfile.is_zipfile(file):
                    if self.path.suffix.lower() == CSV:
                        rule = "must be the .npz or .parquet log of the same run"
                        raise TrackLogError(f"{self.path}: CSV has records alone, without owners: {rule}")
                    raise TrackLogError(f"{self.path}: is not an npz file, or is cut off")
                with zipfile.ZipFile(file) as archive:
                    yield archive
        except OSError as error:
            raise TrackLogError(f"{self.path}: cannot be read: {error.strerror or error}") from error
        except TrackLogError:
            raise
        except (zipfile.BadZipFile, zlib.error, EOFError, ValueError, RuntimeError) as error:
            raise TrackLogError(f"{self.path}: is damaged: {' '.join(str(error).split()) or 'ends too soon'}") from error


def _header(member: IO[bytes]) -> tuple[tuple[int, ...], np.dtype[Any]]:
    version = np.lib.format.read_magic(member)
    read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    shape, _, dtype = read(member)
    return shape, dtype

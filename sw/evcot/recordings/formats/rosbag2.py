# SPDX-License-Identifier: Apache-2.0
"""ROS 2 bags: a directory with metadata.yaml, or one of its files, MCAP or SQLite; read by the library `rosbags`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ...errors import RecordingError
from .packing import Lz4Unpacker, ZstdUnpacker
from .printable import printable, reason

__all__ = ["MCAP_MAGIC", "METADATA", "SQLITE_MAGIC", "Bag2"]

MCAP_MAGIC = b"\x89MCAP0\r\n"
SQLITE_MAGIC = b"SQLite format 3\0"
METADATA = "metadata.yaml"
# The library holds chunks and messages in memory; a bag in one compressed file is decompressed to disk.
_UNPACKED_BYTES_MAX = 1 << 28
_RATIO_MAX = 200
_METADATA_BYTES_MAX = 1 << 20


class Bag2:
    """An open bag.

    Attributes:
        topics: name -> message type, of all topics.
        remarks: see `rosbag1.Bag1`.
    """

    is_cdr = True

    def __init__(self, path: Path) -> None:
        self.remarks: list[str] = []
        with _damage_named("cannot be opened as a ROS 2 bag"):
            self._reader = _reader(path)(path)
            self._reader.open()
            self._connections = [each for each in self._reader.connections if isinstance(each.topic, str)]
            self.topics = {each.topic: printable(str(each.msgtype)).replace("/msg/", "/") for each in self._connections}

    def messages(self, topic: str) -> Iterator[memoryview]:
        """The messages of a topic, in the order of the times at which they were recorded.

        Raises:
            RecordingError: at a damaged place; or at the end, if the bag's metadata have a different number of messages.
        """
        chosen = [each for each in self._connections if each.topic == topic]
        seen = 0
        with _damage_named("is damaged"):
            messages = iter(self._reader.messages(chosen))
        while True:
            with _damage_named(f"topic {printable(topic)}: is damaged after message {seen}"):
                message = next(messages, None)
                data = message and memoryview(message[2])  # in SQLite, a column need not be bytes
            if data is None:
                break
            seen += 1
            yield data
        expected = sum(each.msgcount for each in chosen)
        counts = f"topic {printable(topic)}: {seen} messages, of which the bag counts {expected}"
        if seen < expected:
            raise RecordingError(f"{counts}: must not be fewer")
        self.remarks = [f"{counts}: all are read"] if 0 < expected < seen else []

    def close(self) -> None:
        """Close the files."""
        self._reader.close()


@contextmanager
def _damage_named(what: str) -> Iterator[None]:
    """Convert any exception of the library to a RecordingError: it checks little, so damage raises exceptions of every kind."""
    try:
        yield
    except PermissionError:
        raise
    except Exception as error:
        raise RecordingError(f"{what}: {reason(error)}") from error


class _BoundedZstd:
    """The part of Python's module zstd that the library uses, with bounded output."""

    @staticmethod
    def decompress(data: bytes) -> bytes:
        """The content of one frame."""
        return ZstdUnpacker().whole(data, _UNPACKED_BYTES_MAX)

    @staticmethod
    def open(file: Any, _: str) -> Any:
        """Open a compressed file for reading its content."""
        return _BoundedFile(file)


class _BoundedFile:
    """A compressed file whose content is limited to a multiple of its size. Use as a context manager."""

    def __init__(self, file: Any) -> None:
        size = file.seek(0, 2)
        file.seek(0)
        self._most = self._left = size * _RATIO_MAX + _UNPACKED_BYTES_MAX
        self._pieces = ZstdUnpacker().pieces(file)

    def __enter__(self) -> _BoundedFile:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def read(self, _: int = -1) -> bytes:
        """The next piece, of bounded size."""
        piece = next(self._pieces, b"")
        self._left -= len(piece)
        if self._left < 0:
            raise RecordingError(f"a packed file unpacks to more than {self._most} bytes: must be at most that")
        return piece


def _bound_library() -> None:
    """Patch the library, which decompresses without any limit, to use the bounded decompressor."""
    from rosbags.rosbag2 import reader, storage_mcap

    storage_mcap.DECOMPRESSORS["lz4"] = lambda data, _: Lz4Unpacker().whole(data, _UNPACKED_BYTES_MAX)
    storage_mcap.DECOMPRESSORS["zstd"] = lambda data, _: ZstdUnpacker().whole(data, _UNPACKED_BYTES_MAX)
    setattr(reader, "zstd", _BoundedZstd)  # noqa: B010  (to the type checker, a module)


def _reader(path: Path) -> Callable[[Path], Any]:
    """The library's reader for a file, chosen by its content."""
    _bound_library()
    if path.is_dir():
        size = (path / METADATA).stat().st_size
        if size > _METADATA_BYTES_MAX:
            raise RecordingError(f"{METADATA} of {size} bytes: must be at most {_METADATA_BYTES_MAX}")
        from rosbags.rosbag2.reader import DirectoryReader

        return DirectoryReader
    with path.open("rb") as file:
        start = file.read(len(SQLITE_MAGIC))
    if start.startswith(MCAP_MAGIC):
        from rosbags.rosbag2.storage_mcap import McapReader

        return McapReader
    from rosbags.rosbag2.storage_sqlite3 import Sqlite3Reader

    return Sqlite3Reader

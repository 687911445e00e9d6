# SPDX-License-Identifier: Apache-2.0
"""ROS 2 bags: a directory with metadata.yaml, or one of its files, MCAP or SQLite; read by the library `rosbags`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ...errors import RecordingError
from .printable import printable, reason

__all__ = ["MCAP_MAGIC", "METADATA", "SQLITE_MAGIC", "Bag2"]

MCAP_MAGIC = b"\x89MCAP0\r\n"
SQLITE_MAGIC = b"SQLite format 3\0"
METADATA = "metadata.yaml"


class Bag2:
    """An open bag.

    Attributes:
        topics: name -> kind of message, of all topics.
    """

    is_cdr = True

    def __init__(self, path: Path) -> None:
        with _damage_told("cannot be opened as a ROS 2 bag"):
            self._reader = _reader(path)(path)
            self._reader.open()
            self._connections = [each for each in self._reader.connections if isinstance(each.topic, str)]
            self.topics = {each.topic: printable(str(each.msgtype)).replace("/msg/", "/") for each in self._connections}

    def messages(self, topic: str) -> Iterator[memoryview]:
        """The messages of a topic, in the order of the times at which they were recorded.

        Raises:
            RecordingError: at a damaged place; or at the end, when the bag counts another number of messages.
        """
        chosen = [each for each in self._connections if each.topic == topic]
        seen = 0
        with _damage_told("is damaged"):
            messages = iter(self._reader.messages(chosen))
        while True:
            with _damage_told(f"topic {printable(topic)}: is damaged after message {seen}"):
                message = next(messages, None)
                data = message and memoryview(message[2])  # in a table, it need not be bytes
            if data is None:
                break
            seen += 1
            yield data
        expected = sum(each.msgcount for each in chosen)
        if seen != expected:
            raise RecordingError(
                f"topic {printable(topic)}: {seen} messages, of which the bag counts {expected}: must be the same"
            )

    def close(self) -> None:
        """Close the files."""
        self._reader.close()


@contextmanager
def _damage_told(what: str) -> Iterator[None]:
    """A RecordingError for whatever the library makes of damage: it checks little, and so raises errors of every kind."""
    try:
        yield
    except PermissionError:
        raise
    except Exception as error:
        raise RecordingError(f"{what}: {reason(error)}") from error


def _reader(path: Path) -> Callable[[Path], Any]:
    """The library's reader for a file, by its content."""
    if path.is_dir():
        from rosbags.rosbag2.reader import DirectoryReader

        return DirectoryReader
    with path.open("rb") as file:
        start = file.read(len(SQLITE_MAGIC))
    if start.startswith(MCAP_MAGIC):
        from rosbags.rosbag2.storage_mcap import McapReader

        return McapReader
    from rosbags.rosbag2.storage_sqlite3 import Sqlite3Reader

    return Sqlite3Reader

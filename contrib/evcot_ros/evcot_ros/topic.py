# SPDX-License-Identifier: Apache-2.0
"""The packets of a topic as a source of a live session; nothing here needs ROS."""

from __future__ import annotations

import queue
from collections import Counter
from collections.abc import Callable, Iterator
from typing import Any

from evcot.errors import RecordingError
from evcot.events import Events
from evcot.recordings.formats.ros_messages import Packet
from evcot.recordings.formats.ros_packets import PacketDecoder
from evcot_cosim.live.sources import StreamSource

__all__ = ["TopicSource"]

_WAITING_MAX = 1_000  # packets, seconds of any camera's
_WAIT_S = 0.05


class TopicSource(StreamSource):
    """Events of `event_camera_msgs/EventPacket` messages. See `evcot_cosim.live.sources.LiveSource`.

    Args:
        name: of the topic.
        first: its first message, which says sensor and encoding; not yet put.

    Attributes:
        missed: packets given up because the session did not take them.

    Raises:
        RecordingError: an unknown encoding, or no sensor.
    """

    def __init__(self, name: str, first: Any) -> None:
        self._sensor, self._encoding = (int(first.width), int(first.height)), str(first.encoding)
        if not all(self._sensor):
            raise RecordingError(f"{name}: width, height = {first.width}, {first.height}: must be more than 0")
        try:
            self._decoder = PacketDecoder(self._encoding)
        except RecordingError as error:
            raise RecordingError(f"{name}: {error}") from error
        self._waiting: queue.Queue[Packet] = queue.Queue(_WAITING_MAX)
        self.missed = 0
        super().__init__(name, self._events, self._sensor, lambda: None)

    @property
    def dropped(self) -> Counter[str]:
        """What the decoder left out, by reason."""
        return self._decoder.left_out

    def put(self, message: Any) -> None:
        """Take a message; never blocks.

        Raises:
            RecordingError: its sensor or encoding is not that of the first.
        """
        kind = ((int(message.width), int(message.height)), str(message.encoding))
        if kind != (self._sensor, self._encoding):
            raise RecordingError(
                f"{self.name}: sensor and encoding are {kind}: must be {(self._sensor, self._encoding)}, as before"
            )
        order = ">" if message.is_bigendian else "<"
        packet = Packet(self._sensor, self._encoding, order, int(message.time_base), memoryview(bytes(message.events)))
        while True:
            try:
                return self._waiting.put_nowait(packet)
            except queue.Full:
                try:
                    self._waiting.get_nowait()
                    self.missed += 1
                except queue.Empty:
                    pass

    def _events(self, wanted: Callable[[], bool]) -> Iterator[Events]:
        while wanted():
            try:
                packet = self._waiting.get(timeout=_WAIT_S)
            except queue.Empty:
                continue
            try:
                yield from (events for events in self._decoder.decode(packet) if len(events))
            except RecordingError as error:
                raise RecordingError(f"{self.name}: {error}") from error

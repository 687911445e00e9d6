# SPDX-License-Identifier: Apache-2.0
"""Sources of live events: a file played at real speed, or a server on the network. (`camera` has the third.)"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from itertools import pairwise
from typing import Any, Protocol

import numpy as np

from evcot.errors import ConfigError, RecordingError
from evcot.events import Events, find_fault
from evcot.recordings.files import RecordingFile, sound
from evcot.recordings.formats.aedat4_stream import Aedat4Stream
from evcot.recordings.formats.source import Sensor

from .queues import Arrival

__all__ = ["CameraSource", "FileSource", "LiveSource", "NetworkSource", "StreamSource"]


_SLICE_S = 0.005  # a file's events come in packets of this length, as a camera sends them
_LATE_S = 0.1  # a file that cannot be read fast enough is played later and not all at once
_NAP_S = 0.05
_SILENCE_S = 60.0  # a longer wait for a file's next event is cut to this: a wrong clock may leave decades between two
_BACK_US = 1_000_000
_PAUSE_US = 1_000_000  # between the end of a file and its beginning again

Wanted = Callable[[], bool]


class LiveSource(Protocol):
    """Interface of a source of live events.

    Attributes:
        name: name for display.
        sensor: (width, height) in pixels.
        left_out: reason -> number of events left out for it.
    """

    @property
    def name(self) -> str: ...

    @property
    def sensor(self) -> Sensor: ...

    @property
    def left_out(self) -> Counter[str]: ...

    def arrivals(self, wanted: Wanted) -> Iterator[Arrival]:
        """Received events, in time order and on the sensor, until the source ends or `wanted` returns False.

        Raises:
            RecordingError: the received data is invalid.
        """
        ...

    def close(self) -> None:
        """Close the file or connection."""
        ...


class FileSource:
    """Plays a file. See `LiveSource`.

    Args:
        file: an open recording; closed with this.
        window: (from, to) in us after its first event.
        speed: seconds of the recording per second.
        loop: begin again at the end; time goes on, after a pause in which tracks end.

    Attributes:
        slipped_s: by how much the playback is late because the file could not be read fast enough.
        begin_s: where in the window the next call of `arrivals` begins.
        place_s: where in the window the last events lay.
        length_s: of the window; None as long as nobody has measured it.
    """

    def __init__(
        self, file: RecordingFile, window: tuple[int, int | None] = (0, None), speed: float = 1.0, *, loop: bool = False
    ) -> None:
        self.name = file.path.name
        self.sensor = file.sensor
        self.left_out: Counter[str] = Counter()
        self.slipped_s = self.begin_s = self.place_s = 0.0
        self.length_s: float | None = None
        self._file, self._window, self._speed, self._loop = file, window, speed, loop

    def arrivals(self, wanted: Wanted) -> Iterator[Arrival]:
        """See `LiveSource`; a packet's arrival is when its first event is due, and it is yielded when its last one is. The
        longest wait is a minute."""
        slice_us = max(1, round(_SLICE_S * self._speed * 1e6))
        window_us = self._file.t0_us + self._window[0]
        first_us = window_us + round(self.begin_s * 1e6)
        self.slipped_s, self.place_s = 0.0, self.begin_s
        start_s = time.perf_counter()
        for events, later_us in self._slices(first_us, slice_us):
            done = (int(events.t_us[-1]) - first_us) // slice_us + 1
            due_s = start_s + done * slice_us / self._speed / 1e6
            silence_s = due_s - time.perf_counter() - _SILENCE_S
            if silence_s > 0:
                start_s, due_s = start_s - silence_s, due_s - silence_s
            while (wait_s := due_s - time.perf_counter()) > 0:
                if not wanted():
                    return
                time.sleep(min(wait_s, _NAP_S))
            if -wait_s > _LATE_S:
                start_s, self.slipped_s = start_s - wait_s, self.slipped_s - wait_s
            if not wanted():
                return
            self.place_s = (int(events.t_us[-1]) - later_us - window_us) / 1e6
            yield Arrival(events, start_s + (int(events.t_us[0]) - first_us) / self._speed / 1e6)
        self.left_out = self._file.left_out

    def _slices(self, first_us: int, slice_us: int) -> Iterator[tuple[Events, int]]:
        """Packets, and by how much their times were moved: after the first pass, time goes on."""
        window_us = self._file.t0_us + self._window[0]
        later_us, last_us = 0, first_us
        from_us = self._window[0] + first_us - window_us
        while True:
            for block in self._file.blocks(from_us, self._window[1], required=from_us == self._window[0]):
                last_us = int(block.t_us[-1]) + later_us
                block = replace(block, t_us=block.t_us + later_us)
                number = (block.t_us - first_us) // slice_us
                cuts = [0, *(np.flatnonzero(np.diff(number)) + 1).tolist(), len(block)]
                for begin, end in pairwise(cuts):
                    yield block[begin:end], later_us
            if not self._loop:
                return
            later_us, from_us = last_us + _PAUSE_US - window_us, self._window[0]

    def close(self) -> None:
        """See `LiveSource`."""
        self._file.__exit__(None, None, None)


class StreamSource:
    """Packets from a sender without flow control. See `LiveSource`.

    Args:
        packets: iterator of packets as received; events that violate the rules of recordings are left out and counted.
        sensor: (width, height) in pixels.
        close: ends the connection.
    """

    def __init__(
        self, name: str, packets: Callable[[Wanted], Iterable[Events]], sensor: Sensor, close: Callable[[], None]
    ) -> None:
        self.name, self.sensor = name, sensor
        self.left_out: Counter[str] = Counter()
        self._packets, self._close = packets, close

    def arrivals(self, wanted: Wanted) -> Iterator[Arrival]:
        """See `LiveSource`; a packet's arrival is when it is complete."""
        width, height = self.sensor
        last_us = np.iinfo(np.int64).min
        for events in self._packets(wanted):
            arrived_s = time.perf_counter()
            if find_fault(events, width, height, last_us) is not None:
                if last_us - int(events.t_us[-1]) > _BACK_US:
                    raise RecordingError(
                        f"{self.name}: t = {events.t_us[-1]} us follows t = {last_us} us: must not run back by more than 1 s; "
                        "has the sender started again?"
                    )
                events = sound(events, width, height, last_us, self.left_out)
            if len(events):
                last_us = int(events.t_us[-1])
                yield Arrival(events, arrived_s)

    def close(self) -> None:
        """See `LiveSource`."""
        self._close()


class NetworkSource(StreamSource):
    """An AEDAT4 stream over TCP. See `LiveSource`.

    Args:
        address: host:port.
        sensor: (width, height) in pixels, overriding the server's.

    Raises:
        ConfigError: an invalid address, or the sensor is unknown.
        RecordingError: no server there, or it does not send such a stream.
    """

    def __init__(self, address: str, sensor: Sensor | None = None) -> None:
        host, colon, port = address.rpartition(":")
        if not (colon and host and port.isascii() and port.isdigit() and 0 < int(port) < 65536):
            raise ConfigError(f"tcp://{address}: must be tcp://HOST:PORT, the port from 1 to 65535")
        place = f"tcp://{address}"
        try:
            stream = Aedat4Stream(host.strip("[]"), int(port))
        except RecordingError as error:
            raise RecordingError(f"{place}: {error}") from error
        found = sensor or stream.sensor
        if found is None:
            stream.close()
            raise ConfigError(f"{place}: does not say what its sensor is: --sensor WxH must be given")
        super().__init__(
            f"{stream.name} at {place}", lambda wanted: _placed(stream.packets(wanted), place), found, stream.close
        )


def _placed(packets: Iterable[Events], place: str) -> Iterator[Events]:
    """The packets, with the server's address prefixed to error messages."""
    try:
        yield from packets
    except RecordingError as error:
        raise RecordingError(f"{place}: {error}") from error


_CAMERA_NAP_S = 0.001


class CameraSource(StreamSource):
    """The first camera found, or the one with a given serial number. See `sources.LiveSource`.

    Raises:
        ConfigError: dv-processing is not installed.
        RecordingError: no such camera.
    """

    def __init__(self, serial: str | None = None) -> None:
        try:
            import dv_processing  # type: ignore[import-not-found, unused-ignore]
        except ImportError as error:
            raise ConfigError("camera: dv-processing must be installed: pip install 'evcot[camera]'") from error
        found = [str(each.serialNumber) for each in dv_processing.io.camera.discover()]
        if not found:
            raise RecordingError("camera: none is connected, or this user may not open it")
        if serial is not None and serial not in found:
            raise RecordingError(f"camera:{serial}: is not connected: must be one of {', '.join(found)}")
        try:
            capture = dv_processing.io.camera.open(serial or found[0])
        except RuntimeError as error:
            raise RecordingError(f"camera:{serial or found[0]}: cannot be opened: {' '.join(str(error).split())}") from error
        width, height = capture.getEventResolution()
        super().__init__(capture.getCameraName(), lambda wanted: _batches(capture, wanted), (width, height), lambda: None)


def _batches(capture: Any, wanted: Callable[[], bool]) -> Iterator[Events]:
    """Batches of events from the camera's driver, until the camera is disconnected."""
    while wanted() and capture.isRunning():
        batch = capture.getNextEventBatch()
        if batch is None or not len(batch):
            time.sleep(_CAMERA_NAP_S)
            continue
        yield _events(batch.numpy())


def _events(batch: Any) -> Events:
    """Events of dv-processing's structured array: timestamp, x, y, polarity."""
    t_us, x, y = batch["timestamp"].astype(np.int64), batch["x"].astype(np.uint16), batch["y"].astype(np.uint16)
    return Events(t_us, x, y, batch["polarity"].astype(np.uint8))

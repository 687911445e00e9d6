# SPDX-License-Identifier: Apache-2.0
"""Host side of a board's serial line: bytes as levels of a line, register accesses, and reception of records. uart_host.v
defines the protocol.
"""

from __future__ import annotations

import struct
import time
from collections import deque
from collections.abc import Iterator
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evcot.errors import EvcotError
from evcot.hardware.contract import RECORD
from evcot.hardware.registers import BusError

__all__ = ["BAUD", "BYTE_BITS", "LinkError", "Receiver", "SerialHost", "levels", "request"]


BYTE_BITS = 10  # start bit, 8 data bits, lowest first, stop bit


def levels(data: bytes, clocks_per_bit: float, idle: int = 0) -> list[int]:
    """The line at every clock: each byte's bits, then `idle` clocks high. `clocks_per_bit` need not be an integer."""
    line: list[int] = []
    for value in data:
        begin = len(line)
        for i, bit in enumerate((0, *(value >> i & 1 for i in range(8)), 1)):
            line += [bit] * (round(begin + (i + 1) * clocks_per_bit) - len(line))
        line += [1] * idle
    return line


class Receiver:
    """Receives bytes from a line, sampling each bit in its middle.

    Attributes:
        received: the bytes so far.
        began: start clock of each byte, counted in calls of `sample`.
    """

    def __init__(self, divisor: int) -> None:
        self.received = bytearray()
        self.began: list[int] = []
        self._divisor = divisor
        self._clock = -1
        self._start = -1
        self._bits: list[int] = []

    def sample(self, level: int) -> None:
        """Sample the line at the next clock.

        Raises:
            AssertionError: a start bit is too short, or there is no stop bit.
        """
        self._clock += 1
        if self._start < 0:
            if level:
                return
            self._start = self._clock
        if (self._clock - self._start) % self._divisor == self._divisor // 2:
            self._bits.append(level)
        if len(self._bits) == BYTE_BITS:
            start, *data, stop = self._bits
            assert (start, stop) == (0, 1), f"clock {self._clock}: {self._bits} is not a valid byte"
            self.received.append(sum(bit << i for i, bit in enumerate(data)))
            self.began.append(self._start)
            self._start, self._bits = -1, []


def request(kind: str, address: int, value: int = 0) -> bytes:
    """A host's request of kind 'R' or 'W'."""
    return struct.pack("<cHI", kind.encode(), address, value)


BAUD = 1_000_000
_SILENCE_S = 0.02  # longer than the timeout of an incomplete request
_LONGEST_SEARCH = 400  # bytes, more than four frames have
_PAYLOAD = {b"r": 5, b"w": 5, b"c": RECORD.itemsize}  # bytes between the kind of a frame and its sum


class LinkError(EvcotError, OSError):
    """The line to a board cannot be opened, is silent, or carries invalid data."""


class SerialHost:
    """A board on a serial port; a transport for `evcot.hardware.register_access.Registers`.

    Args:
        port: device of the line, such as /dev/ttyUSB1, or any URL of pyserial.
        timeout_s: time limit of a response.

    Raises:
        LinkError: pyserial is not installed, or the port cannot be opened.
    """

    def __init__(self, port: str, timeout_s: float = 2.0) -> None:
        try:
            import serial
        except ImportError as error:
            raise LinkError("pyserial is not installed: pip install 'evcot[fpga]'") from error
        try:
            self._line: Any = serial.serial_for_url(port, BAUD, timeout=timeout_s)
        except (serial.SerialException, ValueError, OSError) as error:
            raise LinkError(f"{port}: cannot be opened: {error}") from error
        self._port = port
        self._timeout_s = timeout_s
        self._records: deque[bytes] = deque()
        self._seen = b""  # of a frame that is not whole
        self._in_step = False
        time.sleep(_SILENCE_S)

    def __enter__(self) -> SerialHost:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    def close(self) -> None:
        """Close the port."""
        self._line.close()

    def read(self, address: int) -> int:
        """The register at a byte address.

        Raises:
            BusError: there is none.
            LinkError: no response, or an invalid one.
        """
        return self._ask(b"R", address, 0)

    def write(self, address: int, value: int) -> None:
        """Write the register at a byte address; errors as `read`, and BusError if the hardware refuses the value."""
        self._ask(b"W", address, value)

    def records(self, count: int) -> NDArray[np.void]:
        """The next records, (count,) of dtype `contract.RECORD`, beginning with those received between responses.

        Raises:
            LinkError: the line is silent, or a frame is invalid.
        """
        while len(self._records) < count:
            self._records.append(self._frame(b"c"))
        return np.frombuffer(b"".join(self._records.popleft() for _ in range(count)), RECORD)

    def __iter__(self) -> Iterator[NDArray[np.void]]:
        """Endless iterator over single records, each of shape (1,)."""
        while True:
            yield self.records(1)

    def _ask(self, operation: bytes, address: int, value: int) -> int:
        self._line.write(struct.pack("<cHI", operation, address, value))
        self._line.flush()
        response, data = struct.unpack("<BI", self._frame(operation.lower()))
        if response:
            what = "read" if operation == b"R" else f"write of {value:#x}"
            raise BusError(f"{what} at {address:#06x}: the hardware refuses it")
        return int(data)

    def _frame(self, wanted: bytes) -> bytes:
        """The payload of the next frame of a kind; records before a response are stored."""
        deadline = time.monotonic() + self._timeout_s
        while True:
            kind, payload = self._next()
            if kind == wanted:
                return payload
            if kind == b"c":
                self._records.append(payload)
            elif time.monotonic() > deadline:
                raise LinkError(f"{self._port}: responses without a request")

    def _next(self) -> tuple[bytes, bytes]:
        """The next frame: kind and payload. A port may be opened in the middle of a frame: bytes before the first valid frame
        are skipped."""
        for _ in range(_LONGEST_SEARCH):
            kind = self._bytes(1)
            length = _PAYLOAD.get(kind, 0)
            frame = self._bytes(length + 2) if length else b""
            if length and sum(frame[:-1]) & 0xFF == frame[-1]:
                self._seen, self._in_step = self._seen[length + 2 :], True
                return kind, frame[1:-1]
            if self._in_step and length:
                raise LinkError(f"{self._port}: a frame of kind {kind.decode()} is broken: its sum is wrong")
            if self._in_step:
                raise LinkError(f"{self._port}: byte 0x{kind.hex()} begins no frame: must be one of r, w, c")
            self._seen = self._seen[1:]
        raise LinkError(f"{self._port}: no frame in {_LONGEST_SEARCH} bytes: is that a board, at {BAUD} baud?")

    def _bytes(self, end: int) -> bytes:
        """The first bytes that have not been decoded yet; waits for them."""
        if len(self._seen) < end:
            self._seen += self._line.read(end - len(self._seen))
        if len(self._seen) < end:
            raise LinkError(f"{self._port}: nothing within {self._timeout_s:g} s: is the board on, and at {BAUD} baud?")
        return self._seen[:end]

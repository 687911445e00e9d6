# SPDX-License-Identifier: Apache-2.0
"""Serial line: encoding of bytes as line levels, clock by clock, decoding, and the requests of a host to uart_host.v."""

from __future__ import annotations

import struct

__all__ = ["BYTE_BITS", "Receiver", "levels", "request"]

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

# SPDX-License-Identifier: Apache-2.0
"""A serial line: bytes as the levels of the line, clock by clock, and back; what a host sends to uart_host.v."""

from __future__ import annotations

import struct

__all__ = ["BYTE_BITS", "Ear", "levels", "request"]

BYTE_BITS = 10  # start, 8 of data, the lowest first, stop


def levels(data: bytes, clocks_per_bit: float, idle: int = 0) -> list[int]:
    """The line at every clock: each byte's bits, then `idle` clocks high. Bits may last a broken number of clocks."""
    line: list[int] = []
    for value in data:
        begin = len(line)
        for i, bit in enumerate((0, *(value >> i & 1 for i in range(8)), 1)):
            line += [bit] * (round(begin + (i + 1) * clocks_per_bit) - len(line))
        line += [1] * idle
    return line


class Ear:
    """Hears bytes on a line, each bit in its middle.

    Attributes:
        heard: the bytes so far.
        began: at which clock each began, counted in calls of `listen`.
    """

    def __init__(self, divisor: int) -> None:
        self.heard = bytearray()
        self.began: list[int] = []
        self._divisor = divisor
        self._clock = -1
        self._start = -1
        self._bits: list[int] = []

    def listen(self, level: int) -> None:
        """The line at the next clock.

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
            assert (start, stop) == (0, 1), f"clock {self._clock}: {self._bits} is no byte"
            self.heard.append(sum(bit << i for i, bit in enumerate(data)))
            self.began.append(self._start)
            self._start, self._bits = -1, []


def request(kind: str, address: int, value: int = 0) -> bytes:
    """What a host asks: kind 'R' or 'W'."""
    return struct.pack("<cHI", kind.encode(), address, value)

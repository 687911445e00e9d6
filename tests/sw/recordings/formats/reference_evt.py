# SPDX-License-Identifier: Apache-2.0
"""Reference decoders of EVT 2.0, EVT 2.1, EVT 3.0 and DAT, word by word from the published tables, with plain integers.

Written from the tables alone, to be compared with evcot's decoders: slow, simple, and sharing no code with them. Also makes
words, and files of words.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

Row = tuple[int, int, int, int]


@dataclass
class Read:
    """Events (t, x, y, p), how many of them had no time or address yet, and how many words were of a reserved type."""

    rows: list[Row] = field(default_factory=list)
    untimed: int = 0
    strange: int = 0


def bits(word: int, high: int, low: int) -> int:
    """Bits high..low of a word, as the tables count them."""
    return (word >> low) % (1 << (high - low + 1))


def turned(before: int | None, mark: int, width: int) -> int:
    """A mark of `width` bits, unwrapped: one that falls by more than half its range starts another turn."""
    if before is None:
        return mark
    turn, last = divmod(before, 1 << width)
    return ((turn + 1 if last - mark > 1 << (width - 1) else turn) << width) + mark


def read_evt2(words: Iterable[int], t0_us: int = 0) -> Read:
    read, high = Read(), None
    for word in words:
        kind = bits(word, 31, 28)
        if kind == 0b1000:
            high = turned(high, bits(word, 27, 0), 28)
        elif kind in (0b0000, 0b0001):
            if high is None:
                read.untimed += 1
            else:
                read.rows.append((t0_us + high * 64 + bits(word, 27, 22), bits(word, 21, 11), bits(word, 10, 0), kind))
        elif kind not in (0b1010, 0b1110, 0b1111):
            read.strange += 1
    return read


def read_evt21(words: Iterable[int], t0_us: int = 0) -> Read:
    read, high = Read(), None
    for word in words:
        kind = bits(word, 63, 60)
        if kind == 0b1000:
            high = turned(high, bits(word, 59, 32), 28)
        elif kind in (0b0000, 0b0001):
            for n in range(32):
                if bits(word, n, n):
                    if high is None:
                        read.untimed += 1
                    else:
                        time_us = t0_us + high * 64 + bits(word, 59, 54)
                        read.rows.append((time_us, bits(word, 53, 43) + n, bits(word, 42, 32), kind))
        elif kind not in (0b1010, 0b1110, 0b1111):
            read.strange += 1
    return read


def read_evt3(words: Iterable[int], t0_us: int = 0) -> Read:
    read = Read()
    high: int | None = None
    y: int | None = None
    base: int | None = None
    low, base_polarity = 0, 0

    def event(x: int | None, polarity: int) -> None:
        if high is None or y is None or x is None:
            read.untimed += 1
        else:
            read.rows.append((t0_us + high * 4096 + low, x, y, polarity))

    for word in words:
        match bits(word, 15, 12):
            case 0b0000:
                y = bits(word, 10, 0)
            case 0b0010:
                event(bits(word, 10, 0), bits(word, 11, 11))
            case 0b0011:
                base, base_polarity = bits(word, 10, 0), bits(word, 11, 11)
            case 0b0100 | 0b0101 as kind:
                length = 12 if kind == 0b0100 else 8
                for n in range(length):
                    if bits(word, n, n):
                        event(None if base is None else base + n, base_polarity)
                base = None if base is None else base + length
            case 0b0110:
                low = bits(word, 11, 0)
            case 0b1000:
                risen = turned(high, bits(word, 11, 0), 12)
                low = low if risen == high else 0
                high = risen
            case 0b0001:
                read.strange += 1
                y = None
            case 0b0111 | 0b1010 | 0b1110 | 0b1111:
                pass
            case _:
                read.strange += 1
    return read


def read_dat(words: Iterable[int], t0_us: int = 0, version: int = 2) -> Read:
    read, last = Read(), None
    x_bits, y_bits = {1: (9, 8), 2: (14, 14)}[version]
    for word in words:
        last = turned(last, bits(word, 31, 0), 32)
        x, y = bits(word, 31 + x_bits, 32), bits(word, 31 + x_bits + y_bits, 32 + x_bits)
        read.rows.append((t0_us + last, x, y, int(bits(word, 35 + x_bits + y_bits, 32 + x_bits + y_bits) > 0)))
    return read


def evt2_high(mark: int) -> int:
    return 8 << 28 | mark


def evt2_event(p: int, low: int, x: int, y: int) -> int:
    return p << 28 | low << 22 | x << 11 | y


def evt21_high(mark: int) -> int:
    return 8 << 60 | mark << 32


def evt21_event(p: int, low: int, x: int, y: int, valid: int) -> int:
    return p << 60 | low << 54 | x << 43 | y << 32 | valid


def evt3_high(mark: int) -> int:
    return 8 << 12 | mark


def evt3_low(low: int) -> int:
    return 6 << 12 | low


def evt3_row(y: int) -> int:
    return y


def evt3_event(p: int, x: int) -> int:
    return 2 << 12 | p << 11 | x


def evt3_base(p: int, x: int) -> int:
    return 3 << 12 | p << 11 | x


def evt3_vector12(valid: int) -> int:
    return 4 << 12 | valid


def evt3_vector8(valid: int) -> int:
    return 5 << 12 | valid


def dat_event(t: int, x: int, y: int, p: int, version: int = 2) -> int:
    return t | (x | y << 14 | p << 28 if version == 2 else x | y << 9 | p << 17) << 32


# kind -> (bytes of a word, header before the words)
FILES = {
    "evt2": (4, b"% evt 2.0\n% end\n"),
    "evt21": (8, b"% evt 2.1\n% format EVT21;endianness=little\n% end\n"),
    "evt21-legacy": (8, b"% evt 2.1\n% format EVT21;endianness=legacy\n% end\n"),
    "evt3": (2, b"% evt 3.0\n% end\n"),
    "dat1": (8, b"% Version 1\n\x00\x08"),
    "dat2": (8, b"% Version 2\n\x0c\x08"),
}


def packed(kind: str, words: Sequence[int], header: bytes | None = None) -> bytes:
    """A file of these words."""
    size, usual = FILES[kind]
    order = (4, 5, 6, 7, 0, 1, 2, 3) if kind == "evt21-legacy" else range(size)
    payload = bytes(word.to_bytes(size, "little")[i] for word in words for i in order)
    return (usual if header is None else header) + payload


def write(path: Path, kind: str, words: Sequence[int], header: bytes | None = None) -> Path:
    """Write a file of these words."""
    path.write_bytes(packed(kind, words, header))
    return path


def reference(kind: str, words: Sequence[int], t0_us: int = 0) -> Read:
    """The result of the tables for these words."""
    match kind:
        case "evt2":
            return read_evt2(words, t0_us)
        case "evt21" | "evt21-legacy":
            return read_evt21(words, t0_us)
        case "evt3":
            return read_evt3(words, t0_us)
        case _:
            return read_dat(words, t0_us, int(kind[-1]))

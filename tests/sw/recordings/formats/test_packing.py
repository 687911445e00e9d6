# SPDX-License-Identifier: Apache-2.0
"""Compressed frames are unpacked whole or in pieces, to no more than a limit."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path

import lz4.frame
import pytest

from evcot._zstd import zstd
from evcot.errors import RecordingError
from evcot.recordings.formats import packing
from evcot.recordings.formats.packing import Lz4Unpacker, PlainUnpacker, Section, TooLarge, Unpacker, ZstdUnpacker
from support.refusals import refused

CONTENT = bytes(range(256)) * 40 + bytes(200_000)
KINDS = [
    pytest.param(PlainUnpacker, bytes, id="plain"),
    pytest.param(Lz4Unpacker, lz4.frame.compress, id="lz4"),
    pytest.param(ZstdUnpacker, zstd.compress, id="zstd"),
]
Pack = Callable[[bytes], bytes]


@pytest.mark.parametrize(("kind", "pack"), KINDS)
@pytest.mark.parametrize("length", [0, 1, 1_000, len(CONTENT)])
def test_a_frame_is_unpacked_up_to_its_limit(kind: type[Unpacker], pack: Pack, length: int) -> None:
    content = CONTENT[:length]
    one, packed = kind(), pack(content)
    for most in (length, length + 1, 1 << 30):
        assert one.whole(packed, most) == one.whole(memoryview(packed), most) == content
    if length:
        with pytest.raises(TooLarge, match=rf"unpacks to more than {length - 1} bytes: must be at most that"):
            one.whole(packed, length - 1)


@pytest.mark.parametrize(("kind", "pack"), KINDS)
@pytest.mark.parametrize("piece_bytes", [1, 7, 1 << 20])
def test_pieces_are_bounded_and_make_the_whole(
    kind: type[Unpacker], pack: Pack, piece_bytes: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(packing, "_PIECE_BYTES", piece_bytes)
    monkeypatch.setattr(packing, "_FILE_BYTES", 5)
    content = CONTENT[:3_000]
    one = kind()
    for _ in range(2):
        pieces = list(one.pieces(io.BytesIO(pack(content))))
        assert b"".join(pieces) == content
        assert all(0 < len(piece) <= piece_bytes for piece in pieces)


def test_lz4_frames_are_whole_and_nothing_follows_them() -> None:
    packed = lz4.frame.compress(CONTENT)
    for length in (0, 10, len(packed) - 1):
        with refused(RecordingError, f"LZ4 frame of {length} bytes: must be whole"):
            Lz4Unpacker().whole(packed[:length], 1 << 30)
        with refused(RecordingError, f"LZ4 frame of {length} bytes: must be whole"):
            list(Lz4Unpacker().pieces(io.BytesIO(packed[:length])))
    with refused(RecordingError, "3 bytes follow the LZ4 frame: must be none"):
        Lz4Unpacker().whole(packed + b"abc", 1 << 30)


@pytest.mark.parametrize(("kind", "name"), [(Lz4Unpacker, "LZ4"), (ZstdUnpacker, "Zstandard")])
def test_other_bytes_are_no_frame(kind: type[Unpacker], name: str) -> None:
    for unpack in (lambda: kind().whole(b"x" * 50, 99), lambda: list(kind().pieces(io.BytesIO(b"x" * 50)))):
        with pytest.raises(RecordingError, match=rf"is no {name} frame: "):
            unpack()


def test_a_section_is_read_wherever_the_file_stands(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_bytes(b"0123456789")
    with path.open("rb") as file:
        section = Section(file, 2, 6)
        parts = []
        for size in (2, 1, 9, 1):
            parts.append(section.read(size))
            file.seek(0)
        assert parts == [b"23", b"4", b"567", b""]
        assert Section(file, 2, 6).read() == b"234567"
        section = Section(file, 2, 6)
        section.skip(4)
        assert section.read(9) == b"67"
        section = Section(file, 2, 6)
        section.skip(7)
        assert section.read() == b""

# SPDX-License-Identifier: Apache-2.0
"""Malicious files: kilobytes that decompress to gigabytes, or claims of data that are not in the file.

Each is read in a separate process, from its first event to its last, and the peak memory of that process is measured. It must
return the events that are really in the file, or refuse it in one line; never a traceback, never the claimed size in memory.
"""

from __future__ import annotations

import bz2
import struct
import zipfile
import zlib
from collections.abc import Iterator
from functools import cache, reduce
from pathlib import Path

import h5py
import lz4.frame
import numpy as np
import pytest
import scipy.io
import zstandard

from evcot.recordings.files import open_recording, read_recording
from evcot.recordings.formats import matlab
from support.bounded import Answer, answer_to

from .reading import assert_same, refusal, rows_of
from .test_aedat4 import plain_file, stream_node


def refusal_of(path: Path, content: bytes | str | None = None) -> str:
    message = refusal(path, content)
    assert len(message) < 400
    return message


def contents_of(*parts: tuple[bytes, int]) -> Iterator[bytes]:
    """Contents one after the other, each repeated so many times, in steps of 16 MB."""
    for content, times in parts:
        many = max((1 << 24) // len(content), 1)
        step = content * min(many, times)
        for _ in range(times // many):
            yield step
        yield content * (times % many)


def deflated(*parts: tuple[bytes, int]) -> bytes:
    """The contents of `contents_of`, compressed: equal steps are compressed once, each for itself."""

    @cache
    def packed(step: bytes) -> bytes:
        packer = zlib.compressobj(wbits=-15)
        return packer.compress(step) + packer.flush(zlib.Z_FULL_FLUSH)

    return b"".join(map(packed, contents_of(*parts))) + zlib.compressobj(wbits=-15).flush()


def zlib_stream(*parts: tuple[bytes, int]) -> bytes:
    """The same with the head and the checksum of zlib."""
    check = reduce(lambda adler, content: zlib.adler32(content, adler), contents_of(*parts), 1)
    return b"\x78\x9c" + deflated(*parts) + check.to_bytes(4, "big")


# AEDAT 4.0: packets.


def packet_head(events: int, extra: int = 0) -> bytes:
    """The start of an EventPacket of so many events, with its length in front."""
    fields = struct.pack("<I4s2x3HiII", 16, b"EVTS", 6, 8, 4, 6, 4, events)
    return struct.pack("<I", len(fields) + 16 * events + extra) + fields


def packed_zeros(head: bytes, zeros: int, compression: str) -> bytes:
    """A frame of a head and so many zeros."""
    step = bytes(1 << 24)
    steps = [head, *[step] * (zeros // len(step)), bytes(zeros % len(step))]
    if compression == "LZ4":
        with lz4.frame.LZ4FrameCompressor(block_size=lz4.frame.BLOCKSIZE_MAX4MB) as packer:
            return packer.begin() + b"".join(map(packer.compress, steps)) + packer.flush()
    packer = zstandard.ZstdCompressor(level=3).compressobj()
    return b"".join(map(packer.compress, steps)) + packer.flush()


@pytest.mark.parametrize(("compression", "number", "megabytes"), [("LZ4", 1, 6), ("Zstandard", 3, 1)])
def test_a_packet_of_kilobytes_that_holds_a_gigabyte_is_given_in_blocks(
    tmp_path: Path, compression: str, number: int, megabytes: int
) -> None:
    events = 1 << 26
    packed = packed_zeros(packet_head(events), 16 * events, compression)
    assert len(packed) < megabytes << 20
    path = tmp_path / "bomb.aedat4"
    path.write_bytes(plain_file(stream_node(0), (0, packed), compression=number))
    answer = answer_to(path)
    assert (answer.events, answer.refusal) == (events, "")
    assert answer.longest_block <= 1 << 15


def test_a_batch_of_many_small_bombs_is_not_unpacked_at_once(tmp_path: Path) -> None:
    events = 200_000
    packed = packed_zeros(packet_head(events), 16 * events, "Zstandard")
    assert len(packed) < 1 << 10
    path = tmp_path / "bombs.aedat4"
    path.write_bytes(plain_file(stream_node(0), *[(0, packed)] * 400, compression=3))
    assert answer_to(path) == Answer(400 * events, 1 << 15, "")


def test_a_large_packet_must_be_what_it_says(tmp_path: Path) -> None:
    path = tmp_path / "bomb.aedat4"
    events = 1 << 19
    for said, extra, what in (
        (events + 1, 0, f"{16 * events + 28} bytes, {16 * events + 44} by its own length: must be the same"),
        (events, 8, f"{16 * events + 28} bytes, {16 * events + 36} by its own length: must be the same"),
        (1 << 32 - 1, -16 << 31, ""),
    ):
        head = packet_head(said, extra) if what else struct.pack("<I", 16) + packet_head(0)[4:-4] + b"\xff" * 4
        packed = packed_zeros(head, 16 * events, "Zstandard")
        said = refusal_of(path, plain_file(stream_node(0), (0, packed), compression=3))
        assert said.startswith("packet at byte ")
        assert said.endswith(what or "must lie within 16 bytes")


def with_table(content: bytes, table: bytes) -> bytes:
    """A file that its writer closed: its header, laid out as by `plain_file` but with the table's place, and a table."""
    compression, text = struct.unpack_from("<i", content, 30)[0], content[48:]
    vtable = struct.pack("<5H2x", 10, 20, 4, 8, 16)
    head = struct.pack("<I4s", 8, b"IOHE") + struct.pack("<iiqI", -20, compression, 0, 4 + len(vtable)) + vtable + text
    end = 18 + len(head)
    head = head[:16] + struct.pack("<q", end) + head[24:]
    return content[:14] + struct.pack("<I", len(head)) + head + table


def remark_on(path: Path) -> str:
    with open_recording(path) as file:
        (remark,) = file._source.remarks
    return remark


@pytest.mark.parametrize(("compression", "number"), [("LZ4", 1), ("Zstandard", 3)])
def test_a_packet_table_that_unpacks_to_gigabytes_is_not_read(tmp_path: Path, compression: str, number: int) -> None:
    path, packed = tmp_path / "table.aedat4", packed_zeros(struct.pack("<I", 1 << 30), 1 << 30, compression)
    path.write_bytes(with_table(plain_file(stream_node(0), compression=number), packed))
    assert answer_to(path).refusal == f"{path}: holds no events"
    bound = "unpacks to more than 268435456 bytes: must be at most that; the packets are read without it"
    assert remark_on(path).endswith(bound)


def test_a_packet_table_names_no_more_packets_than_there_is_room_for(tmp_path: Path) -> None:
    count, path = 1 << 22, tmp_path / "table.aedat4"
    fields = struct.pack("<I4s2x3HiII", 16, b"FTAB", 6, 8, 4, 6, 4, count)
    table = packed_zeros(struct.pack("<I", len(fields) + 4 * count) + fields, 4 * count, "Zstandard")
    assert refusal_of(path, with_table(plain_file(stream_node(0), compression=3), table)) == "holds no events"
    assert f"{count} entries: must be at most 0, for so many bytes" in remark_on(path)


def test_a_header_of_megabytes_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "long.aedat4"
    assert refusal_of(path, plain_file(stream_node(0) + "<a/>" * (1 << 22))).endswith("must be at most 1048576")
    said = f"header: sizeX, sizeY = ('{'9' * 60}...', '48'): must be whole numbers"
    assert refusal_of(path, plain_file(stream_node(0).replace(">64<", f">{'9' * 5000}<"))) == said


# NumPy.


def npy_header(shape: str, dtype: str = "<i8", length: int | None = None, version: int = 2) -> bytes:
    text = f"{{'descr': '{dtype}', 'fortran_order': False, 'shape': {shape}, }}\n".encode()
    return b"\x93NUMPY" + struct.pack("<BBI", version, 0, len(text) if length is None else length) + text


def deflated_zip(path: Path, members: dict[str, tuple[bytes, int]]) -> Path:
    """A zip of members that are a head and so many zeros."""
    directory = []
    with path.open("wb") as file:
        for stem, (head, zeros) in members.items():
            parts, name, place = ((head, 1), (b"\0", zeros)), f"{stem}.npy".encode(), file.tell()
            data, check = deflated(*parts), reduce(lambda crc, step: zlib.crc32(step, crc), contents_of(*parts), 0)
            sizes = struct.pack("<IIIHH", check, len(data), len(head) + zeros, len(name), 0)
            fields = struct.pack("<HHHHH", 20, 0, zipfile.ZIP_DEFLATED, 0, 33) + sizes
            file.write(b"PK\3\4" + fields + name + data)
            directory.append(b"PK\1\2" + struct.pack("<H", 20) + fields + struct.pack("<HHHII", 0, 0, 0, 0, place) + name)
        begin, many = file.tell(), len(directory)
        file.writelines(directory)
        file.write(b"PK\5\6" + struct.pack("<HHHHIIH", 0, 0, many, many, file.tell() - begin, begin, 0))
    return path


def test_an_npz_of_megabytes_that_holds_gigabytes_is_given_in_blocks(tmp_path: Path) -> None:
    n = 1 << 25
    members = {name: (npy_header(f"({n},)", dtype), n * size) for name, dtype, size in
               (("t", "<i8", 8), ("x", "<u2", 2), ("y", "<u2", 2), ("p", "u1", 1))}  # fmt: skip
    path = deflated_zip(tmp_path / "bomb.npz", members)
    assert path.stat().st_size < 2 << 20
    assert answer_to(path) == Answer(n, 1 << 15, "")


def test_an_npz_header_of_gigabytes_is_refused(tmp_path: Path) -> None:
    head = npy_header("(1,)", length=(1 << 30) + 100) + b" "
    path = deflated_zip(tmp_path / "header.npz", {"t": (head, 1 << 30)})
    answer = answer_to(path)
    assert answer.refusal.endswith("'t': header of 1073741924 bytes: must be at most 65536")


def test_an_npz_member_that_claims_more_than_it_holds_ends_where_it_ends(tmp_path: Path) -> None:
    # In Fortran's order the second column lies behind the first: behind 2^59 bytes that are not there.
    head = npy_header(f"({1 << 54}, 4)").replace(b"False", b"True ")
    path = deflated_zip(tmp_path / "far.npz", {"events": (head, 1 << 20)})
    content = bytearray(path.read_bytes())
    place = content.index(b"PK\1\2") + 24
    assert struct.unpack_from("<I", content, place) == (len(head) + (1 << 20),)
    path.write_bytes(content)
    assert "is it cut off?" in refusal_of(path)


def test_a_zip_with_a_huge_list_of_members_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "many.npz"
    with zipfile.ZipFile(path, "w") as archive:
        for i in range(1000):
            archive.writestr(f"{i}.npy", b"")
    assert refusal_of(path) == "holds 1000 arrays: must be at most 256"
    with zipfile.ZipFile(path, "w") as archive:
        for i in range(40):
            archive.writestr(f"{i}{'n' * 60_000}", b"")
    assert "list of members has" in refusal_of(path)


@pytest.mark.parametrize(
    ("shape", "said"),
    [
        *((shape, "of 8 bytes each: must be below 2^60 bytes")
          for shape in (f"({1 << 60}, 4)", f"({10**30}, 4)", f"({'9' * 4000}, 4)", f"({1 << 62}, 4)")),
        ("(1125899906842624, 4)", "ends after event -1 of 1125899906842624; is it cut off?"),
        ("(1125899906842623, 4)", "ends after event -1 of 1125899906842623; is it cut off?"),
    ],
)  # fmt: skip
def test_an_npy_of_a_huge_shape_is_refused(tmp_path: Path, shape: str, said: str) -> None:
    assert refusal_of(tmp_path / "huge.npy", npy_header(shape)).endswith(said)


def test_long_doubles_are_numbers(tmp_path: Path) -> None:
    path = tmp_path / "long.npy"
    np.save(path, np.array([(0.5, 3, 4, 1), (0.500001, 5, 6, -1)], np.longdouble))
    assert rows_of(read_recording(path, (10, 10)).events) == [(500_000, 3, 4, 1), (500_001, 5, 6, 0)]
    np.save(path, np.array([(np.longdouble("1e4000"), 1, 1, 1)]))
    assert refusal_of(path).startswith("event 0: t = inf: must be a whole number")


# Text, and headers of text.


@pytest.mark.parametrize(
    ("text", "what"),
    [
        (f"t,x@{'9' * 5000},y@480,p\n1,2,3,1\n", "must name a sensor of at most 65536 pixels a side, not of 5000 digits"),
        (f"{'9' * 5000} 480\n1 2 3 1\n", "line 1: a sensor's side of 5000 digits: must be a number up to 65536"),
        (f"t,x,y,p\n{'9' * 5000},2,3,1\n", "must be a whole number of microseconds, below 2^63 us"),
        (f"t,x,y,p\n1,{'9' * 5000},3,1\n", "must be a whole number from 0 to 65535"),
        ("#\n" * 100_000 + "1 2 3 1\n", "must be at most 65536 lines and 4194304 bytes"),
        (("#" + "a," * 30_000 + "\n") * 100 + "1 2 3 1\n", "must be at most 65536 lines and 4194304 bytes"),
    ],
)
def test_text_with_thousands_of_digits_or_comments_is_refused(tmp_path: Path, text: str, what: str) -> None:
    assert refusal_of(tmp_path / "digits.csv", text).endswith(what)


def test_a_name_of_blanks_takes_no_time(tmp_path: Path) -> None:
    path = tmp_path / "blanks.csv"
    path.write_text(("# a" + " " * 60_000 + "b\n") * 50 + "1,2,3,1\n")
    assert answer_to(path) == Answer(1, 1, "")


def test_an_aedat_header_of_megabytes_is_passed_over_or_refused(tmp_path: Path) -> None:
    path = tmp_path / "long.aedat"
    start, end = b"#!AER-DAT2.0\r\n", b"# AEChip: DVS128\r\n" + struct.pack(">II", 0, 5)
    line = b"# " + b"<entry/>" * 1000 + b"\r\n"
    path.write_bytes(start + line * 1500 + end)
    assert answer_to(path) == Answer(1, 1, "")
    for many in (line * 2500, b"#\n" * 1_000_000):
        assert "must have at most 262144 lines and 16777216 bytes" in refusal_of(path, start + many + end)
    aedat3 = b"#!AER-DAT3.1\r\n" + (b"#" + b"a" * 60_000 + b"\r\n") * 30 + b"#!END-HEADER\r\n"
    assert refusal_of(path, aedat3).endswith("or its first 1048576 bytes")


# HDF5 and MATLAB.


def hdf5_with(path: Path, chunk: bytes, *, rows: int, chunk_rows: int, fletcher32: bool = False) -> Path:
    """Columns of which the times are in chunks that are put there as they are."""
    with h5py.File(path, "w") as file:
        options = {"chunks": (chunk_rows,), "compression": "gzip", "fletcher32": fletcher32}
        t = file.create_dataset("events/t", (rows,), "<i8", **options)
        for begin in range(0, rows, chunk_rows):
            t.id.write_direct_chunk((begin,), chunk)
        for name, kind in (("x", "<u2"), ("y", "<u2"), ("p", "u1")):
            file.create_dataset(f"events/{name}", data=np.zeros(rows, kind), chunks=(1 << 16,), compression="gzip")
    return path


@pytest.mark.parametrize("fletcher32", [False, True])
def test_an_hdf5_chunk_that_unpacks_to_more_than_a_chunk_is_refused(tmp_path: Path, fletcher32: bool) -> None:
    bomb = zlib_stream((b"\0", 1 << 30))
    path = hdf5_with(tmp_path / "bomb.h5", bomb, rows=1 << 17, chunk_rows=1 << 17, fletcher32=fletcher32)
    answer = answer_to(path)
    assert answer.refusal.split(": ", 1)[1].startswith("/events/t: values 0 to 131071: chunk")


def test_hdf5_of_megabytes_that_holds_gigabytes_is_given_in_blocks(tmp_path: Path) -> None:
    rows, chunk_rows = 1 << 24, 1 << 20
    chunk = zlib_stream((b"\0", 8 * chunk_rows + (8 << 20)))
    path = hdf5_with(tmp_path / "bomb.h5", chunk, rows=rows, chunk_rows=chunk_rows * 2)
    assert path.stat().st_size < 4 << 20
    assert answer_to(path) == Answer(rows, 1 << 15, "")


def test_hdf5_chunks_of_hundreds_of_megabytes_are_refused(tmp_path: Path) -> None:
    path = hdf5_with(tmp_path / "bomb.h5", zlib_stream((b"\0", 1 << 24)), rows=1 << 25, chunk_rows=1 << 25)
    assert refusal_of(path) == "events: compressed chunks of 268763136 bytes: must be at most 268435456 in all"


def test_what_else_the_look_over_reads_is_bounded(tmp_path: Path) -> None:
    path = tmp_path / "index.h5"
    with h5py.File(path, "w") as file:
        for name in "txyp":
            file[f"events/{name}"] = np.zeros(10, np.uint8)
        file.create_dataset("t_offset", (1,), "<i8", chunks=(1,), compression="gzip", maxshape=(None,))
        file["t_offset"].id.write_direct_chunk((0,), zlib_stream((b"\0", 1 << 30)))
    assert "t" in answer_to(path).refusal


@pytest.mark.parametrize("held", [True, False], ids=["shuffled", "as it is"])
def test_gzip_is_what_the_library_makes_of_it(tmp_path: Path, held: bool) -> None:
    random = np.random.default_rng(4)
    n = 300_000
    wanted = {"t": np.sort(random.integers(0, 10**9, n)), "x": random.integers(0, 640, n).astype(np.uint16),
              "y": random.integers(0, 480, n).astype(">u2"), "p": random.integers(0, 2, n).astype(bool)}  # fmt: skip
    path = tmp_path / "usual.h5"
    with h5py.File(path, "w") as file:
        for name, values in wanted.items():
            file.create_dataset(f"events/{name}", data=values, chunks=(10_007,), compression="gzip", shuffle=held)
    assert_same(read_recording(path, (640, 480)).events, [*wanted.values()])
    with open_recording(path, (640, 480)) as file:
        part = file.read(300_000_000, 300_500_000)
    first, end = np.searchsorted(wanted["t"] - wanted["t"][0], (300_000_000, 300_500_000))
    np.testing.assert_array_equal(part.events.x, wanted["x"][first:end])


def matlab_5(path: Path, count: int, before: int = 0) -> Path:
    """A compressed struct of so many events whose columns are ones, behind a compressed variable of so many bytes."""

    def element(kind: int, content: bytes) -> bytes:
        return struct.pack("<II", kind, len(content)) + content + bytes(-len(content) % 8)

    def head(kind: int, rows: int, name: bytes) -> bytes:
        return element(6, struct.pack("<II", kind, 0)) + element(5, struct.pack("<ii", rows, 1)) + element(1, name)

    def packed(*parts: tuple[bytes, int]) -> bytes:
        content = zlib_stream(*parts)
        return struct.pack("<II", 15, len(content)) + content

    parts: list[tuple[bytes, int]] = []
    size = 0
    start = (
        head(2, 1, b"TD")
        + element(5, struct.pack("<i", 8))
        + element(1, b"".join(n.ljust(8, b"\0") for n in (b"x", b"y", b"p", b"ts")))
    )
    for _ in range(4):
        inner = head(6, count, b"") + struct.pack("<II", 9, 8 * count)
        parts += [(struct.pack("<II", 14, len(inner) + 8 * count) + inner, 1), (struct.pack("<d", 1), count)]
        size += 8 + len(inner) + 8 * count
    variable = packed((struct.pack("<II", 14, len(start) + size) + start, 1), *parts)
    ahead = (
        packed((struct.pack("<II", 14, before) + head(6, before // 8, b"other"), 1), (bytes(8), before // 8)) if before else b""
    )
    path.write_bytes(b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM" + ahead + variable)
    return path


def test_a_matlab_struct_that_unpacks_to_gigabytes_is_given_in_blocks(tmp_path: Path) -> None:
    path = matlab_5(tmp_path / "bomb.mat", 1 << 24, 1 << 29)
    assert path.stat().st_size < 4 << 20
    assert answer_to(path) == Answer(1 << 24, 1 << 15, "")


def test_a_matlab_struct_is_the_same_held_or_not(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "events.mat"
    columns = {name: np.arange(70_000) // step + 1 for name, step in (("x", 300), ("y", 400), ("ts", 3))}
    scipy.io.savemat(path, {"other": np.arange(9), "TD": columns | {"p": np.arange(70_000) % 2 + 1}}, do_compression=True)
    held = read_recording(path).events
    monkeypatch.setattr(matlab, "_HELD_BYTES_MAX", 1000)
    assert_same(read_recording(path).events, held)
    assert held.t_us[-1] == columns["ts"][-1]
    content = bytearray(path.read_bytes())
    content[-3] ^= 1
    path.write_bytes(content)
    assert "a compressed variable is damaged" in refusal_of(path)


def test_matlab_7_3_is_bounded_as_hdf5_is(tmp_path: Path) -> None:
    path = tmp_path / "bomb.mat"
    rows = 1 << 17
    with h5py.File(path, "w", userblock_size=512) as file:
        for name in ("x", "y", "p", "ts"):
            dataset = file.create_dataset(f"TD/{name}", (1, rows), "<f8", chunks=(1, rows), compression="gzip")
            dataset.id.write_direct_chunk((0, 0), zlib_stream((b"\0", 1 << 30 if name == "p" else 8 * rows)))
    with path.open("r+b") as raw:
        raw.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")
    assert "/TD/p: values 0 to 131071: chunk" in answer_to(path).refusal


# ROS.


def mcap_with_chunk(path: Path, packed: bytes, size: int, compression: bytes) -> Path:
    """A bag without an index, of one chunk."""

    def record(op: int, content: bytes) -> bytes:
        return struct.pack("<BQ", op, len(content)) + content

    def text(value: bytes) -> bytes:
        return struct.pack("<I", len(value)) + value

    magic = b"\x89MCAP0\r\n"
    chunk = struct.pack("<QQQI", 0, 0, size, 0) + text(compression) + struct.pack("<Q", len(packed)) + packed
    path.write_bytes(magic + record(1, text(b"ros2") + text(b"")) + record(6, chunk) + record(2, bytes(20)) + magic)
    return path


@pytest.mark.parametrize(("compression", "kind"), [("LZ4", b"lz4"), ("Zstandard", b"zstd")])
def test_an_mcap_chunk_of_gigabytes_is_refused(tmp_path: Path, compression: str, kind: bytes) -> None:
    path = mcap_with_chunk(tmp_path / "bomb.mcap", packed_zeros(b"", 1 << 30, compression), 1 << 30, kind)
    assert "unpacks to more than 268435456 bytes: must be at most that" in answer_to(path).refusal


@pytest.mark.parametrize("kind", [b"bz2", b"lz4"])
def test_a_ros_1_chunk_of_gigabytes_is_refused(tmp_path: Path, kind: bytes) -> None:
    packed = bz2.compress(bytes(1 << 25)) if kind == b"bz2" else packed_zeros(b"", 1 << 25, "LZ4")

    def record(fields: dict[bytes, bytes], data: bytes) -> bytes:
        header = b"".join(struct.pack("<I", len(name + value) + 1) + name + b"=" + value for name, value in fields.items())
        return struct.pack("<I", len(header)) + header + struct.pack("<I", len(data)) + data

    path = tmp_path / "bomb.bag"
    start = b"#ROSBAG V2.0\n" + record({b"op": b"\3", b"index_pos": bytes(8)}, b"")
    for size, what in (
        ((1 << 32) - 1, "a chunk of 4294967295 bytes: must be at most 268435456"),
        (1 << 20, "a chunk of 1048577 bytes"),
    ):
        path.write_bytes(start + record({b"op": b"\5", b"compression": kind, b"size": struct.pack("<I", size)}, packed))
        assert what in answer_to(path).refusal

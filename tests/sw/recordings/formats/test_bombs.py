# SPDX-License-Identifier: Apache-2.0
"""Files made to break readers: packed so that kilobytes become gigabytes, or claiming what is not there.

Each is read in a process of its own, from its first event to its last, and what that process held at most is measured. It gives
the events that are really in the file, or one line of refusal; never a traceback, never the file's size in memory.
"""

from __future__ import annotations

import json
import struct
import subprocess
import sys
import zipfile
from dataclasses import dataclass
from pathlib import Path

import lz4.frame
import numpy as np
import pytest
import zstandard

from evcot.errors import RecordingError
from evcot.recordings.files import open_recording, read_recording

from .test_aedat4 import plain_file, stream_node

_PEAK_MB = 640  # libraries and compiled kernels take a third of it; every bomb below holds 1 GB and more
_HUNG_S = 300

_READER = """
import json, resource, sys, warnings
warnings.simplefilter("ignore")
from evcot.errors import RecordingError
from evcot.files import open_recording
seen, longest, what = 0, 0, ""
try:
    with open_recording(sys.argv[1], (640, 480)) as file:
        for block in file.blocks():
            seen, longest = seen + len(block), max(longest, len(block))
except RecordingError as error:
    what = str(error)
print(json.dumps([seen, longest, what, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024]))
"""


@dataclass(frozen=True)
class Answer:
    """What reading a file gave."""

    events: int
    longest_block: int
    refusal: str


def answer_to(path: Path) -> Answer:
    """Read a file elsewhere; its memory is bounded, and it may refuse in one line but not break."""
    done = subprocess.run([sys.executable, "-c", _READER, str(path)], capture_output=True, text=True, timeout=_HUNG_S)
    assert done.returncode == 0, done.stderr[-2000:]
    events, longest, refusal, peak_mb = json.loads(done.stdout)
    assert peak_mb < _PEAK_MB
    assert "\n" not in refusal and len(refusal) < 600 and (not refusal or refusal.startswith(str(path)))
    return Answer(events, longest, refusal)


def refusal_of(path: Path) -> str:
    """The one line that refuses a file, without its name."""
    with pytest.raises(RecordingError) as caught, open_recording(path) as file:
        for _ in file.blocks():
            pass
    message = str(caught.value)
    assert message.startswith(f"{path}: ") and "\n" not in message and len(message) < len(str(path)) + 400
    return message.removeprefix(f"{path}: ")


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
    packer = zstandard.ZstdCompressor(level=19).compressobj()
    return b"".join(map(packer.compress, steps)) + packer.flush()


@pytest.mark.parametrize(("compression", "number", "megabytes"), [("LZ4", 1, 6), ("Zstandard", 3, 1)])
def test_a_packet_of_kilobytes_that_holds_a_gigabyte_is_given_in_blocks(
    tmp_path: Path, compression: str, number: int, megabytes: int
) -> None:
    events = 1 << 26
    packed = packed_zeros(packet_head(events), 16 * events, compression)
    assert len(packed) < megabytes << 20
    path = tmp_path / "bomb.aedat4"
    path.write_bytes(plain_file(stream_node(0), (0, packed), (0, packed), compression=number))
    answer = answer_to(path)
    assert (answer.events, answer.refusal) == (2 * events, "")
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
        path.write_bytes(plain_file(stream_node(0), (0, packed), compression=3))
        refusal = refusal_of(path)
        assert refusal.startswith("packet at byte ") and refusal.endswith(what or "must lie within 16 bytes")


@pytest.mark.parametrize("compression", [1, 3])
def test_a_packet_table_that_unpacks_to_gigabytes_is_refused(tmp_path: Path, compression: int) -> None:
    packed = packed_zeros(struct.pack("<I", 1 << 30), 1 << 30, "LZ4" if compression == 1 else "Zstandard")
    path = tmp_path / "table.aedat4"
    content = plain_file(stream_node(0), compression=compression)
    at = content.index(b"IOHE") - 4 + 36
    assert struct.unpack_from("<q", content, at) == (-1,)
    path.write_bytes(content[:at] + struct.pack("<q", len(content)) + content[at + 8 :] + packed)
    answer = answer_to(path)
    assert answer.refusal.endswith("unpacks to more than 268435456 bytes: must be at most that; is the file cut off?")


def test_a_packet_table_names_no_more_packets_than_there_is_room_for(tmp_path: Path) -> None:
    count = 1 << 22
    fields = struct.pack("<I4s2x3HiII", 16, b"FTAB", 6, 8, 4, 6, 4, count)
    table = struct.pack("<I", len(fields) + 4 * count) + fields
    content = plain_file(stream_node(0), compression=3)
    at = content.index(b"IOHE") - 4 + 36
    path = tmp_path / "table.aedat4"
    packed = packed_zeros(table, 4 * count, "Zstandard")
    path.write_bytes(content[:at] + struct.pack("<q", len(content)) + content[at + 8 :] + packed)
    assert f"{count} entries: must be at most 0, for so many bytes" in refusal_of(path)


def test_a_header_of_megabytes_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "long.aedat4"
    path.write_bytes(plain_file(stream_node(0) + "<a/>" * (1 << 22)))
    assert refusal_of(path).endswith("must be at most 1048576")
    path.write_bytes(plain_file(stream_node(0).replace(">64<", f">{'9' * 5000}<")))
    assert refusal_of(path) == f"header: sizeX, sizeY = ('{'9' * 60}...', '48'): must be whole numbers"


# NumPy.


def npy_header(shape: str, dtype: str = "<i8", length: int | None = None, version: int = 2) -> bytes:
    text = f"{{'descr': '{dtype}', 'fortran_order': False, 'shape': {shape}, }}\n".encode()
    return b"\x93NUMPY" + struct.pack("<BBI", version, 0, len(text) if length is None else length) + text


def deflated_zip(path: Path, members: dict[str, tuple[bytes, int]]) -> Path:
    """A zip of members that are a head and so many zeros."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, (head, zeros) in members.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                member.write(head)
                for begin in range(0, zeros, 1 << 24):
                    member.write(bytes(min(1 << 24, zeros - begin)))
    return path


def test_an_npz_of_megabytes_that_holds_gigabytes_is_given_in_blocks(tmp_path: Path) -> None:
    n = 1 << 27
    members = {name: (npy_header(f"({n},)", dtype), n * size) for name, dtype, size in
               (("t", "<i8", 8), ("x", "<u2", 2), ("y", "<u2", 2), ("p", "u1", 1))}  # fmt: skip
    path = deflated_zip(tmp_path / "bomb.npz", members)
    assert path.stat().st_size < 2 << 20
    assert answer_to(path) == Answer(n, 1 << 15, "")


def test_an_npz_header_of_gigabytes_is_refused(tmp_path: Path) -> None:
    head = npy_header("(1,)", length=(1 << 30) + 100) + b" "
    path = deflated_zip(tmp_path / "header.npz", dict.fromkeys("t", (head, 1 << 30)))
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


@pytest.mark.parametrize("shape", ["(1152921504606846976,)", f"({10**30}, 4)", f"({'9' * 4000},)", "(4611686018427387904, 4)"])
def test_an_npy_of_a_huge_shape_is_refused(tmp_path: Path, shape: str) -> None:
    path = tmp_path / "huge.npy"
    path.write_bytes(npy_header(shape, "[('t', '<i8'), ('x', '<u2'), ('y', '<u2'), ('p', 'u1')]".replace("'", "'")
                                if shape.endswith(",)") else "<i8").replace(b"'[", b"[").replace(b"]'", b"]"))  # fmt: skip
    assert "must be below 2^60 bytes" in refusal_of(path)


@pytest.mark.parametrize("shape", ["(1125899906842624, 4)", "(1125899906842623, 4)"])
def test_an_npy_that_claims_petabytes_is_cut_off(tmp_path: Path, shape: str) -> None:
    path = tmp_path / "huge.npy"
    path.write_bytes(npy_header(shape))
    assert refusal_of(path) == "holds no events" or "is it cut off?" in refusal_of(path)


def test_long_doubles_are_numbers(tmp_path: Path) -> None:
    rows = np.array([(0.5, 3, 4, 1), (0.500001, 5, 6, -1)], np.longdouble)
    path = tmp_path / "long.npy"
    np.save(path, rows)
    events = read_recording(path, (10, 10)).events
    assert (events.t_us.tolist(), events.x.tolist(), events.p.tolist()) == ([500_000, 500_001], [3, 5], [1, 0])
    np.save(path, np.array([(np.longdouble("1e4000"), 1, 1, 1)]))
    assert "t = " in refusal_of(path) and "must be a number of seconds" in refusal_of(path)


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
    path = tmp_path / "digits.csv"
    path.write_text(text)
    assert refusal_of(path).endswith(what)


def test_a_name_of_blanks_takes_no_time(tmp_path: Path) -> None:
    path = tmp_path / "blanks.csv"
    path.write_text(("# a" + " " * 60_000 + "b\n") * 50 + "1,2,3,1\n")
    assert answer_to(path) == Answer(1, 1, "")


def test_an_aedat2_header_of_megabytes_is_passed_over_or_refused(tmp_path: Path) -> None:
    path = tmp_path / "long.aedat"
    record = struct.pack(">II", 0, 5)
    start, chip = b"#!AER-DAT2.0\r\n", b"# AEChip: DVS128\r\n"
    path.write_bytes(start + (b"# " + b"<entry/>" * 1000 + b"\r\n") * 1500 + chip + record)
    assert answer_to(path) == Answer(1, 1, "")
    path.write_bytes(start + (b"# " + b"<entry/>" * 1000 + b"\r\n") * 2500 + chip + record)
    assert "must have at most 262144 lines and 16777216 bytes" in refusal_of(path)
    path.write_bytes(start + b"#\n" * 1_000_000 + chip + record)
    assert "must have at most 262144 lines and 16777216 bytes" in refusal_of(path)


def test_an_aedat3_header_of_megabytes_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "long.aedat"
    path.write_bytes(b"#!AER-DAT3.1\r\n" + (b"#" + b"a" * 60_000 + b"\r\n") * 30 + b"#!END-HEADER\r\n")
    assert refusal_of(path).endswith("or its first 1048576 bytes")

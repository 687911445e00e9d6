# SPDX-License-Identifier: Apache-2.0
"""HDF5 files of Metavision, in Prophesee's ECF codec: encoded here, by its description, in plain Python."""

from __future__ import annotations

import struct
import tracemalloc
from contextlib import suppress
from itertools import groupby
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.errors import RecordingError
from evcot.recordings.files import open_recording, read_recording
from evcot.recordings.formats import ecf
from evcot.recordings.formats.numeric import RECORD

from .fuzzing import fuzz
from .reading import assert_same, refusal
from .test_hdf5 import _quick, surveyor  # noqa: F401  (fixtures: files are surveyed by one child)

ECF = 36559
CHUNK = 512
KINDS = ["all packed", "columns packed", "masked"]


def nibbles(step: int) -> bytes:
    """A long step of time: its nibbles, lowest first, each below a nibble of ones."""
    found = b""
    while step:
        found += bytes([0xF0 | step & 15])
        step >>= 4
    return found


def runs(values: list[int]) -> list[tuple[int, int]]:
    """(value, how many in a row); not more than fit into 16 bits."""
    found = [(value, len(list(same))) for value, same in groupby(values)]
    return [(value, min(count - at, 65_535)) for value, count in found for at in range(0, count, 65_535)]


def times(t: list[int]) -> bytes:
    """64 bits of the first; then nibbles of later and how many, the steps above 14 before them."""
    found = struct.pack("<Q", t[0] if t else 0)
    now = t[0] if t else 0
    for value, count in runs(t):
        if value - now > 14:
            found += nibbles(value - now)
            now = value
        found += bytes([value - now << 4 | min(count, 15)]) + (struct.pack("<H", count) if count >= 15 else b"")
        now = value
    return found


def rows(y: list[int]) -> bytes:
    return b"".join(
        struct.pack("<H", value << 5 | min(count, 31)) + (struct.pack("<H", count) if count >= 31 else b"")
        for value, count in runs(y)
    )


def polarities(p: list[int]) -> bytes:
    return b"".join(
        bytes([value << 7 | min(count, 127)]) + (struct.pack("<H", count) if count >= 127 else b"") for value, count in runs(p)
    )


def masked_columns(x: list[int], beyond: int) -> bytes:
    """x, and a bit for each of the next five that follows; in the last word, `beyond` for events that are not there."""
    found = b""
    i = 0
    while i < len(x):
        first, mask = x[i], 0
        i += 1
        for step in range(1, 6):
            if i < len(x) and x[i] == first + step:
                mask |= 1 << (5 - step)
                i += 1
        if i == len(x):
            mask |= beyond & (mask & -mask or 32) - 1
        found += struct.pack("<H", first << 5 | mask)
    return found


def fours(values: list[int], bits: int) -> bytes:
    """Four numbers side by side, from the top, but each low part in the word before: 0HHL 11.., as the codec has them."""
    size, letter = bits * 4 // 3, "I" if bits == 24 else "H"
    rest = size - bits
    found = b""
    for at in range(0, len(values), 4):
        a, b, c, d = (*values[at : at + 4], 0, 0, 0)[:4]
        words = (
            a << rest | b & (1 << rest) - 1,
            b >> rest << 2 * rest | c & (1 << 2 * rest) - 1,
            c >> 2 * rest << 3 * rest | d,
        )
        found += struct.pack(f"<3{letter}", *words)
    return found


def encode(events: NDArray[np.void], kind: str, beyond: int = 0) -> bytes:
    t, x, y, p = (events[field].tolist() for field in "txyp")
    head = struct.pack("<I", len(t) << 2 | {"all packed": 2, "columns packed": 1, "masked": 0}[kind]) + times(t)
    if kind == "all packed":
        return head + fours([b << 12 | a << 1 | c for a, b, c in zip(x, y, p, strict=True)], 24)
    if kind == "columns packed":
        return head + rows(y) + fours([a << 1 | c for a, c in zip(x, p, strict=True)], 12)
    return head + rows(y) + masked_columns(x, beyond) + polarities(p)


def make_events(count: int, seed: int, longest_step: int = 40) -> NDArray[np.void]:
    """Rows of neighbouring pixels and lone ones, in runs of every length that the codec tells apart."""
    random = np.random.default_rng(seed)
    events = np.zeros(count, RECORD)
    at = 0
    t = 1_700_000_000_000_000
    while at < count:
        length = int(random.choice([1, 1, 2, 5, 14, 15, 16, 30, 31, 32, 126, 127, 128, 300]))
        part = events[at : at + length]
        t += int(random.integers(0, longest_step))
        part["t"] = t
        part["y"] = random.integers(0, 2048)
        part["p"] = random.integers(0, 2)
        start = int(random.integers(0, 2047))
        part["x"] = np.minimum(start + np.cumsum(random.choice([1, 1, 1, 2, 6], len(part))), 2047)
        at += length
    return events


def write(path: Path, events: NDArray[np.void], chunks: list[tuple[bytes, int]], length: int = CHUNK) -> Path:
    """A file as Metavision writes it, of chunks (stored bytes, mask of the filters that were not used)."""
    with h5py.File(path, "w") as file:
        creation = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
        creation.set_chunk((length,))
        creation.set_filter(ECF, h5py.h5z.FLAG_OPTIONAL, ())
        space = h5py.h5s.create_simple((len(events),), (h5py.h5s.UNLIMITED,))
        group = file.create_group("CD")
        kind = h5py.h5t.py_create(events.dtype, logical=True)
        dataset = h5py.h5d.create(group.id, b"events", kind, space, creation)
        for number, (stored, mask) in enumerate(chunks):
            dataset.write_direct_chunk((number * length,), stored, mask)
        file.attrs["geometry"] = "2048x2048"
    return path


def encoded(events: NDArray[np.void], kinds: list[str], length: int = CHUNK, **options: Any) -> list[tuple[bytes, int]]:
    parts = [events[at : at + length] for at in range(0, len(events), length)]
    return [(encode(part, kinds[i % len(kinds)], **options), 0) for i, part in enumerate(parts)]


def assert_read_as(path: Path, wanted: NDArray[np.void], **options: int) -> None:
    assert_same(read_recording(path, **options).events, [wanted[field] for field in "txyp"])  # type: ignore[arg-type]


@pytest.mark.parametrize("kinds", [[kind] for kind in KINDS] + [KINDS], ids=[*KINDS, "each in turn"])
@pytest.mark.parametrize("count", [1, 2, 3, 4, 5, CHUNK - 1, CHUNK, CHUNK + 1, 7 * CHUNK + 13])
def test_every_packing_is_read_event_by_event(tmp_path: Path, kinds: list[str], count: int) -> None:
    events = make_events(count, seed=count)
    path = write(tmp_path / "events.hdf5", events, encoded(events, kinds))
    assert_read_as(path, events)
    with open_recording(path) as file:
        assert file.sensor == (2048, 2048)
        assert file.details == {"events": "CD/events"}


def test_chunks_of_metavision_s_size_and_runs_longer_than_a_byte(tmp_path: Path) -> None:
    length = 16_384
    events = make_events(3 * length, seed=1, longest_step=1 << 40)
    events[100 : length + 5_000] = events[100]
    path = write(tmp_path / "events.hdf5", events, encoded(events, ["masked", "columns packed", "all packed"], length), length)
    t_us = events["t"]
    for at in (0, 1, 101, length + 5_000, 2 * length + 77, len(events) - 1):
        assert_read_as(path, events[int(np.searchsorted(t_us, t_us[at])) :], from_us=int(t_us[at] - t_us[0]))


def test_a_chunk_by_hand() -> None:
    """From the description: 5 events; t 7, 7, 21, 40, 40; y 3, 3, 3, 3, 9; x 10, 11, 15, 2, 0; p 1, 1, 0, 0, 0."""
    times_and_rows = [7, 0, 0, 0, 0, 0, 0, 0, 0x02, 0xE1, 0xF3, 0xF1, 0x02, 3 << 5 | 4, 0, (9 << 5 | 1) & 255, 1]
    columns = [10 << 5 & 255 | 0b10001, 10 >> 3, 2 << 5, 0, 0, 0]
    polarities = [0x82, 0x03]
    found = ecf.unpack(bytes([5 << 2, 0, 0, 0, *times_and_rows, *columns, *polarities]), 5)
    assert found.tolist() == [(10, 3, 1, 7), (11, 3, 1, 7), (15, 3, 0, 21), (2, 3, 0, 40), (0, 9, 0, 40)]


def test_the_last_word_of_columns_may_speak_of_events_that_are_not_there(tmp_path: Path) -> None:
    """Metavision's encoder looks beyond its last event."""
    events = make_events(CHUNK, seed=3)
    assert_read_as(write(tmp_path / "events.hdf5", events, encoded(events, ["masked"], beyond=0b11111)), events)


def test_a_chunk_may_be_padded_or_end_with_the_data_or_be_stored_as_it_is(tmp_path: Path) -> None:
    events = make_events(CHUNK + 100, seed=4)
    padded = np.full(CHUNK, events[-1])
    padded[:100] = events[CHUNK:]
    first = (encode(events[:CHUNK], "masked"), 0)
    for last in ((encode(padded, "masked"), 0), (encode(padded[:100], "masked"), 0), (padded.tobytes(), 1)):
        assert_read_as(write(tmp_path / "events.hdf5", events, [first, last]), events)


def test_a_damaged_chunk_is_named(tmp_path: Path) -> None:
    events = make_events(2 * CHUNK, seed=5)
    good, (last, _) = encoded(events, ["masked"])
    for stored, what in (
        (last[:11], "chunk of 11 bytes: must be at least 12 in ECF"),
        (last[:-1], f"chunk of {len(last) - 1} bytes and {CHUNK} events: is no ECF, or damaged"),
        (encode(events[:100], "masked"), f"chunk unpacks to 100 events: must be {CHUNK}"),
        (encode(make_events(CHUNK + 1, 6), "masked"), f"chunk of {CHUNK + 1} events: must be at most {CHUNK}"),
        (struct.pack("<I", 0xFFFFFFFF) + last[4:], f"chunk of {(1 << 30) - 1} events: must be at most {CHUNK}"),
        (last[:12] + b"\xf1" * 17 + last[12:], f"chunk of {len(last) + 17} bytes and {CHUNK} events: is no ECF, or damaged"),
        (struct.pack("<IQ", CHUNK << 2, 0) + b"\xff" * 17, f"chunk of 29 bytes and {CHUNK} events: is no ECF, or damaged"),
    ):
        path = write(tmp_path / "events.hdf5", events, [good, (stored, 0)])
        assert refusal(path) == f"/CD/events: values 0 to {2 * CHUNK - 1}: {what}"


@pytest.mark.parametrize("kind", KINDS)
def test_no_cut_and_no_corruption_reads_beyond_a_chunk(kind: str) -> None:
    """Every truncation is refused; a corruption is refused, or is so many events. Nothing is read or written outside."""
    events = make_events(300, seed=7)
    content = encode(events, kind)
    for length in range(len(content)):
        with pytest.raises(RecordingError):
            ecf.unpack(content[:length], 300)
    random = np.random.default_rng(8)
    refused = 0
    for _ in range(3000):
        damaged = bytearray(content)
        for at in random.integers(0, len(content), int(random.integers(1, 5))):
            damaged[at] = int(random.integers(0, 256))
        try:
            assert len(ecf.unpack(bytes(damaged), 300)) == int.from_bytes(damaged[:4], "little") >> 2 <= 300
        except RecordingError:
            refused += 1
    assert 30 < refused < 3000


@pytest.mark.parametrize("kind", KINDS)
def test_the_kernels_stay_within_their_arrays(monkeypatch: pytest.MonkeyPatch, kind: str) -> None:
    """Not compiled, where an index beyond an array is an error."""
    for name in ("_times", "_rows", "_columns", "_polarities", "_packed_fours", "_run", "_word"):
        monkeypatch.setattr(ecf, name, getattr(ecf, name).py_func)
    for count in range(1, 10):
        events = make_events(count, seed=count)
        np.testing.assert_array_equal(ecf.unpack(encode(events, kind, beyond=0b11111), count), events)
    content = encode(make_events(40, seed=12), kind)
    random = np.random.default_rng(13)
    with np.errstate(over="ignore"):
        for length in range(12, len(content)):
            with pytest.raises(RecordingError):
                ecf.unpack(content[:length], 40)
        for _ in range(300):
            damaged = bytearray(content)
            damaged[int(random.integers(0, len(content)))] = int(random.integers(0, 256))
            with suppress(RecordingError):
                ecf.unpack(bytes(damaged), 40)


def test_a_chunk_that_claims_more_than_fits_takes_no_memory() -> None:
    tracemalloc.start()
    with pytest.raises(RecordingError, match="must be at most 16384"):
        ecf.unpack(struct.pack("<IQ", 0xFFFFFFFC, 0) + bytes(1000), 16_384)
    assert tracemalloc.get_traced_memory()[1] < 1 << 20
    tracemalloc.stop()


def test_damage_to_a_file_is_told_or_does_not_matter(tmp_path: Path) -> None:
    events = make_events(60, seed=9)
    content = write(tmp_path / "whole.hdf5", events, encoded(events, KINDS, 20), 20).read_bytes()
    outcomes = fuzz(tmp_path / "events.hdf5", content, cuts=False, corruptions=40, seed=10)
    assert outcomes.refused
    assert outcomes.read


def test_other_records_in_this_codec_are_refused_and_the_reason_told(tmp_path: Path) -> None:
    events = make_events(20, seed=11).astype([("t", "<i8"), ("x", "<u2"), ("y", "<u2"), ("p", "<i2")])
    path = write(tmp_path / "events.hdf5", events, [(b"123456789012", 0)])
    assert refusal(path) == (
        "/CD/events: is compressed by ECF (HDF5 filter 36559): "
        "needs Prophesee's plugin hdf5_ecf in $HDF5_PLUGIN_PATH, or the recording as RAW"
    )

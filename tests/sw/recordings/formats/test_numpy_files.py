# SPDX-License-Identifier: Apache-2.0
"""Events in NumPy files, with different field names and types."""

from __future__ import annotations

import itertools
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.lib.recfunctions import repack_fields
from numpy.typing import NDArray

from evcot.errors import RecordingError, RecordingWarning
from evcot.events import Events
from evcot.recordings.files import open_recording, read_recording, write_events
from evcot.recordings.formats import numpy_files

from .fuzzing import fuzz
from .reading import FIELDS, assert_same, columns_of, refusal, rows_of

EPOCH_US = 1_718_925_184_590_631
SENSOR = (640, 480)
COLUMNS = [("t", "i8"), ("x", "u2"), ("y", "u2"), ("p", "u1")]


def random_events(count: int, start_us: int = EPOCH_US) -> Events:
    random = np.random.default_rng(count)
    return Events(
        start_us + np.sort(random.integers(0, 3 * count, count)),
        random.integers(0, 640, count).astype(np.uint16),
        random.integers(0, 480, count).astype(np.uint16),
        random.integers(0, 2, count).astype(np.uint8),
    )


@pytest.fixture
def small_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Blocks of seven events."""
    monkeypatch.setattr(numpy_files, "BLOCK_EVENTS", 7)


EVENTS = random_events(60)
SIGNED = np.where(EVENTS.p == 0, -1, 1)
SECONDS = EVENTS.t_us / 1e6


def records(t: NDArray[np.generic], names: str = "t x y p", types: str = "i8 u2 u2 u1") -> NDArray[np.void]:
    table = np.zeros(len(t), [*zip(names.split(), types.split(), strict=True)])
    for name, values in zip(table.dtype.names or (), (t, EVENTS.x, EVENTS.y, EVENTS.p), strict=True):
        table[name] = values
    return table


def rows(t: NDArray[np.generic], dtype: type = np.float64) -> NDArray[np.generic]:
    return np.column_stack([t, EVENTS.x, EVENTS.y, SIGNED]).astype(dtype)


@pytest.mark.usefixtures("small_blocks")
@pytest.mark.parametrize(
    "array",
    [
        records(EVENTS.t_us),
        records(EVENTS.t_us, "timestamp x y polarity", ">u8 >i4 <i2 ?"),
        records(EVENTS.t_us, "ts x y pol", "f8 f4 f2 f8"),
        records(SECONDS, "t x y on", "f8 i8 i8 i8"),
        records(SECONDS, "t_s x y p", "f8 i8 i8 i8"),
        records(EVENTS.t_us * 1000 + 499, "t_ns x y p"),
        records(EVENTS.t_us / 1e3, "t_ms x y p", "f8 u2 u2 u1"),
        repack_fields(records(EVENTS.t_us)[["p", "y", "t", "x"]]),
        rows(EVENTS.t_us, np.int64),
        rows(EVENTS.t_us, np.float64),
        rows(SECONDS),
        np.asfortranarray(rows(SECONDS)),
        np.asfortranarray(rows(EVENTS.t_us, np.int64)),
    ],
)
def test_every_usual_npy_gives_the_same_events(tmp_path: Path, array: NDArray[np.generic]) -> None:
    path = tmp_path / "events.npy"
    np.save(path, array)
    assert_same(read_recording(path).events, EVENTS)
    for from_us in (1, 60, int(EVENTS.t_us[-1] - EVENTS.t_us[0])):
        first = int(np.searchsorted(EVENTS.t_us, EVENTS.t_us[0] + from_us))
        assert_same(read_recording(path, from_us=from_us).events, EVENTS[first:])
    packed = tmp_path / "events.npz"
    np.savez_compressed(packed, events=array)
    assert_same(read_recording(packed).events, EVENTS)


@pytest.mark.usefixtures("small_blocks")
@pytest.mark.parametrize("save", [np.savez, np.savez_compressed])
@pytest.mark.parametrize(
    ("names", "types"),
    [
        ("t_us x y p", "i8 u2 u2 u1"),
        ("ts x y pol", "u8 f8 i4 ?"),
        ("timestamp x y polarity", "f8 i8 i8 i1"),
        ("ts xs ys ps", "i8 u2 u2 ?"),
        ("timestamps x_coordinates y_coordinates polarities", "i8 u2 u2 ?"),
    ],
)
def test_every_usual_npz_gives_the_same_events(tmp_path: Path, save: Any, names: str, types: str) -> None:
    path = tmp_path / "events.npz"
    columns = zip(names.split(), types.split(), columns_of(EVENTS), strict=True)
    arrays = {name: values.astype(kind) for name, kind, values in columns}
    save(path, **arrays)
    smallest = read_recording(path)
    assert_same(smallest.events, EVENTS)
    assert (smallest.width, smallest.height) == (int(EVENTS.x.max()) + 1, int(EVENTS.y.max()) + 1)
    save(path, width=640, height=480, note="of no concern", **arrays)
    stated = read_recording(path, from_us=50)
    assert (stated.width, stated.height) == SENSOR
    assert_same(stated.events, EVENTS[int(np.searchsorted(EVENTS.t_us, EVENTS.t_us[0] + 50)) :])


def test_far_into_a_plain_npz_the_place_is_found_without_reading(tmp_path: Path) -> None:
    path = tmp_path / "events.npz"
    events = random_events(700_000)
    write_events(path, SENSOR, [events])
    content = bytearray(path.read_bytes())
    content[content.index(b"t_us.npy") + 300] ^= 1
    path.write_bytes(content)
    first = int(np.searchsorted(events.t_us, events.t_us[0] + 1_500_000))
    assert_same(read_recording(path, from_us=1_500_000).events, events[first:])
    assert refusal(path).endswith("Bad CRC-32 for file 't_us.npy'")


@pytest.mark.parametrize(
    ("array", "message"),
    [
        (np.arange(4), "is an array (4,) of int64: must be (n, 4), or have fields t, x, y, p"),
        (np.zeros((2, 3)), "is an array (2, 3) of float64: must be (n, 4), or have fields t, x, y, p"),
        (np.zeros((2, 4), "S3"), "t: is 1-D of |S3: must be a list of numbers"),
        (np.zeros((2, 4), complex), "t: is 1-D of complex128: must be a list of numbers"),
        (np.zeros(2, "i8, i8"), "must name each of t, x, y, p once; t is not"),
        (np.zeros(2, [*COLUMNS[:3], ("p", "u1", 2)]), "p: is 1-D of ('u1', (2,)): must be a list of numbers"),
        (np.array([[print, 1, 2, 3]], object), "array: is (1, 4) of 8 bytes each: must be up to 256, no objects"),
        (np.zeros(2, [*COLUMNS, ("note", "S999")]), "array: is (2,) of 1012 bytes each: must be up to 256, no objects"),
        (np.zeros((0, 4)), "holds no events"),
        (np.array([[1, -1, 0, 0]]), "event 0: x = -1: must be a whole number from 0 to 65535"),
        (np.array([[1, 0, 0, 0], [2, 0.5, 0, 0]]), "event 1: x = 0.5: must be a whole number from 0 to 65535"),
        (np.array([[1, 0, 0, 2]]), "event 0: p = 2: must be 0 or 1"),
        (np.array([[0.5, 0, 0, 0], [np.nan, 0, 0, 0]]), "event 1: t = nan: must be a number of seconds"),
        (np.array([[0.5, 0, 0, 0], [1e300, 0, 0, 0]]), "event 1: t = 1e+300: must be a number of seconds"),
        (np.array([[20_002, 0, 0, 0], [1, 0, 0, 0]]), "event 1: t = 1 us follows t = 20002 us: time must not run back"),
        (np.array([(1 << 44, 0, 0, 0)], [("t_s", "i8"), *COLUMNS[1:]]),
         "event 0: t = 17592186044416: must be below 2^62 us, in seconds"),
    ],
)  # fmt: skip
def test_an_array_of_something_else_is_refused(tmp_path: Path, array: NDArray[np.generic], message: str) -> None:
    path = tmp_path / "events.npy"
    np.save(path, array)
    assert refusal(path) == message


ONE = {"t_us": [1], "x": [1], "y": [1], "p": [1]}


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ({"t_us": [1]}, "has arrays 't_us': must name each of t, x, y, p once; x is not"),
        ({"t_us": [1], "y": [1]}, "has arrays 't_us', 'y': must name each of t, x, y, p once; x is not"),
        ({"t_us": [1], "t": [1], "x": [1]}, "has arrays 't_us', 't', 'x': must name each of t, x, y, p once; t is not"),
        (ONE | {"x": [-1]}, "event 0: x = -1: must be a whole number from 0 to 65535"),
        (ONE | {"y": [1, 2]}, "t, x, y, p hold 1, 1, 2, 1 values: all must be the same"),
        (ONE | {"t_us": 1, "y": [1, 2]}, "t: is 0-D of int64: must be a list of numbers"),
        (ONE | {"width": 0, "height": 4}, "sensor 0x4: each side must be from 1 to 65536 pixels"),
        (ONE | {"width": 4.5, "height": 4}, "'width': is () of float64: must be one whole number"),
    ],
)
def test_an_npz_of_other_arrays_is_refused(tmp_path: Path, arrays: dict[str, Any], message: str) -> None:
    np.savez(tmp_path / "file.npz", **arrays)
    assert refusal(tmp_path / "file.npz") == message
    with zipfile.ZipFile(tmp_path / "events.zip", "w") as archive:
        archive.writestr("events.csv", "1,2,3,1\n")
    assert refusal(tmp_path / "events.zip") == "is a zip file without NumPy arrays"


def test_a_file_that_is_cut_short_or_goes_on_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "events.npy"
    np.save(path, records(EVENTS.t_us))
    whole = path.read_bytes()
    assert refusal(path, whole[:-20]) == "ends after event 57 of 60; is it cut off?"
    with pytest.warns(RecordingWarning, match="everything after 58 events left out: ends after event 57"):
        assert_same(read_recording(path, damage="skip").events, EVENTS[:58])
    assert refusal(path, whole + b"1") == "array: goes on after 60 rows: its header must count all of them"
    path.write_bytes(whole)
    with open_recording(path) as file:
        path.write_bytes(whole[:-13])
        with pytest.raises(RecordingError, match="ends after event 58 of 60"):
            file.read()


@pytest.mark.parametrize("sizes", [[1], [3, 1, 5], [300_000, 2]])
def test_what_is_written_in_blocks_numpy_reads_as_arrays(tmp_path: Path, sizes: list[int]) -> None:
    path = tmp_path / "events.npz"
    events = random_events(sum(sizes))
    ends = list(itertools.accumulate(sizes))
    assert write_events(path, SENSOR, (events[end - size : end] for size, end in zip(sizes, ends, strict=True))) == ends[-1]
    with np.load(path) as content:
        assert_same(Events(*(content[field] for field in FIELDS)), events)
        assert (int(content["width"]), int(content["height"])) == SENSOR
    assert zipfile.ZipFile(path).testzip() is None
    assert_same(read_recording(path).events, events)
    assert [each.name for each in tmp_path.iterdir()] == ["events.npz"]


def test_a_failed_write_leaves_the_older_file_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "out.npz"
    path.write_bytes(b"older")

    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(numpy_files.zipfile, "ZipFile", full)
    with pytest.raises(OSError, match=r"out\.npz: cannot be written: No space left on device"):
        write_events(path, SENSOR, [EVENTS], force=True)
    assert [each.read_bytes() for each in tmp_path.iterdir()] == [b"older"]


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    ("name", "save", "array", "corruptions"),
    [
        ("records.npy", np.save, records(EVENTS.t_us)[:40], 10_000),
        ("rows.npy", np.save, np.asfortranarray(rows(SECONDS)[:40]), 1_000),
        ("plain.npz", np.savez, None, 10_000),
        ("packed.npz", np.savez_compressed, None, 1_000),
    ],
)
def test_a_damaged_file_is_refused_or_read(tmp_path: Path, name: str, save, array, corruptions: int) -> None:  # type: ignore[no-untyped-def]
    path = tmp_path / name
    if array is None:
        few = EVENTS[:40]
        save(path, t=few.t_us, x=few.x, y=few.y, p=few.p, width=640, height=480)
    else:
        save(path, array)
    outcomes = fuzz(path, path.read_bytes(), corruptions=corruptions, seed=len(name))
    assert min(outcomes.refused, outcomes.read) > 20


def test_arrays_of_evimo(tmp_path: Path) -> None:
    """Times in seconds of 32 bits, places in pairs; the lowest bit of p is the polarity."""
    t_s = np.array([1.9e-5, 2.05e-4, 0.5], np.float32)
    places, p = np.array([[50, 102], [52, 104], [1, 2]], np.uint16), np.array([3, 2, 1], np.uint8)
    np.savez(tmp_path / "a.npz", events_t=t_s, events_xy=places, events_p=p, meta=np.zeros(3))
    with open_recording(tmp_path / "a.npz") as file:
        assert rows_of(file.read().events) == [(19, 50, 102, 1), (205, 52, 104, 0), (500_000, 1, 2, 1)]
        assert file.details["polarity"].startswith("the lowest bit of events_p; ")
    np.savez(tmp_path / "b.npz", events_t=t_s, events_xy=np.zeros((3, 3)), events_p=p)
    assert "events_xy: is (3, 3) of float64: must be (n, 2), row by row" in refusal(tmp_path / "b.npz")


@pytest.mark.parametrize("save", [np.savez, np.savez_compressed])
def test_rows_of_evimo_among_frames_and_objects(tmp_path: Path, save: Any) -> None:
    """As EVIMO's tools write a sequence: events are rows t, x, y, p, the times in seconds; `meta` is a pickled dictionary."""
    rows = np.stack([EVENTS.t_us * 1e-6, EVENTS.x, EVENTS.y, EVENTS.p], axis=1)
    frames = {"classical": np.zeros((3, 5, 4, 3), np.uint8), "depth": np.zeros((3, 5, 4), np.uint16), "K": np.eye(3)}
    meta = np.array({"frames": []}, object)
    save(tmp_path / "sequence.npz", meta=meta, index=np.arange(9), events=rows, discretization=0.01, **frames)
    assert_same(read_recording(tmp_path / "sequence.npz").events, EVENTS)
    save(tmp_path / "other.npz", meta=meta, classical=frames["classical"])
    assert "no objects" in refusal(tmp_path / "other.npz")

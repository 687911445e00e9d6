# SPDX-License-Identifier: Apache-2.0
"""HDF5 recordings are read as by h5py, in every layout; damage is reported in one line."""

from __future__ import annotations

import json
import select
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.errors import RecordingError
from evcot.events import Events
from evcot.recordings.files import open_recording, read_recording
from evcot.recordings.formats import hdf5, hdf5_survey
from evcot.recordings.formats.printable import printable

from .fuzzing import cut_lengths, fuzz, sample_of
from .reading import assert_same, by_others, refusal, rows_of

WIDTH, HEIGHT = 64, 48
COUNT = 500
RANDOM = np.random.default_rng(11)
T_US = 1000 + np.sort(RANDOM.integers(0, 20_000, COUNT))
X, Y, P = (RANDOM.integers(0, limit, COUNT) for limit in (WIDTH, HEIGHT, 2))
OFFSET_US = 49_599_300_523

# A sample: where the library hangs, seconds pass.
CORRUPTIONS = sample_of(10_000, 400)

Write = Callable[[h5py.File], Any]


_SERVER = """
import importlib.util, json, sys
spec = importlib.util.spec_from_file_location("hdf5_survey", sys.argv[1])
module = importlib.util.module_from_spec(spec)
spec.loader.exec_module(module)
for line in sys.stdin:
    try:
        found = module._survey(line[:-1], False, "")
    except Exception as error:
        found = {"error": str(error)}
    print(json.dumps(found), flush=True)
"""


class Surveyor:
    """`survey` in milliseconds: one child for many files, and another when the HDF5 library hangs or ends it."""

    def __init__(self) -> None:
        self.stopped = 0
        self._start()

    def _start(self) -> None:
        command = [sys.executable, "-c", _SERVER, hdf5_survey.__file__]
        self.child = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)

    def __call__(self, path: Path, *, matlab: bool = False) -> hdf5_survey.Survey:
        assert self.child.stdin is not None
        assert self.child.stdout is not None
        self.child.stdin.write(f"{path}\n".encode())
        self.child.stdin.flush()
        ready = select.select([self.child.stdout], [], [], 5)[0]
        answer = self.child.stdout.readline() if ready else b""
        if not answer:
            self.close()
            self._start()
            self.stopped += 1
            raise RecordingError("the HDF5 library was stopped")
        found: hdf5_survey.Survey = json.loads(answer)
        if "error" in found:
            raise RecordingError(printable(found["error"]))
        return found

    def close(self) -> None:
        self.child.kill()
        self.child.communicate()


@pytest.fixture(scope="module")
def surveyor() -> Iterator[Surveyor]:
    surveyor = Surveyor()
    yield surveyor
    surveyor.close()


@pytest.fixture(autouse=True)
def _quick(monkeypatch: pytest.MonkeyPatch, surveyor: Surveyor) -> None:
    monkeypatch.setattr(hdf5, "survey", surveyor)


def put(group: h5py.Group, columns: dict[str, NDArray[Any]], **options: Any) -> None:
    for name, values in columns.items():
        group.create_dataset(name, data=values, **options)


def write_dsec(file: h5py.File, **options: Any) -> None:
    columns = {"t": T_US.astype("u4"), "x": X.astype("u2"), "y": Y.astype("u2"), "p": P.astype("u1")}
    put(file.create_group("events"), columns, **options)
    file["t_offset"] = OFFSET_US
    file["ms_to_idx"] = np.searchsorted(T_US, np.arange(T_US[-1] // 1000 + 1) * 1000).astype("u8")


def write_prophesee(file: h5py.File, **options: Any) -> None:
    events = np.zeros(COUNT, np.dtype([("x", "<u2"), ("y", "<u2"), ("p", "<i2"), ("t", "<i8")], align=True))
    events["t"], events["x"], events["y"], events["p"] = T_US, X, Y, P
    file.create_dataset("CD/events", data=events, **options)
    file.attrs["geometry"] = f"{WIDTH}x{HEIGHT}"


def write_e2vid(file: h5py.File) -> None:
    columns = {"ts": T_US * 1e-6, "xs": X.astype("i2"), "ys": Y.astype("i2"), "ps": P.astype(bool)}
    put(file.create_group("events"), columns, chunks=(64,))
    file.attrs["sensor_resolution"] = np.array([HEIGHT, WIDTH])


def write_mvsec(file: h5py.File) -> None:
    file["davis/left/events"] = np.stack([X, Y, T_US * 1e-6, 2 * P - 1], axis=1)


def write_m3ed(file: h5py.File) -> None:
    put(file.create_group("prophesee/left"), {"t": T_US, "x": X.astype("u2"), "y": Y.astype("u2"), "p": P.astype("i1")})
    file["prophesee/left/calib/resolution"] = np.array([WIDTH, HEIGHT])
    file["prophesee/right/t"] = T_US


def write_root(file: h5py.File) -> None:
    put(file, {"timestamps": T_US, "x": X, "y": Y, "polarity": 2 * P - 1}, compression="gzip", chunks=(100,), shuffle=True)
    file.attrs["width"], file.attrs["height"] = WIDTH, HEIGHT


def write_v2e(file: h5py.File) -> None:
    file.create_dataset("events", data=np.stack([T_US, X, Y, P], axis=1).astype("u4"), compression="gzip")


def write_with_sides(file: h5py.File) -> None:
    put(file.create_group("events"), {"t": T_US, "x": X, "y": Y, "p": P})
    file["events/width"], file["events/height"] = np.uint16(WIDTH), np.array([HEIGHT])


LAYOUTS: dict[str, tuple[Write, int, tuple[int, int] | None]] = {
    "dsec": (write_dsec, OFFSET_US, None),
    "dsec-gzip": (lambda file: write_dsec(file, compression="gzip", chunks=(33,)), OFFSET_US, None),
    "prophesee": (write_prophesee, 0, (WIDTH, HEIGHT)),
    "prophesee-gzip": (lambda file: write_prophesee(file, compression="gzip", chunks=(50,)), 0, (WIDTH, HEIGHT)),
    "e2vid": (write_e2vid, 0, (WIDTH, HEIGHT)),
    "mvsec": (write_mvsec, 0, None),
    "m3ed": (write_m3ed, 0, (WIDTH, HEIGHT)),
    "v2e": (write_v2e, 0, None),
    "sides": (write_with_sides, 0, (WIDTH, HEIGHT)),
    "root": (write_root, 0, (WIDTH, HEIGHT)),
}


def make(path: Path, write: Write, **options: Any) -> Path:
    with h5py.File(path, "w", **options) as file:
        write(file)
    return path


def assert_events(events: Events, begin: int = 0, offset_us: int = 0) -> None:
    assert_same(events, [column[begin:] for column in (T_US + offset_us, X, Y, P)])


@pytest.mark.parametrize("name", LAYOUTS)
def test_every_layout_and_every_window_of_it_is_read_as_it_is(tmp_path: Path, name: str) -> None:
    write, offset_us, sensor = LAYOUTS[name]
    path = make(tmp_path / "events.bin", write)
    recording = read_recording(path)
    assert_events(recording.events, offset_us=offset_us)
    assert (recording.width, recording.height) == (sensor or (X.max() + 1, Y.max() + 1))
    for from_us in (1, 3000, 7321, int(T_US[-1] - T_US[0])):
        events = read_recording(path, from_us=from_us).events
        assert_events(events, int(np.searchsorted(T_US, T_US[0] + from_us)), offset_us)


def count_looks(path: Path, monkeypatch: pytest.MonkeyPatch) -> int:
    """How many single times are looked at to find the place of 7 ms after the first event."""
    looks: list[int] = []
    time_at = hdf5.Hdf5File._time_at
    monkeypatch.setattr(hdf5.Hdf5File, "_time_at", lambda self, i: looks.append(i) or time_at(self, i))
    assert_events(read_recording(path, from_us=7000).events, int(np.searchsorted(T_US, T_US[0] + 7000)), OFFSET_US)
    return len(looks)


def test_the_index_of_milliseconds_finds_the_place_and_a_wrong_one_is_not_believed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = make(tmp_path / "events.h5", write_dsec)
    assert count_looks(path, monkeypatch) <= 2
    for wrong in (0, COUNT // 2, COUNT, COUNT + 1):
        with h5py.File(path, "r+") as file:
            file["ms_to_idx"][...] = wrong
        assert count_looks(path, monkeypatch) > 5


def test_every_chunk_is_decompressed_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = make(tmp_path / "events.h5", lambda file: write_dsec(file, compression="gzip", chunks=(33,)))
    monkeypatch.setattr(hdf5, "BLOCK_EVENTS", 40)
    reads: dict[str, list[tuple[int, int]]] = {}
    read = hdf5.Rows._read

    def noted(self: hdf5.Rows, begin: int, end: int) -> NDArray[Any]:
        reads.setdefault(self._dataset.name, []).append((begin, end))
        return read(self, begin, end)

    with open_recording(path, (WIDTH, HEIGHT)) as file:
        monkeypatch.setattr(hdf5.Rows, "_read", noted)
        assert_events(Events.joined(file._source.blocks()), offset_us=OFFSET_US)
    assert set(reads) == {"/events/t", "/events/x", "/events/y", "/events/p"}
    for windows in reads.values():
        assert [begin for begin, _ in windows] == [0, *(end for _, end in windows[:-1])]
        assert all(begin % 33 == 0 for begin, _ in windows)
        assert windows[-1][1] == COUNT


def test_seconds_are_rounded_to_the_nearest_microsecond(tmp_path: Path) -> None:
    seconds = np.array([0.1234564, 0.1234566, 1.5e9 + 0.25])
    columns = {"ts": seconds, "xs": np.zeros(3), "ys": np.zeros(3), "ps": np.ones(3)}
    path = make(tmp_path / "events.h5", lambda file: put(file.create_group("events"), columns))
    assert read_recording(path).events.t_us.tolist() == [123456, 123457, 1500000000250000]


@pytest.mark.parametrize("kind", ["f4", "f8"])
def test_floating_point_times_that_are_all_whole_are_microseconds(tmp_path: Path, kind: str) -> None:
    columns = {"t": T_US.astype(kind), "x": X, "y": Y, "p": P}
    path = make(tmp_path / "events.h5", lambda file: put(file.create_group("raw_events"), columns))
    with open_recording(path) as file:
        assert file.details["times in"] == "microseconds"
        assert_events(file.read().events)
        assert_events(file.read(from_us=7321).events, int(np.searchsorted(T_US, T_US[0] + 7321)))


@pytest.mark.parametrize(
    ("column", "values", "message"),
    [
        ("t", [0.0, np.nan, 1.0], "event 1: t = nan: must be a number of seconds"),
        ("t", [0.0, 1e300, 1.0], "event 1: t = 1e+300: must be a number of seconds"),
        ("t", [30_000, 1, 4], "event 1: t = 1 us follows t = 30000 us: time must not run back"),
        ("x", [0, 1.5, 0], "event 1: x = 1.5: must be a whole number from 0 to 65535"),
        ("x", [0, 1, -1], "event 2: x = -1: must be a whole number from 0 to 65535"),
        ("y", np.array([0, 1 << 63, 0], "u8"), f"event 1: y = {1 << 63}: must be a whole number from 0 to 65535"),
        ("p", [0, 1, 2], "event 2: p = 2: must be 0 or 1"),
        ("p", [0, -2, 1], "event 1: p = -2: must be a whole number from 0 to 255"),
        ("p", [0, 1], "/events/t 3, /events/x 3, /events/y 3, /events/p 2 values: all must be the same"),
        ("x", [b"a", b"b", b"c"], "/events/x: is (3,) of |S1: must be a list of numbers"),
        ("x", [[1], [2], [3]], "/events/x: is (3, 1) of int64: must be a list of numbers"),
    ],
)
def test_numbers_that_break_a_rule_are_named(tmp_path: Path, column: str, values: Any, message: str) -> None:
    columns = {"t": np.arange(3), "x": np.zeros(3), "y": np.zeros(3), "p": np.ones(3)} | {column: np.asarray(values)}
    assert refusal(make(tmp_path / "events.h5", lambda file: put(file.create_group("events"), columns))) == message


def test_a_file_without_events_or_whose_values_were_never_written_is_refused(tmp_path: Path) -> None:
    def write(file: h5py.File) -> None:
        write_dsec(file, chunks=(100,), maxshape=(None,))
        for name in "txyp":
            file["events"][name].resize((COUNT + 300,))

    empty = {name: np.empty(0, "u4") for name in "txyp"}
    for write_, told in (
        (write, "/events/t: holds 5 of 8 chunks: must hold all"),
        (lambda file: file.create_group("frames"), "holds no events in a known layout: has frames at its top level"),
        (lambda file: put(file.create_group("events"), empty), "holds no events"),
    ):
        assert refusal(make(tmp_path / "a.h5", write_)) == told


def with_filter(code: int) -> Write:
    def write(file: h5py.File) -> None:
        write_dsec(file)
        del file["events/t"]
        creation = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
        creation.set_chunk((100,))
        creation.set_filter(code, h5py.h5z.FLAG_OPTIONAL, ())
        space = h5py.h5s.create_simple((COUNT,))
        dataset = h5py.Dataset(h5py.h5d.create(file["events"].id, b"t", h5py.h5t.NATIVE_UINT32, space, creation))
        dataset[...] = T_US

    return write


def test_a_compression_that_is_not_installed_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(h5py.h5z, "filter_avail", lambda _: False)
    monkeypatch.setitem(sys.modules, "hdf5plugin", None)
    for code, said in (
        (36559, "ECF (HDF5 filter 36559): needs Prophesee's plugin hdf5_ecf in $HDF5_PLUGIN_PATH, or the recording as RAW"),
        (32001, "Blosc (HDF5 filter 32001): needs pip install 'evcot[hdf5]'"),
    ):
        assert refusal(make(tmp_path / "events.h5", with_filter(code))) == f"/events/t: is compressed by {said}"


def test_blosc_is_read_where_its_plugin_is_installed(tmp_path: Path) -> None:
    hdf5plugin = pytest.importorskip("hdf5plugin")
    path = make(tmp_path / "events.h5", lambda file: write_dsec(file, chunks=(100,), **hdf5plugin.Blosc(cname="zstd")))
    assert_events(read_recording(path).events, offset_us=OFFSET_US)


def test_a_library_that_hangs_or_dies_is_a_refusal(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = make(tmp_path / "events.h5", write_dsec)
    monkeypatch.setattr(hdf5, "survey", hdf5_survey.survey)
    assert_events(read_recording(path).events, offset_us=OFFSET_US)
    monkeypatch.setattr(hdf5_survey, "SECONDS", 0.001)
    assert refusal(path) == "the HDF5 library did not finish reading the file's structure within 0.001 s: is it damaged?"
    monkeypatch.setattr(hdf5_survey, "SECONDS", 20.0)
    monkeypatch.setattr(hdf5_survey.sys, "executable", "/bin/false")
    assert refusal(path) == "the HDF5 library crashed (status 1): is the file damaged?"


@pytest.mark.parametrize("write", [write_dsec, write_prophesee], ids=["dsec", "prophesee"])
def test_damage_is_told_or_does_not_matter(tmp_path: Path, surveyor: Surveyor, write: Write) -> None:
    content = make(tmp_path / "whole.h5", write).read_bytes()
    outcomes = fuzz(tmp_path / "events.h5", content, cuts=False, corruptions=CORRUPTIONS, seed=21)
    assert outcomes.refused
    assert outcomes.read
    cut = tmp_path / "cut.h5"
    for length in cut_lengths(content, 60):
        cut.write_bytes(content[:length])
        refusal(cut)
    print(f"the HDF5 library was stopped {surveyor.stopped} times")


def test_another_reader_finds_the_same(tmp_path: Path) -> None:
    path = make(tmp_path / "events.h5", write_dsec)
    theirs = by_others("eventcv", path, time_unit="microseconds")
    assert_events(Events(theirs.t_us - theirs.t_us[0] + T_US[0], theirs.x, theirs.y, theirs.p))


@pytest.mark.parametrize("align", [False, True])
@pytest.mark.parametrize(("p", "wanted"), [([1, 0, 1], [1, 0, 1]), ([1, -1, 1], [1, 0, 1]), ([1, 0, 2], None)])
def test_whole_records_mean_what_columns_mean(tmp_path: Path, p: list[int], wanted: list[int] | None, align: bool) -> None:
    records = np.zeros(3, np.dtype([("x", "<u2"), ("y", "<u2"), ("p", "<i2"), ("t", "<i8")], align=align))
    records["x"], records["y"], records["p"], records["t"] = [5, 6, 7], [1, 2, 3], p, [10, 11, 12]
    path = make(tmp_path / "events.h5", lambda file: file.create_dataset("CD/events", data=records))
    if wanted is None:
        assert refusal(path) == "event 2: p = 2: must be 0 or 1"
    else:
        assert rows_of(read_recording(path).events) == list(zip([10, 11, 12], [5, 6, 7], [1, 2, 3], wanted, strict=True))


@pytest.mark.parametrize("place", ["raw_events", "camera/left/dvs"])
def test_events_in_a_group_of_any_name(place: str, tmp_path: Path) -> None:
    def write(file: h5py.File) -> None:
        file.create_dataset("frames/t", data=np.arange(9))
        put(file.create_group(place), {"t": T_US * 1e-6, "x": X, "y": Y, "p": P.astype(bool)})

    with open_recording(make(tmp_path / "a.h5", write)) as found:
        assert found.details["events"] == place
        assert_events(found.read().events)

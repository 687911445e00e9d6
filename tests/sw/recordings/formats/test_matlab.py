# SPDX-License-Identifier: Apache-2.0
"""MATLAB structs of events, as written by scipy and h5py, in every coding of pixels and polarity."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import scipy.io

from evcot.errors import RecordingError
from evcot.events import Events
from evcot.recordings.files import open_recording, read_recording

from .fuzzing import fuzz
from .reading import assert_same, refusal

COUNT = 60
RANDOM = np.random.default_rng(5)
T_US = np.sort(RANDOM.integers(0, 9000, COUNT))
X, Y, P = (RANDOM.integers(0, limit, COUNT) for limit in (34, 30, 2))
X[0] = 0  # so that pixels counted from 0 can be told
POLARITIES = {"1 and 2": P + 1, "-1 and 1": 2 * P - 1, "0 and 1": P, "logical": P.astype(bool)}


def struct(first: int, p: Any, kind: type = np.float64) -> dict[str, Any]:
    return {"x": (X + first).astype(kind), "y": (Y + first).astype(kind), "p": p, "ts": T_US.astype(kind)}


def write(path: Path, content: dict[str, Any], **options: Any) -> Path:
    scipy.io.savemat(path, content, **options)
    return path


def write_7_3(path: Path, content: dict[str, Any], **storage: Any) -> Path:
    """Arrays as they are stored, behind the head of a MATLAB file."""
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in content.items():
            file.create_dataset(name, data=values, **storage)
        file["#refs#/a"] = 1
    with path.open("r+b") as raw:
        raw.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")
    return path


def write_struct_7_3(path: Path, content: dict[str, Any]) -> Path:
    arrays = {f"TD/{name}": np.asarray(values, float)[None] for name, values in content.items()}
    return write_7_3(path, arrays, chunks=(1, 25), compression="gzip")


def write_variables(path: Path, content: dict[str, Any], version: str, **storage: Any) -> Path:
    """Variables that are numbers, as MATLAB's `save` writes them: matrices of 7.3 are stored as rows for columns."""
    if version != "7.3":
        return write(path, content, do_compression=version == "7")
    return write_7_3(path, {name: np.atleast_2d(values).T for name, values in content.items()}, **storage)


def assert_events(events: Events, later_us: int = 0) -> None:
    assert_same(events, (T_US + later_us, X, Y, P))


@pytest.mark.parametrize("compressed", [False, True], ids=["plain", "compressed"])
@pytest.mark.parametrize("coding", POLARITIES)
@pytest.mark.parametrize("first", [0, 1])
@pytest.mark.parametrize("kind", [np.float64, np.uint16, np.int32])
def test_every_coding_is_told_from_the_data(tmp_path: Path, first: int, coding: str, kind: type, compressed: bool) -> None:
    content = {"before": np.arange(3), "TD": struct(first, POLARITIES[coding], kind), "after": {"x": 1}}
    with open_recording(write(tmp_path / "events.bin", content, do_compression=compressed)) as file:
        assert_events(file.read().events)
        assert file.details == {"struct": "TD", "pixels": f"counted from {first}"}
        assert file.sensor == (X.max() + 1, Y.max() + 1)


def test_a_struct_of_another_name_and_more_fields_or_of_version_7_3_is_found(tmp_path: Path) -> None:
    content = {"recording": {"label": "seven", **struct(1, P + 1), "cells": np.array([1, "a"], object)}}
    assert_events(read_recording(write(tmp_path / "events.mat", content)).events)
    assert_events(read_recording(write_struct_7_3(tmp_path / "new.mat", struct(1, P + 1))).events)


def test_big_endian_files_are_read(tmp_path: Path) -> None:
    """scipy writes none: one is put together by hand."""

    def element(kind: int, content: bytes) -> bytes:
        return np.array([kind, len(content)], ">u4").tobytes() + content + bytes(-len(content) % 8)

    def matrix(kind: int, sides: tuple[int, int], name: bytes, content: bytes) -> bytes:
        head = element(6, np.array([kind, 0], ">u4").tobytes()) + element(5, np.array(sides, ">i4").tobytes())
        return element(14, head + element(1, name) + content)

    columns = {b"x": X + 1, b"y": Y + 1, b"p": P + 1, b"ts": T_US}
    names = element(5, np.array([8], ">i4").tobytes()) + element(1, b"".join(name.ljust(8, b"\0") for name in columns))
    fields = b"".join(matrix(6, (COUNT, 1), b"", element(9, values.astype(">f8").tobytes())) for values in columns.values())
    path = tmp_path / "events.mat"
    path.write_bytes(b"MATLAB 5.0 MAT-file".ljust(124) + b"\x01\x00MI" + matrix(2, (1, 1), b"TD", names + fields))
    assert_events(read_recording(path).events)


@pytest.mark.parametrize("names", [("x", "y", "pol", "t"), ("xs", "ys", "polarity", "timestamp")])
def test_the_fields_may_be_called_otherwise(tmp_path: Path, names: tuple[str, ...]) -> None:
    content = dict(zip(names, struct(0, P).values(), strict=True))
    assert_events(read_recording(write(tmp_path / "events.mat", {"events": content | {"note": "text"}})).events)
    assert_events(read_recording(write_struct_7_3(tmp_path / "new.mat", content)).events)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ({"a": 1, "b": {"x": 1}}, "holds 2 variables, no struct with the fields x, y, p, ts, and no matrix of four columns"),
        ({"TD": struct(1, P[:-1])}, "x 60, y 60, p 59, ts 60 values: all must be the same"),
        ({"TD": struct(1, P + 3)}, "event 0: p = {}: must be 0 or 1"),
        ({"TD": struct(1, "abc")}, "p: is a matrix of class 4: must hold numbers"),
        ({"TD": struct(1, P) | {"x": X + 0.5}}, "event 0: x = 0.5: must be a whole number from -2147483648 to 2147483647"),
        ({"TD": struct(1, P) | {"ts": 1000 * T_US[::-1]}}, "event 1: t = {} us follows t = {} us: time must not run back"),
        ({"TD": struct(1, P) | {"ts": T_US * 1j}}, "must be of real numbers"),
    ],
)
def test_a_struct_that_breaks_a_rule_is_refused(tmp_path: Path, content: dict[str, Any], message: str) -> None:
    got = refusal(write(tmp_path / "events.mat", content))
    parts = message.split("{}")
    assert got.startswith(parts[0]) or got.endswith(parts[0])
    assert all(part in got for part in parts)


@pytest.mark.parametrize(
    ("content", "compressed", "corruptions"),
    [
        ({"TD": struct(1, P + 1, np.uint16)}, False, 10_000),
        ({"TD": struct(1, P + 1, np.uint16)}, True, 10_000),
        ({"events": np.stack([T_US + 70_000, X, Y, P], axis=1).astype(np.uint32)}, False, 1_000),
    ],
    ids=["plain", "compressed", "matrix"],
)
def test_damage_is_told_or_does_not_matter(tmp_path: Path, content: dict[str, Any], compressed: bool, corruptions: int) -> None:
    whole = write(tmp_path / "whole.mat", content, do_compression=compressed).read_bytes()
    outcomes = fuzz(tmp_path / "events.mat", whole, corruptions=corruptions, seed=31)
    assert outcomes.refused > len(whole) // 2
    assert outcomes.read


def exposures() -> dict[str, Any]:
    """What an ATIS measures beside changes: as many events, elsewhere."""
    return struct(0, P) | {"x": X[::-1].astype(float)}


@pytest.mark.parametrize("version", ["5", "7.3"])
def test_of_several_structs_the_one_with_changes_is_read_and_the_others_are_named(tmp_path: Path, version: str) -> None:
    path = tmp_path / "several.mat"
    if version == "5":
        write(path, {"EM": exposures(), "TD": struct(0, P), "more": exposures()}, do_compression=True)
    else:
        structs = {"TD": struct(0, P), "EM": exposures()}
        write_7_3(path, {f"{name}/{field}": [values] for name, each in structs.items() for field, values in each.items()})
    with open_recording(path) as file:
        assert file.details["struct"] == "TD"
        assert file.details["also holds"] == ("EM, more" if version == "5" else "EM")
        assert_events(file.read().events)
    with open_recording(path, struct="EM") as file:
        assert file.details["struct"] == "EM"
        np.testing.assert_array_equal(file.read().events.x, X[::-1])
    with pytest.raises(RecordingError, match=r"has no struct 'EX' of events: must be one of EM, TD(, more)?$"):
        open_recording(path, struct="EX")


def test_the_first_struct_is_read_where_none_is_called_td(tmp_path: Path) -> None:
    path = write(tmp_path / "several.mat", {"b": struct(0, P), "a": exposures()})
    with open_recording(path) as file:
        assert (file.details["struct"], file.details["also holds"]) == ("b", "a")


@pytest.mark.parametrize("order", ["txyp", "xytp", "xypt", "ptxy"])
@pytest.mark.parametrize("kind", ["seconds", "whole", "uint32"])
@pytest.mark.parametrize("coding", ["1 and 2", "-1 and 1", "0 and 1"])
@pytest.mark.parametrize("version", ["5", "7", "7.3"])
def test_a_matrix_of_four_columns_is_read_in_any_order(
    tmp_path: Path, order: str, kind: str, coding: str, version: str
) -> None:
    t = (T_US + 70_000) * (1e-6 if kind == "seconds" else 1)
    rows = np.stack([{"t": t, "x": X, "y": Y, "p": POLARITIES[coding]}[name] for name in order], axis=1)
    if kind == "uint32" and coding != "-1 and 1":
        rows = rows.astype(np.uint32)
    content: dict[str, Any] = {"camera": np.eye(4), "events": rows} | ({} if version == "7.3" else {"note": "text"})
    with open_recording(write_variables(tmp_path / "events.mat", content, version)) as file:
        events = file.read().events
        assert file.details["matrix"] == "events"
        assert file.details["columns"].startswith(f"{', '.join(order)}, assumed by their values; ")
        assert file.details["times in"] == ("seconds" if kind == "seconds" else "microseconds")
    assert_events(events, 70_000)


@pytest.mark.parametrize("chunks", [(1, 25), (2, 25), (4, 7), (4, COUNT)])
@pytest.mark.parametrize("filters", [{"compression": "gzip"}, {"compression": "gzip", "shuffle": True}, {}])
def test_a_matrix_of_version_7_3_may_be_in_chunks(tmp_path: Path, chunks: tuple[int, int], filters: dict[str, Any]) -> None:
    rows = np.stack([X, Y, T_US + 70_000, P], axis=1).astype(float)
    path = write_variables(tmp_path / "events.mat", {"m": rows}, "7.3", chunks=chunks, **filters)
    assert_events(read_recording(path).events, 70_000)


def test_of_several_matrices_of_version_7_3_the_longest_is_read_or_the_named(tmp_path: Path) -> None:
    rows = np.stack([T_US + 70_000, X, Y, P], axis=1)
    path = write_variables(tmp_path / "events.mat", {"a": rows[:30], "b": rows}, "7.3")
    for options, name, count in (({}, "b", COUNT), ({"struct": "a"}, "a", 30)):
        with open_recording(path, **options) as file:
            assert (file.details["matrix"], len(file.read().events)) == (name, count)
    with pytest.raises(RecordingError, match=r"has no struct 'c' of events: must be one of b, a$"):
        open_recording(path, struct="c")


@pytest.mark.parametrize("version", ["5", "7", "7.3"])
@pytest.mark.parametrize("names", [("x", "y", "p", "t"), ("xs", "ys", "pol", "ts")])
@pytest.mark.parametrize("scale", [1, 1e-6])
@pytest.mark.parametrize("upright", [False, True])
def test_four_variables_are_read(tmp_path: Path, version: str, names: tuple[str, ...], scale: float, upright: bool) -> None:
    values = (X + 1, Y + 1, P + 1, T_US * scale)
    content = {name: each[:, None] if upright else each[None] for name, each in zip(names, values, strict=True)}
    path = write_variables(tmp_path / "events.mat", content | {"gain": np.ones((1, 1)), "k": np.eye(4)}, version)
    with open_recording(path) as file:
        assert_events(file.read().events)
        assert file.details["variables"] == "x, y, p, ts"
        assert ("times in", "seconds") in file.details.items() or scale == 1


def test_a_struct_comes_before_a_matrix_and_small_matrices_are_no_events(tmp_path: Path) -> None:
    content = {"camera": np.ones((90, 4)), "TD": struct(0, P)}
    assert_events(read_recording(write(tmp_path / "events.mat", content)).events)
    assert "event 0: x = 0.5: must be a whole number" in refusal(write(tmp_path / "k.mat", {"k": np.full((4, 4), 0.5)}))
    message = refusal(write(tmp_path / "m.mat", {"m": np.stack([X, Y, X, P], axis=1)}))
    assert message.startswith("m: columns without names: ")


def test_a_file_that_has_no_structs_says_so(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("t,x,y,p\n1,2,3,1\n")
    with pytest.raises(RecordingError, match=r"a\.csv: is .*, which has no structs: struct must not be given$"):
        open_recording(path, struct="TD")

# SPDX-License-Identifier: Apache-2.0
"""Events and tracks in the forms of other packages."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.errors import ConfigError, RecordingError
from evcot.events import Events, Recording
from evcot.structured import EVENT_CD
from evcot.tracks.log import TRACK, Kind, TrackLog
from support.logs import log_of
from support.refusals import refused

TONIC = np.dtype([("x", np.int16), ("y", np.int16), ("t", np.int64), ("p", bool)])
OWN = np.dtype([("t", np.int64), ("x", np.uint16), ("y", np.uint16), ("p", np.uint8)])
ALIGNED = np.dtype([("x", "<u4"), ("y", "<u4"), ("p", "<i8"), ("t", "<u8")], align=True)
LAYOUTS = pytest.mark.parametrize("dtype", [EVENT_CD, TONIC, OWN, ALIGNED], ids=["openeb", "tonic", "own", "wide"])
FIELDS = {"t_us": "t", "x": "x", "y": "y", "p": "p"}


def sample(n: int = 500) -> Events:
    random = np.random.default_rng(1)
    t_us = np.sort(random.integers(0, 10**12, n))
    x, y = random.integers(0, 300, n).astype(np.uint16), random.integers(0, 200, n).astype(np.uint16)
    return Events(t_us, x, y, random.integers(0, 2, n).astype(np.uint8))


def same(one: Events, other: Events) -> bool:
    return all(np.array_equal(getattr(one, field), getattr(other, field)) for field in FIELDS)


def array(dtype: np.dtype[Any] = EVENT_CD, **fields: list[int]) -> NDArray[np.void]:
    """Three sound events, with other values in some fields."""
    values = {"x": [1, 2, 3], "y": [4, 5, 6], "p": [0, 1, 0], "t": [10, 10, 30]} | fields
    made = np.zeros(3, dtype)
    for name in dtype.names or ():
        made[name] = values[name]
    return made


@LAYOUTS
def test_there_and_back_is_the_same_and_columns_are_views_of_the_array(dtype: np.dtype[Any]) -> None:
    events = sample()
    made = events.to_array(dtype)
    assert made.dtype == dtype
    back = Events.from_array(made)
    assert same(back, events)
    assert [column.dtype for column in (back.t_us, back.x, back.y, back.p)] == [np.int64, np.uint16, np.uint16, np.uint8]
    assert all(np.shares_memory(getattr(back, column), made) for column in FIELDS)
    made["x"][7] = 123
    assert back.x[7] == 123


def test_narrower_fields_and_the_other_byte_order_are_copied() -> None:
    dtype = np.dtype([("x", "u1"), ("y", ">u2"), ("p", "?"), ("t", "<u4")])
    made = array(dtype)
    events = Events.from_array(made)
    assert events.t_us.tolist() == [10, 10, 30]
    assert events.x.tolist() == [1, 2, 3]
    assert events.y.tolist() == [4, 5, 6]
    assert [np.shares_memory(getattr(events, column), made) for column in FIELDS] == [False, False, False, True]


def test_other_fields_are_ignored_and_no_events_are_fine() -> None:
    dtype = np.dtype([*EVENT_CD.descr, ("camera", "u1")])
    assert len(Events.from_array(np.zeros(4, dtype))) == 4
    assert len(Events.from_array(np.empty(0, EVENT_CD))) == 0
    assert len(Events.empty().to_array()) == 0
    events = sample()
    assert not any(np.shares_memory(events.to_array(), getattr(events, column)) for column in FIELDS)


def test_a_recording_has_columns_without_gaps() -> None:
    made = sample().to_array()
    events = Events.from_array(made)
    assert not events.x.flags.c_contiguous
    recording = Recording(events, 300, 200)
    columns = (recording.events.t_us, recording.events.x, recording.events.y, recording.events.p)
    assert all(column.flags.c_contiguous and column.flags.aligned for column in columns)
    assert same(recording.events, events)


def test_what_is_packed_stays_what_it_is() -> None:
    events = sample()
    assert events.packed() is events
    assert Recording(events, 300, 200).events is events
    one = Events.from_array(sample(1).to_array())  # without gaps, but its time is at an odd address for 64 bits
    assert all(column.flags.aligned for column in (one.packed().t_us, one.packed().x, one.packed().y))


@pytest.mark.parametrize(
    ("made", "message"),
    [
        (np.zeros(3, np.int64), "array: no field t: must be a structured array with the fields x, y, p and t"),
        (np.zeros(3, [("x", "u2"), ("t", "i8"), ("p", "?")]), "array: no field y: must be"),
        (np.zeros(3, [("x", "u2"), ("y", "u2"), ("t", "f8"), ("p", "?")]), "array: field t is float64: must be a whole number"),
        (np.zeros(3, [("x", "?"), ("y", "u2"), ("t", "i8"), ("p", "?")]), "array: field x is bool: must be a whole number"),
        (np.zeros((3, 2), EVENT_CD), "array: 2 dimensions: must be one, with one entry an event"),
        (array(TONIC, x=[1, -1, 3]), "array: event 1: x = -1: must be from 0 to 65535"),
        (array(ALIGNED, y=[1, 2, 65_536]), "array: event 2: y = 65536: must be from 0 to 65535"),
        (array(p=[1, 0, -1]), "array: event 2: p = -1: must be from 0 to 1"),
        (array(p=[256, 0, 1]), "array: event 0: p = 256: must be from 0 to 1"),
        (array(ALIGNED, t=[1, 2, 2**63]), f"array: event 2: t = {2**63}: must be from {-(2**63)} to {2**63 - 1}"),
        (array(t=[10, 9, 30]), "array: event 1: t = 9 us follows t = 10 us: time must not run back"),
    ],
)
def test_what_is_wrong_is_named(made: NDArray[np.void], message: str) -> None:
    with refused(RecordingError, start=message):
        Events.from_array(made)


@pytest.mark.parametrize(
    ("dtype", "message"),
    [
        ([("x", "u2"), ("y", "u2"), ("p", "u1")], "array: no field t: must be"),
        ([("x", "u2"), ("y", "u2"), ("p", "u1"), ("t", "f8")], "array: field t is float64: must be a whole number"),
        ([*EVENT_CD.descr, ("id", "u1")], "array: field 'id': must be one of x, y, p, t"),
        ([("x", "u1"), ("y", "u2"), ("p", "u1"), ("t", "i8")], "array: event 1: x = 256: must be from 0 to 255"),
        ([("x", "u2"), ("y", "u2"), ("p", "u1"), ("t", "u4")], f"array: event 1: t = {2**32}: must be from 0 to {2**32 - 1}"),
    ],
)
def test_a_layout_that_cannot_hold_the_events_is_refused(dtype: list[tuple[str, str]], message: str) -> None:
    events = Events(
        np.array([0, 2**32]), np.array([0, 256], np.uint16), np.array([0, 1], np.uint16), np.array([0, 1], np.uint8)
    )
    with refused(RecordingError, start=message):
        events.to_array(dtype)


def test_eventcv_takes_the_columns_side_by_side() -> None:
    eventcv = pytest.importorskip("eventcv")
    events = sample()
    stream = eventcv.from_numpy(np.stack([events.x, events.y, events.t_us, events.p], axis=1), time_unit="us")
    x, y, t_us, p = np.asarray(stream.numpy()).T
    assert same(Events(t_us, x, y, p), events)


EVENTS = Events(np.array([3, 5, 8]), *np.array([[0, 1, 2], [7, 8, 9]], np.uint16), np.array([1, 0, 1], np.uint8))
LOG = log_of([(10, Kind.BORN, 0, 1.5, 2.5), (20, Kind.BORN, 1, 9.0, 9.0), (50, Kind.MERGED, 1, 7.0, 7.0, 0)])
PACKAGES = pytest.mark.parametrize("package", ["pandas", "polars"])


def frame_of(thing: Any, package: str) -> Any:
    pytest.importorskip(package)
    return getattr(thing, f"to_{package}")()


@PACKAGES
def test_events_are_columns_of_their_own_types_and_a_copy(package: str) -> None:
    events = Events(*(column.copy() for column in (EVENTS.t_us, EVENTS.x, EVENTS.y, EVENTS.p)))
    frame = frame_of(events, package)
    events.x[:] = 99
    assert list(frame.columns) == ["t_us", "x", "y", "p"]
    for name in frame.columns:
        column = frame[name].to_numpy()
        assert column.dtype == getattr(EVENTS, name).dtype
        np.testing.assert_array_equal(column, getattr(EVENTS, name))


@PACKAGES
def test_records_keep_all_fields(package: str) -> None:
    frame = frame_of(LOG, package)
    assert tuple(frame.columns) == TRACK.names
    for name in frame.columns:
        np.testing.assert_array_equal(frame[name].to_numpy(), LOG.records[name])


@PACKAGES
def test_what_a_track_does_not_have_is_missing(package: str) -> None:
    frame = frame_of(LOG.tracks, package)
    assert frame["id"].to_list() == [0, 1]
    assert frame["born_us"].to_list() == [10, 20]
    missing = frame["ended_us"].isna() if package == "pandas" else frame["ended_us"].is_null()
    assert missing.to_list() == [True, False]
    assert frame["ended_us"].to_list()[1] == 50
    assert frame["merged_into"].to_list()[1] == 0
    assert str(frame["ended_us"].dtype) == "Int64"


@PACKAGES
def test_nothing_gives_no_rows(package: str) -> None:
    empty = TrackLog.empty("rct")
    assert [len(frame_of(thing, package)) for thing in (Events.empty(), empty, empty.tracks)] == [0, 0, 0]


@PACKAGES
def test_a_missing_package_is_said_with_its_extra(package: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, package, None)
    for thing in (EVENTS, LOG, LOG.tracks):
        with refused(ConfigError, f"to_{package}: {package} is not installed: pip install 'evcot[{package}]'"):
            getattr(thing, f"to_{package}")()

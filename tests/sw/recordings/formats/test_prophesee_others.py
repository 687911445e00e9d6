# SPDX-License-Identifier: Apache-2.0
"""evcot's decoders compared with those of other packages: where they agree event by event, and the known differences."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import faery
import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.events import Events
from evcot.recordings.files import read_recording
from shared import SHARED

from .reference_evt import dat_event, evt2_event, evt2_high, evt21_event, evt21_high, packed

FIXTURES = {"evt2": "fixture_evt2_640x480.raw", "evt3": "fixture_evt3_1280x720.raw"}

Columns = list[NDArray[Any]]


def by_faery(path: Path, _: str) -> Columns:
    events = faery.events_stream_from_file(path).to_array()
    return [events[name] for name in ("t", "x", "y", "on")]


def by_evt3(path: Path, _: str) -> Columns:
    events = pytest.importorskip("evt3").decode_file(str(path))
    return [events.t, events.x, events.y, events.p]


def by_expelliarmus(path: Path, kind: str) -> Columns:
    events = pytest.importorskip("expelliarmus").Wizard(encoding=kind).read(path)
    return [events[name] for name in ("t", "x", "y", "p")]


def by_eventcv(path: Path, _: str) -> Columns:
    x, y, t, p = pytest.importorskip("eventcv").load(str(path)).numpy().T
    return [t, x, y, p]


def shared(kind: str) -> Path:
    path = SHARED / FIXTURES[kind]
    if not path.is_file():
        pytest.skip(f"{path.name} is not on this machine")
    return path


def differences(columns: Columns, events: Events) -> dict[str, NDArray[np.int64]]:
    """Theirs less ours, per column that differs."""
    assert len(columns[0]) == len(events)
    names = ("t_us", "x", "y", "p")
    found = {name: theirs.astype(np.int64) - getattr(events, name) for name, theirs in zip(names, columns, strict=True)}
    return {name: values for name, values in found.items() if values.any()}


@pytest.mark.parametrize(
    ("decode", "kind"),
    [(by_faery, "evt2"), (by_evt3, "evt3"), (by_expelliarmus, "evt2"), (by_eventcv, "evt2"), (by_eventcv, "evt3")],
)
def test_every_event_of_a_camera_s_file_is_as_others_read_it(decode: Callable[[Path, str], Columns], kind: str) -> None:
    path = shared(kind)
    assert differences(decode(path, kind), read_recording(path).events) == {}


def test_faery_moves_events_of_evt3_up_to_a_mark_that_runs_ahead() -> None:
    path = shared("evt3")
    later = differences(by_faery(path, "evt3"), read_recording(path).events)
    assert list(later) == ["t_us"]
    assert (np.count_nonzero(later["t_us"]), later["t_us"].min(), later["t_us"].max()) == (1455, 0, 11)


def test_expelliarmus_adds_turns_to_evt3_that_are_none() -> None:
    path = shared("evt3")
    later = differences(by_expelliarmus(path, "evt3"), read_recording(path).events)
    assert list(later) == ["t_us"]
    assert later["t_us"].min() == 0
    assert set(np.unique(later["t_us"] % 4096).tolist()) == {0}


def evt21_file(path: Path) -> Path:
    random = np.random.default_rng(3)
    words = []
    for mark in range(2000):
        x, y, p, low, valid = (int(each) for each in random.integers(0, (10, 320, 2, 64, 1 << 32)))
        words += [evt21_high(mark), evt21_event(p, low, 32 * x, y, valid)]
    header = b"% evt 2.1\n% format EVT21;endianness=little;height=320;width=320\n% geometry 320x320\n% end\n"
    path.write_bytes(packed("evt21", words, header))
    return path


def test_eventcv_reads_evt21_as_something_else(tmp_path: Path) -> None:
    path = evt21_file(tmp_path / "events.raw")
    events = read_recording(path).events
    columns = by_eventcv(path, "evt21")
    assert len(columns[0]) != len(events) or differences(columns, events)


@pytest.mark.parametrize("decode", [by_faery, by_expelliarmus, by_eventcv])
def test_dat_is_as_others_read_it(tmp_path: Path, decode: Callable[[Path, str], Columns]) -> None:
    random = np.random.default_rng(4)
    times = np.sort(random.integers(0, 1 << 31, 3000)).tolist()
    words = [dat_event(t, *(int(each) for each in random.integers(0, (640, 480, 2)))) for t in times]
    path = tmp_path / "events.dat"
    path.write_bytes(packed("dat2", words, b"% Version 2\n% Width 640\n% Height 480\n\x0c\x08"))
    assert differences(decode(path, "dat"), read_recording(path).events) == {}


@pytest.mark.parametrize("decode", [by_faery, by_expelliarmus, by_eventcv])
def test_evt2_with_triggers_is_as_others_read_it(tmp_path: Path, decode: Callable[[Path, str], Columns]) -> None:
    random = np.random.default_rng(5)
    words = []
    for mark in range(1000, 3000):
        x, y, p = (int(each) for each in random.integers(0, (640, 480, 2)))
        words += [evt2_high(mark), evt2_event(p, mark % 64, x, y)] + ([10 << 28 | 63 << 22 | 1] if mark % 9 == 0 else [])
    path = tmp_path / "events.raw"
    path.write_bytes(packed("evt2", words, b"% evt 2.0\n% format EVT2;height=480;width=640\n% geometry 640x480\n% end\n"))
    assert differences(decode(path, "evt2"), read_recording(path).events) == {}

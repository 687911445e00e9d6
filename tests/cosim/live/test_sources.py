# SPDX-License-Identifier: Apache-2.0
"""Events as they happen: a file at its own speed, and packets from a sender without flow control."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterable
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

from evcot.errors import ConfigError, RecordingError
from evcot.events import Events, Recording
from evcot.recordings.files import open_recording, write_recording
from evcot_cosim.live.sources import CameraSource, FileSource, NetworkSource, StreamSource

from .stories import SENSOR, events, random_events


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """0.4 s of events, 100 us apart; the first at 5 s."""
    some = random_events(4_000, 1, step_us=100)
    some = Events(some.t_us - some.t_us[0] + 5_000_000, some.x, some.y, some.p)
    write_recording(Recording(some, *SENSOR), tmp_path / "some.npz")
    return tmp_path / "some.npz"


def test_a_loop_begins_again_and_time_goes_on(path: Path) -> None:
    source = FileSource(open_recording(path, SENSOR), (0, 50_000), 100.0, loop=True)
    parts: list[Events] = []
    for arrival in source.arrivals(lambda: True):
        parts.append(arrival.events)
        if sum(map(len, parts)) >= 1_600:
            break
    source.close()
    t_us = np.concatenate([part.t_us for part in parts])
    steps = np.diff(t_us)
    assert (steps >= 0).all()
    assert len(t_us) >= 1_500  # three passes of 500 events
    pauses = steps[steps > 10_000]
    assert len(pauses) >= 2
    assert (pauses == 1_000_000).all()


def test_a_file_is_played_from_a_place_and_then_from_another(path: Path) -> None:
    source = FileSource(open_recording(path, SENSOR), (50_000, 350_000), 100.0)
    with open_recording(path, SENSOR) as file:
        for begin_s in (0.25, 0.0, 0.1234):
            source.begin_s = begin_s
            got = Events.joined(arrival.events for arrival in source.arrivals(lambda: True))
            wanted = Events.joined(file.blocks(50_000 + round(begin_s * 1e6), 350_000))
            assert np.array_equal(got.t_us, wanted.t_us), "the recording's own times"
            assert source.place_s == pytest.approx((got.t_us[-1] - 5_050_000) / 1e6)
    source.begin_s = 0.35
    assert list(source.arrivals(lambda: True)) == [], "beyond the end there is nothing, which is no error"
    source.close()


def test_the_place_in_a_loop_is_that_in_the_file(path: Path) -> None:
    source = FileSource(open_recording(path, SENSOR), (0, 50_000), 4.0, loop=True)
    source.begin_s = 0.03
    places_s: list[float] = []
    t_us: list[int] = []
    for arrival in source.arrivals(lambda: True):
        places_s.append(source.place_s)
        t_us += arrival.events.t_us.tolist()
        if len(t_us) > 1_100:
            break
    source.close()
    assert places_s[0] >= 0.03
    assert max(places_s) < 0.05
    assert np.count_nonzero(np.diff(places_s) < 0) >= 2
    steps = np.diff(t_us)
    assert (steps >= 0).all()
    assert (steps[steps > 10_000] == 1_000_000).all(), "a pause, after which the window begins"


@pytest.mark.parametrize("speed", [1.0, 0.5])
def test_a_file_is_played_at_its_speed(path: Path, speed: float) -> None:
    source = FileSource(open_recording(path, SENSOR), (100_000, 300_000), speed)
    got, late_s, begin_s = [], [], time.perf_counter()
    for arrival in source.arrivals(lambda: True):
        now_s = time.perf_counter()
        last_s = (arrival.events.t_us[-1] - 5_100_000) / 1e6 / speed
        assert now_s - begin_s >= last_s, "given before it happened"
        assert arrival.events.t_us[-1] - arrival.events.t_us[0] < 5_000 * speed
        got.append(arrival.events)
        late_s.append(now_s - arrival.arrived_s)
    took_s = time.perf_counter() - begin_s
    source.close()
    with open_recording(path, SENSOR) as file:
        wanted = Events.joined(file.blocks(100_000, 300_000))
    assert np.array_equal(Events.joined(got).t_us, wanted.t_us)
    assert took_s * speed == pytest.approx(0.2 + source.slipped_s * speed, abs=0.15)
    assert 0 < np.median(late_s) < 0.05


def test_a_file_ends_when_it_is_not_wanted_any_more(path: Path) -> None:
    source = FileSource(open_recording(path, SENSOR), speed=0.001)
    begin_s = time.perf_counter()
    assert len(list(source.arrivals(lambda: time.perf_counter() - begin_s < 0.3))) < 400
    assert time.perf_counter() - begin_s < 2
    source.close()


def test_a_file_that_cannot_keep_up_is_played_later(path: Path) -> None:
    source = FileSource(open_recording(path, SENSOR))
    count = 0
    for arrival in source.arrivals(lambda: True):
        if count == 0:
            time.sleep(0.5)
        count += len(arrival.events)
    assert count == 4_000
    assert source.slipped_s == pytest.approx(0.5, abs=0.2)
    source.close()


def test_what_breaks_the_rules_is_left_out_of_a_stream_and_counted() -> None:
    packets = [events(10, 20), events(15, 30), events(40, x=64), events(50)]
    source = StreamSource("camera", lambda _: packets, SENSOR, lambda: None)
    got = [arrival.events.t_us.tolist() for arrival in source.arrivals(lambda: True)]
    assert got == [[10, 20], [30], [50]]
    assert source.left_out == {"time runs back": 1, "outside the sensor, or without a polarity": 1}


def test_a_sender_that_starts_again_is_an_error() -> None:
    packets = [events(5_000_000), events(10, 20)]
    source = StreamSource("camera", lambda _: packets, SENSOR, lambda: None)
    message = "^camera: t = 20 us follows t = 5000000 us: must not run back by more than 1 s; has the sender started again"
    with pytest.raises(RecordingError, match=message):
        list(source.arrivals(lambda: True))


@pytest.mark.parametrize("address", ["", "host", "host:", ":80", "host:port", "host:0", "host:65536", "host:-1"])
def test_an_address_that_is_none(address: str) -> None:
    with pytest.raises(ConfigError, match=r"must be tcp://HOST:PORT, the port from 1 to 65535$"):
        NetworkSource(address)


def test_nobody_listens() -> None:
    with pytest.raises(RecordingError, match=r"^tcp://127\.0\.0\.1:9: cannot be reached: Connection refused$"):
        NetworkSource("127.0.0.1:9")


class FakeCapture:
    """What dv-processing gives for a camera."""

    def __init__(self, batches: Iterable[object]) -> None:
        self._batches = iter(batches)
        self._running = True

    def getEventResolution(self) -> tuple[int, int]:
        return SENSOR

    def getCameraName(self) -> str:
        return "DVXplorer_X"

    def isRunning(self) -> bool:
        return self._running

    def getNextEventBatch(self) -> object:
        try:
            return next(self._batches)
        except StopIteration:
            self._running = False
            return None


def fake_dv(monkeypatch: pytest.MonkeyPatch, serials: list[str], batches: Iterable[object] = ()) -> None:
    module = ModuleType("dv_processing")
    found = [SimpleNamespace(serialNumber=serial) for serial in serials]
    camera = SimpleNamespace(discover=lambda: found, open=lambda _serial: FakeCapture(batches))
    module.io = SimpleNamespace(camera=camera)  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "dv_processing", module)


class Batch:
    def __init__(self, some: Events) -> None:
        self._some = some

    def __len__(self) -> int:
        return len(self._some)

    def numpy(self) -> object:
        dtype = [("timestamp", "<i8"), ("x", "<i2"), ("y", "<i2"), ("polarity", "i1")]
        rows = np.empty(len(self), dtype)
        for name, field in (("timestamp", "t_us"), ("x", "x"), ("y", "y"), ("polarity", "p")):
            rows[name] = getattr(self._some, field)
        return rows


def test_a_camera(monkeypatch: pytest.MonkeyPatch) -> None:
    some = random_events(100, 1)
    fake_dv(monkeypatch, ["A", "B"], [None, Batch(some[:60]), Batch(some[:0]), Batch(some[60:])])
    source = CameraSource("B")
    assert (source.name, source.sensor) == ("DVXplorer_X", SENSOR)
    got = Events.joined(arrival.events for arrival in source.arrivals(lambda: True))
    for name in ("t_us", "x", "y", "p"):
        assert np.array_equal(getattr(got, name), getattr(some, name))
        assert getattr(got, name).dtype == getattr(some, name).dtype


def test_no_camera_and_no_library_are_said(monkeypatch: pytest.MonkeyPatch) -> None:
    fake_dv(monkeypatch, [])
    with pytest.raises(RecordingError, match=r"^camera: none is connected"):
        CameraSource()
    fake_dv(monkeypatch, ["A", "B"])
    with pytest.raises(RecordingError, match=r"^camera:C: is not connected: must be one of A, B$"):
        CameraSource("C")
    monkeypatch.setitem(sys.modules, "dv_processing", None)
    with pytest.raises(ConfigError, match=r"^camera: dv-processing must be installed: pip install 'evcot\[camera\]'$"):
        CameraSource()

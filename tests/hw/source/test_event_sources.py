# SPDX-License-Identifier: Apache-2.0
"""Every source of evcot_top, one selected at a time, gives the trackers the events that the software decoders give."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from evcot.events import Events
from evcot.hardware.config import CotConfig
from evcot.hardware.cot import CotModel
from evcot.hardware.lfsr_event_source import LfsrEventSource
from evcot.hardware.register_access import Registers
from evcot.hardware.streams import unpack
from evcot.recordings.files import write_events
from evcot.recordings.formats.evt3 import evt3_layout
from evcot.ticks import TickedEvents
from evcot_cosim.devices.base import reset
from evcot_cosim.devices.top_device import Pace, TopDevice, address_of, configuration, poll, write
from evcot_cosim.rtl.build import load
from support.evt import axis_beats, corrupted, decode, evt2_words, payload, random_events
from support.top import BUILDS, EVERY, device_of

EVENTS, LFSR, AER, EVT2, EVT21, EVT3 = range(6)
SENSOR = BUILDS["sources"].filter_shape
CONTROL = address_of("control")
CONFIG = CotConfig.uniform(BUILDS["sources"].shape, EVERY)


def selected(source: int, pace: Pace | None = None, **settings: int) -> TopDevice:
    """A device that takes events from a source, all its registers written."""
    device = device_of("sources", CONFIG, pace=pace)
    registers = Registers(device)
    registers.source.select = source
    for name, value in settings.items():
        setattr(registers.source, name, value)
    registers.control.soft_reset = 1
    device.configure(CONFIG)
    return device


def evt3_words(events: Events, folder: Path) -> np.ndarray:
    write_events(folder / "a.raw", (SENSOR.width, SENSOR.height), [events], "evt3", force=True)  # type: ignore[arg-type]
    return payload(folder / "a.raw", np.uint16)


def turned(words: np.ndarray, source: int) -> np.ndarray:
    """The high byte of each word first, and of EVT 2.1 the upper half first."""
    units = words.view(np.uint16 if source == EVT3 else np.uint32).byteswap()
    return (units.reshape(-1, 2)[:, ::-1].ravel() if source == EVT21 else units).view(words.dtype)


@pytest.mark.parametrize("source", [EVT2, EVT21, EVT3])
def test_words_of_a_camera_give_the_log_of_its_events(source: int, tmp_path: Path) -> None:
    for seed in range(2):
        rng = np.random.default_rng([source, seed])
        events = random_events(rng, 3_000, SENSOR.width, SENSOR.height, 100_000)
        words = evt3_words(events, tmp_path) if source == EVT3 else evt2_words(events, source == EVT21)
        beats = axis_beats(turned(words, source) if seed else words, 64)
        device = selected(source, Pace.random(rng) if seed else None, swap_bytes=seed, swap_halves=seed)
        result = device.run(beats[:, 0].copy(), keeps=beats[:, 1].astype(np.uint8), most=len(events))
        golden = CotModel(CONFIG).feed(TickedEvents.of(events))
        found = result.decisions(0, len(events))
        for field in golden._fields:
            assert np.array_equal(getattr(found, field), getattr(golden, field)), field
        assert len(golden.records) > 40
        assert Registers(device).counters()["malformed"] == 0


def test_nothing_is_taken_before_the_reset_is_over() -> None:
    """The camera is there first: its beats wait from the first clock on, a time mark among them."""
    device = device_of("sources")  # EVT 2.0 after reset
    rng = np.random.default_rng(9)
    events = random_events(rng, 10, SENSOR.width, SENSOR.height, 100)
    words = evt2_words(events, vectors=False)
    beats = axis_beats(words, 64)
    device.run(beats[:, 0].copy(), keeps=beats[:, 1].astype(np.uint8))
    counters = Registers(device).counters()
    assert (counters["events_in"], counters["malformed"]) == (len(events), 0)


def test_what_the_lfsr_gives_beyond_the_sensor_is_left_out_and_counted() -> None:
    device = device_of("sources")
    registers = Registers(device)
    registers.source.select = LFSR
    registers.lfsr_seed, registers.lfsr_gap = 0xC0FFEE, 20
    registers.lfsr_x.min, registers.lfsr_x.span = 190, 40
    registers.lfsr_y.min, registers.lfsr_y.span = 100, 100
    registers.control.soft_reset = 1
    found = unpack("passed", device.run(commands=[write(CONTROL, 1)], clocks=100_000, most=10_000).passed)
    source = LfsrEventSource(x_w=8, y_w=8, seed=0xC0FFEE, gap=20, x_min=190, x_span=40, y_min=100, y_span=100)
    events = source.events(5_000)
    inside = np.flatnonzero((events.x < SENSOR.width) & (events.y < SENSOR.height))[: len(found)]
    assert len(found) > 200
    for axis in ("x", "y", "p"):
        assert np.array_equal(found[axis], getattr(events, axis)[inside])
    assert registers.counters()["malformed"] >= inside[-1] + 1 - len(found) > 1_000


@pytest.mark.parametrize("gap", [0, 1, 5])
def test_time_of_the_lfsr_begins_with_its_first_event(gap: int) -> None:
    sim = load("event_sources", {"SOURCES": 1 << EVENTS | 1 << LFSR})
    io = sim.io
    io.select, io.lfsr_seed, io.lfsr_gap, io.lfsr_x_span, io.lfsr_y_span = LFSR, 0xC0FFEE, gap, 60, 60
    io.tick_us, io.m_ready = 1, 1
    reset(sim)
    ticks = []
    for _ in range(200):
        sim.clock.tick()
        if io.m_valid and io.m_event:
            ticks.append(int(io.m_tick))
    source = LfsrEventSource(x_w=9, y_w=9, seed=0xC0FFEE, gap=gap, x_min=0, x_span=60, y_min=0, y_span=60)
    t_us = source.events(len(ticks)).t_us
    assert ticks == np.diff(t_us, prepend=t_us[:1]).tolist()
    assert (len(ticks) > 20, int(io.n_backward)) == (True, 0)


def test_damaged_words_are_skipped_and_counted(tmp_path: Path) -> None:
    rng = np.random.default_rng(6)
    events = random_events(rng, 3_000, SENSOR.width, SENSOR.height, 100_000)
    words = corrupted(evt3_words(events, tmp_path), rng, 0.02)
    decoded = decode(evt3_layout(0), words, SENSOR.width, SENSOR.height)
    beats = axis_beats(words, 64)
    device = selected(EVT3)
    device.run(beats[:, 0].copy(), keeps=beats[:, 1].astype(np.uint8), most=40 * len(events))
    counters = Registers(device).counters()
    assert counters["events_in"] == len(decoded.events)
    assert counters["malformed"] == sum(count for name, count in decoded.counters.items() if name != "n_events") > 10


def test_a_word_of_which_a_part_is_missing_is_skipped_and_counted() -> None:
    device = selected(EVT21)
    device.run(np.zeros(3, np.uint64), keeps=np.array([0xFF, 0x7F, 0xFE], np.uint8), quiet_clocks=50)
    assert Registers(device).counters()["malformed"] == 2


def test_after_reset_the_source_is_the_one_of_the_parameter() -> None:
    device = device_of("sources", CONFIG)
    device.configure(CONFIG)
    events = random_events(np.random.default_rng(1), 300, SENSOR.width, SENSOR.height, 1_000)
    beats = axis_beats(evt2_words(events, False), 64)
    result = device.run(beats[:, 0].copy(), keeps=beats[:, 1].astype(np.uint8), most=len(events))
    assert len(result.owned) + len(result.passed) == len(events)


def test_what_is_not_selected_takes_nothing() -> None:
    device = device_of("sources", CONFIG)
    registers = Registers(device)
    registers.source.select = LFSR
    registers.control.soft_reset = 1
    device.sim.io.s_axis_tvalid = 1
    for _ in range(20):
        device.sim.clock.tick()
        assert device.sim.io.s_axis_tready == 0


@pytest.mark.parametrize("active_low", [0, 1])
def test_events_of_an_aer_chip_come_through(active_low: int) -> None:
    device = device_of("sources", CONFIG)
    registers = Registers(device)
    registers.source.select = AER
    registers.source.active_low = active_low
    registers.prescale.us = 4
    device.sim.io.aer_req = active_low
    registers.control.soft_reset = 1
    device.run(commands=[*configuration(CONFIG), poll(address_of("status"), 2, 0), write(address_of("control"), 1)])
    io = device.sim.io
    io.m_axis_records_tready = io.m_axis_owned_tready = io.m_axis_passed_tready = 1
    rng = np.random.default_rng(3)
    sent = [(int(rng.integers(200)), int(rng.integers(150)), int(rng.integers(2))) for _ in range(40)]
    numbers: list[int] = []

    def clock() -> None:
        for stream in ("owned", "passed"):
            if io[f"m_axis_{stream}_tvalid"]:
                found = unpack(stream, np.array([int(io[f"m_axis_{stream}_tdata"])], np.uint64))[0]
                numbers.append(int(found["seq"]))
                if stream == "passed":
                    assert (int(found["x"]), int(found["y"]), int(found["p"])) == sent[numbers[-1]]
        device.sim.clock.tick()

    for x, y, p in sent:
        io.aer_data = (y << 8 | x) << 1 | p
        for wanted in (1, 0):
            io.aer_req = wanted ^ active_low
            clocks = 0
            while io.aer_ack != wanted ^ active_low:
                clock()
                clocks += 1
                assert clocks < 60
    for _ in range(60):
        clock()
    assert sorted(numbers) == list(range(40))
    io.m_axis_records_tready = io.m_axis_owned_tready = io.m_axis_passed_tready = 0
    assert registers.counters()["events_in"] == 40


def test_ticks_may_come_from_the_clock() -> None:
    device = device_of("sources", CONFIG)
    registers = Registers(device)
    registers.source.select = EVENTS
    registers.source.clock_time = 1
    registers.prescale.tick = 50
    registers.control.soft_reset = 1
    device.run(commands=[*configuration(CONFIG), poll(address_of("status"), 2, 0), write(address_of("control"), 1)])
    words = np.full(3, 20 << 32 | 20 << 47, np.uint64)  # all at time 0
    records = np.concatenate([device.run(words[i : i + 1], quiet_clocks=1_000).records for i in range(3)])
    assert np.abs(np.diff(records["time"].astype(np.int64)) - 20).max() <= 1  # 1,000 clocks and a few


@pytest.mark.parametrize("sources", [1 << EVENTS, 1 << EVENTS | 1 << LFSR])
def test_idle_when_every_event_has_left_with_its_ticks(sources: int) -> None:
    sim = load("event_sources", {"SOURCES": sources})
    io = sim.io
    io.tick_us, io.m_ready, io.s_axis_tkeep = 10, 1, 0xFF
    reset(sim)
    sim.clock.tick()
    assert io.idle == 1
    for t_us in (5, 1_000):  # the second time is divided by that of a tick
        io.s_axis_tvalid, io.s_axis_tdata = 1, t_us
        sim.clock.tick()
        io.s_axis_tvalid = 0
        waits = 0
        while not (io.m_valid and io.m_event):
            assert (io.idle, waits < 99) == (0, True)
            sim.clock.tick()
            waits += 1
        sim.clock.tick()
        assert io.idle == 1


def test_a_column_before_any_row_counts_as_malformed() -> None:
    sim = load("event_sources", {"SOURCES": 1 << AER})
    io = sim.io
    io.select, io.word_serial, io.aer_req, io.aer_rst = AER, 1, 1, 1
    reset(sim)
    io.aer_rst = 0
    for _ in range(8):
        sim.clock.tick()
    assert (io.aer_ack, io.n_malformed) == (1, 1)

# SPDX-License-Identifier: Apache-2.0
"""The streaming drives, rows of ports clock by clock, and the limit on gaps between events."""

from __future__ import annotations

import ctypes
import re
from dataclasses import replace
from pathlib import Path
from subprocess import run
from sys import executable

import numpy as np
import pytest

from evcot.errors import ConfigError, RecordingError
from evcot.events import Events, Recording
from evcot.hardware.config import CotConfig, SlotConfig
from evcot.hardware.contract import RECORD, Shape
from evcot.recordings.files import write_recording
from evcot.ticks import TickedEvents
from evcot.trackers.config import RunConfig
from evcot_cosim.devices.base import (
    SILENT_CLOCKS_MAX,
    Ending,
    HardwareError,
    Stalls,
    check_silence,
    check_waits,
    pattern_fields,
    pointer,
    structure,
)
from evcot_cosim.devices.device import Device
from evcot_cosim.devices.driver import DRIVE, PARAMETERS, Status, source
from evcot_cosim.devices.filter_device import FilterDevice
from evcot_cosim.devices.published_device import Top, rtl, simulation
from evcot_cosim.lockstep.cosim import run_cosim
from evcot_cosim.lockstep.lockstep import Lockstep

TOPS = ["cot", "cot_chain", "cot_array"]
SIZES = {"int64_t": 8, "uint64_t": 8, "uint32_t": 4, "uint16_t": 2, "uint8_t": 1}


def struct(text: str, name: str) -> list[tuple[str, str]]:
    """(type, field) of a C struct in the text."""
    body = re.search(rf"struct {name} {{\n(.*?)\n}};", text, re.DOTALL)
    assert body is not None
    return [(ctype, name) for ctype, name in (line.strip().rstrip(";").rsplit(" ", 1) for line in body[1].splitlines())]


@pytest.mark.parametrize("top", TOPS)
def test_a_record_is_laid_out_as_numpy_has_it(top: str) -> None:
    fields = struct(source(top, Shape(n_slots=1)), "Record")
    assert [name for _, name in fields] == list(RECORD.names or ())
    offset = 0
    for ctype, name in fields:
        dtype, at = RECORD.fields[name][:2]  # type: ignore[index]
        assert (offset, SIZES[ctype]) == (at, dtype.itemsize)
        offset += SIZES[ctype]
    assert offset == RECORD.itemsize


def test_a_job_is_laid_out_as_ctypes_has_it() -> None:
    fields = struct(source("cot_array", Shape()), "Job")
    assert [name for _, name in fields] == [field[0] for field in DRIVE.job._fields_]
    assert all(ctype.endswith("*") or SIZES[ctype] == 8 for ctype, _ in fields)


def test_statuses_have_the_numbers_that_python_knows() -> None:
    listed = re.search(r"enum Status { (.*?), }", source("cot", Shape(n_slots=1)))
    assert listed is not None
    assert dict(entry.split(" = ") for entry in listed[1].split(", ")) == {s.name: str(s.value) for s in Status}


def test_widths_become_constants() -> None:
    text = source("cot_array", Shape(tick_w=3, seq_w=9, time_w=34))
    assert "kTickMax = 7;" in text
    assert "kSeqMask = 511ull;" in text
    assert f"kTimeMask = {2**34 - 1}ull;" in text


def test_only_ports_that_the_top_has_are_used() -> None:
    cot, array = source("cot", Shape(n_slots=1)), source("cot_array", Shape())
    assert "io->s_seq" in cot
    assert "io->m_cm_slot" not in cot
    assert "io->s_seq" not in array
    assert "io->m_cm_slot" in array


def test_every_field_of_a_shape_is_a_parameter() -> None:
    assert set(PARAMETERS) == set(Shape.__dataclass_fields__)


class Some(Ending):
    """Two ways to end well, and one fault."""

    DONE = ""
    AGAIN = ""
    LOST = "lost event"


def test_endings_are_numbered_in_order_and_carry_what_a_fault_means() -> None:
    assert [(ending.name, ending.value, ending.fault) for ending in Some] == [
        ("DONE", 0, ""), ("AGAIN", 1, ""), ("LOST", 2, "lost event"),
    ]  # fmt: skip
    assert Some(2) is Some.LOST


def test_a_structure_has_its_fields_in_order_and_in_words_of_64_bits() -> None:
    shared = structure({"n": "int64_t", "x": "const uint16_t*", "seed": "uint64_t"})
    assert shared._fields_ == [("n", ctypes.c_int64), ("x", ctypes.c_void_p), ("seed", ctypes.c_uint64)]
    assert ctypes.sizeof(shared) == 24


def test_a_pattern_is_a_pointer_and_a_length() -> None:
    assert pattern_fields("in", "out") == {
        "in_pattern": "const uint8_t*", "in_length": "int64_t", "out_pattern": "const uint8_t*", "out_length": "int64_t",
    }  # fmt: skip


def test_pointer_is_the_address_of_the_data() -> None:
    array = np.arange(4, dtype=np.int64)
    assert pointer(array[2:]) == array.ctypes.data + 16
    assert pointer(None) is None


def test_a_pattern_that_never_goes_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"^stalls\.own: never goes: a pattern must hold at least one 1$"):
        Stalls(own=np.zeros(3, np.uint8))


def test_an_error_of_the_hardware_names_the_event() -> None:
    error = HardwareError("cot lost event 7", 7)
    assert (str(error), error.seq) == ("cot lost event 7", 7)
    assert isinstance(error, RuntimeError)


ROW = np.dtype([("rst", "u1"), ("d", "u1")])
OUT = np.dtype([("q", "u1")])
FLIP_FLOP = Top("dff", (("RESET_TO_COMPLEMENT", 0),), ROW, OUT)
VALUES = np.array([1, 1, 0, 1, 0, 0, 1])


def rows(values: np.ndarray, rst: int = 0) -> np.ndarray:  # type: ignore[type-arg]
    given = np.zeros(len(values), ROW)
    given["rst"], given["d"] = rst, values
    return given


def test_outputs_are_those_before_the_edge_and_a_simulation_goes_on() -> None:
    rtl(FLIP_FLOP, rows(VALUES[:1], rst=1))
    parts = [rtl(FLIP_FLOP, rows(part))["q"] for part in (VALUES[:3], VALUES[3:3], VALUES[3:])]
    assert np.concatenate(parts).tolist() == [0, *VALUES[:-1]]


def test_a_port_that_is_not_valid_is_read_as_zero() -> None:
    never = replace(FLIP_FLOP, valid_with=(("q", "q"),))  # valid only while it is 0
    assert not rtl(never, rows(VALUES))["q"].any()


def test_one_simulation_does_not_touch_another() -> None:
    other = simulation.__wrapped__(FLIP_FLOP)
    rtl(FLIP_FLOP, rows(np.array([0, 0])))
    rtl(FLIP_FLOP, rows(np.array([1])), other)
    assert rtl(FLIP_FLOP, rows(np.array([0])))["q"].tolist() == [0]
    assert rtl(FLIP_FLOP, rows(np.array([0])), other)["q"].tolist() == [1]


NOW_US = 1_700_000_000_000_000  # microseconds since 1970


def events_at(*t_us: int) -> Events:
    n = len(t_us)
    return Events(np.array(t_us, np.int64), np.full(n, 5, np.uint16), np.full(n, 5, np.uint16), np.ones(n, np.uint8))


def config_of(**shape: int) -> CotConfig:
    return CotConfig.uniform(Shape(n_slots=1, **shape), SlotConfig(), module="cot")


def test_the_longest_gap_is_named_with_its_place_and_the_way_out() -> None:
    config = config_of()
    with pytest.raises(RecordingError) as caught:
        check_silence(np.array([3, 4, 4 + (1 << 44) // 1000, NOW_US, NOW_US + 5]), config)
    assert str(caught.value).startswith("event 3: t = 1700000000000000 us follows t = 17592186048 us: a gap of 1.69998e+09 s")
    assert str(caught.value).endswith("must be at most 16777216; take a part without it (--from, --to), or a longer tick_us")


@pytest.mark.parametrize("first", [0, 7])
def test_the_bound_is_exact_and_knows_the_event_before(first: int) -> None:
    config = config_of()
    most_us = (SILENT_CLOCKS_MAX + 1) * ((1 << config.shape.tick_w) - 1) - 1
    check_silence(np.array([most_us]), config, first, 0)
    check_silence(np.array([0, most_us]), config, first)
    check_silence(np.array([NOW_US]), config, first)
    for times, before, index in (([most_us + 1], 0, first), ([0, most_us + 1], None, first + 1)):
        with pytest.raises(RecordingError, match=f"^event {index}: "):
            check_silence(np.array(times), config, first, before)
        with pytest.raises(RecordingError, match=f"^event {index}: tick {most_us + 1} follows tick 0: "):
            check_waits(np.array(times), before or 0, (1 << config.shape.tick_w) - 1, first)


def test_no_drive_begins_a_gap_of_decades() -> None:
    """Each would go on for minutes: that the test ends shows that none begins."""
    events, config = events_at(0, 1, NOW_US), RunConfig(hardware=config_of())
    with pytest.raises(RecordingError, match=r"^story: event 2: t = 1700000000000000 us follows t = 1 us"):
        run_cosim(Recording(events, 64, 64, "story"), config)
    ticked = TickedEvents.of(events)
    for device in (Device(config.hardware), FilterDevice("filter_polarity", ports={"enable": 0})):
        with pytest.raises(RecordingError, match=r"^event 2: tick 1700000000000000 follows tick 1: "):
            device.stream(ticked)
        assert device.now == device.cycle == 0
    with Lockstep(config.hardware) as lockstep:
        lockstep.feed(events[:2])
        clocks = lockstep.device.cycle
        with pytest.raises(RecordingError, match=r"^event 2: t = "):
            lockstep.feed(events[2:])
        assert lockstep.device.cycle == clocks


def test_a_day_of_silence_is_driven() -> None:
    with Lockstep(config_of()) as lockstep:
        lockstep.feed(events_at(0, 1, 86_400_000_000))
        assert lockstep.device.now == 86_400_000_000
        assert lockstep.device.cycle > 82_000


def test_the_command_line_refuses_it_in_one_line(tmp_path: Path) -> None:
    path = tmp_path / "decades.npz"
    write_recording(Recording(events_at(0, NOW_US), 64, 64), path)
    command = [executable, "-m", "evcot_cosim", "cosim", str(path), "-o", str(tmp_path / "run")]
    done = run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode == 2
    assert len(done.stderr.strip().splitlines()) == 1, done.stderr
    assert "event 1: t = 1700000000000000 us follows t = 0 us" in done.stderr
    assert not (tmp_path / "run").exists()

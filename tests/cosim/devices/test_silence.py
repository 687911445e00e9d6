# SPDX-License-Identifier: Apache-2.0
"""A gap of decades in a recording: refused with its place before any hardware is driven; a long but possible one is driven."""

from __future__ import annotations

from pathlib import Path
from subprocess import run
from sys import executable

import numpy as np
import pytest

from evcot.errors import RecordingError
from evcot.events import Events, Recording
from evcot.hardware.config import CotConfig, SlotConfig
from evcot.hardware.contract import Shape
from evcot.recordings.files import write_recording
from evcot.ticks import TickedEvents
from evcot.trackers.config import RunConfig
from evcot_cosim.devices.device import Device
from evcot_cosim.devices.filter_device import FilterDevice
from evcot_cosim.devices.silence import SILENT_CLOCKS_MAX, check_silence, check_waits
from evcot_cosim.lockstep.cosim import run_cosim
from evcot_cosim.lockstep.lockstep import Lockstep

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

# SPDX-License-Identifier: Apache-2.0
"""Waveforms of chosen moments: the right events, clock for clock as in the run, and nothing that only looks whole."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.errors import ConfigError, OutputError
from evcot.events import Events
from evcot.hardware.config import CotConfig
from evcot.hardware.modules import Module
from evcot_cosim.devices.base import Stalls
from evcot_cosim.devices.device import Device, build_device
from evcot_cosim.waves import Samples, Wave
from evcot_cosim.waves.window import Window, write_waves


def at(*t_us: int) -> Events:
    """Events at these times."""
    n = len(t_us)
    return Events(np.array(t_us), np.zeros(n, np.uint16), np.zeros(n, np.uint16), np.zeros(n, np.uint8))


class TestWindow:
    @pytest.mark.parametrize(("event", "first", "last"), [(50, 40, 60), (3, 0, 13), (95, 85, 99), (99, 89, 99)])
    def test_around_an_event_ends_with_the_recording(self, event: int, first: int, last: int) -> None:
        assert Window.around(event, 100, 10) == Window(first, last)

    @pytest.mark.parametrize(
        ("from_us", "to_us", "first", "last"),
        [(0, 31, 0, 3), (0, 30, 0, 2), (10, 30, 1, 2), (11, 31, 3, 3), (0, 1, 0, 0), (0, 10**9, 0, 4)],
    )
    def test_of_time_begins_with_the_first_event_and_leaves_its_end_out(
        self, from_us: int, to_us: int, first: int, last: int
    ) -> None:
        assert Window.of_time(at(1_000, 1_010, 1_010, 1_030, 1_045), from_us, to_us) == Window(first, last)

    @pytest.mark.parametrize(("from_us", "to_us"), [(11, 30), (46, 100), (20, 20), (30, 10)])
    def test_of_time_refuses_a_time_without_events(self, from_us: int, to_us: int) -> None:
        with pytest.raises(ConfigError) as error:
            Window.of_time(at(1_000, 1_010, 1_030, 1_045), from_us, to_us)
        assert str(error.value) == f"waveform from {from_us} us to {to_us} us: no event there, the last is at 45 us"


WINDOW = Window(700, 760)


def entered(s: Samples) -> NDArray[np.int64]:
    """The addresses of the events that went in, x + 128 y."""
    taken = s["TOP.s_valid"] & s["TOP.s_ready"] & s["TOP.s_event"]
    return (s["TOP.s_x"].values + 128 * s["TOP.s_y"].values)[taken.true]


def addresses(events: Events, window: Window) -> Sequence[int]:
    shown = slice(window.first, window.last + 1)
    return (events.x[shown].astype(int) + 128 * events.y[shown].astype(int)).tolist()


@pytest.mark.parametrize("top", ["cot_array", "cot_chain"])
def test_shows_every_event_of_its_window(config: CotConfig, blobs: Events, top: Module, tmp_path: Path) -> None:
    vcd, view = write_waves(blobs, replace(config, module=top), tmp_path, WINDOW, name="moment")
    assert (vcd, view) == (tmp_path / "moment.vcd", tmp_path / "moment.gtkw")
    s = Wave.open(vcd).sampled("TOP.clk")
    shown, wanted = entered(s).tolist(), addresses(blobs, WINDOW)
    assert any(shown[i : i + len(wanted)] == wanted for i in range(len(shown) - len(wanted) + 1))
    assert len(shown) < len(wanted) + 30
    assert f"/{vcd.name}" in view.read_text()


def test_is_clock_for_clock_the_run_that_it_shows(
    config: CotConfig, blobs: Events, stalls: Stalls, vcds: dict[Module, Path], tmp_path: Path
) -> None:
    """The same stalls, the same clocks: every signal of the array, at every clock of the window, as in the whole run."""
    vcd, _ = write_waves(blobs, config, tmp_path, WINDOW, stalls=stalls)
    part, whole = (Wave.open(path).sampled("TOP.clk") for path in (vcd, vcds["cot_array"]))
    inside = np.isin(whole.times, part.times)
    assert np.count_nonzero(inside) == len(part) > len(addresses(blobs, WINDOW))
    for path in part.find("TOP.cot_array.*"):
        assert np.array_equal(part[path].values, whole[path].values[inside]), path


def test_decisions_are_those_of_a_run_that_is_not_dumped(config: CotConfig, blobs: Events, tmp_path: Path) -> None:
    dumped, plain = Device(config), Device(config)
    with dumped.dumping(tmp_path / "x.vcd", WINDOW.first, WINDOW.last):
        watched = dumped.stream(blobs)
    for theirs, ours in zip(watched, plain.stream(blobs), strict=True):
        assert np.array_equal(theirs, ours)
    assert dumped.cycle == plain.cycle


def test_a_model_without_waves_decides_the_same_and_shows_its_top(config: CotConfig, blobs: Events, tmp_path: Path) -> None:
    top = "cot_array"
    bare, whole = Device(config, model=build_device(config, waves=False)), Device(config)
    with bare.dumping(tmp_path / "x.vcd", 0, 99), whole.dumping(tmp_path / "y.vcd", 0, 99):
        for ours, theirs in zip(bare.stream(blobs[:500]), whole.stream(blobs[:500]), strict=True):
            assert np.array_equal(ours, theirs)
    shown, everything = (set(Wave.open(tmp_path / name).find("TOP.*")) for name in ("x.vcd", "y.vcd"))
    assert {"TOP.s_x", f"TOP.{top}.s_x"} <= shown < everything
    inside = re.compile(rf"TOP\.{top}\.u_\w+\.")
    assert any(inside.match(path) for path in everything)
    assert not any(inside.match(path) for path in shown)


def test_nothing_stays_behind_where_nothing_can_be_written(config: CotConfig, blobs: Events, tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"none/waves\.vcd: cannot be written: No such file or directory"):
        write_waves(blobs, config, tmp_path / "none", WINDOW)
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full, a disk that is always full")
def test_a_full_disk_leaves_no_waveform(
    config: CotConfig, blobs: Events, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    planted = tmp_path / "partial"
    planted.symlink_to("/dev/full")
    monkeypatch.setattr("evcot.outputs._beside", lambda _: planted)
    with pytest.raises(OutputError, match=r"waves\.vcd: cannot be written: No space left on device"):
        write_waves(blobs, config, tmp_path, WINDOW)
    assert not list(tmp_path.iterdir())

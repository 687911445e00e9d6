# SPDX-License-Identifier: Apache-2.0
"""Waveforms of chosen moments, by hand, and as FST: the right events, clock for clock as in the run; and their guide."""

from __future__ import annotations

import errno
import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from evcot.errors import ConfigError, OutputError
from evcot.events import Events
from evcot.hardware.config import CotConfig
from evcot.hardware.modules import Module
from evcot_cosim.devices.base import Stalls, reset
from evcot_cosim.devices.device import Device, build_device
from evcot_cosim.rtl.build import load
from evcot_cosim.waves import Samples, Wave, WaveformError, after, always, recorded
from evcot_cosim.waves import __all__ as waveform_names
from evcot_cosim.waves.fst import fst_writer, write_fst
from evcot_cosim.waves.window import Window, write_waves
from support.full_disk import full_disk


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


def test_a_recorded_input_is_seen_before_the_edge_that_takes_it(tmp_path: Path) -> None:
    """pyverilator's own dumps would show a seed together with the state that it has become."""
    sim = load("lfsr", {"WIDTH": 8})
    reset(sim)
    with recorded(sim, tmp_path / "seed.vcd") as path:
        sim.io.load = 1
        for seed in (1, 2, 3):
            sim.io.seed = seed
            sim.clock.tick()
        sim.io.load = 0
        sim.clock.tick()
    s = Wave.open(path).sampled("TOP.clk")
    assert s["TOP.seed"].values.tolist() == [1, 2, 3, 3]
    assert s["TOP.state"].values.tolist() == [0, 1, 2, 3]
    assert always(s["TOP.state"] == s["TOP.seed"].previous(), where=s["TOP.load"].previous()) == 3
    assert list(tmp_path.iterdir()) == [path]


GUIDE = Path(__file__).parents[3] / "docs" / "waveforms.md"


def test_the_examples_of_the_guide_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, vcd_text: Callable[..., str]) -> None:
    monkeypatch.chdir(tmp_path)
    signals = {
        "rst": "1000000000", "req": "0010010000", "ack": "0001001000", "state": [0, 1, 2, 4, 1, 2, 5, 1, 1, 1],
        "count": [0, 1, 2, 3, 4, 5, 6, 7, 8, 12], "s_valid": "0111001100", "s_ready": "1001110100",
        "s_x": [0, 7, 7, 7, 1, 2, 3, 3, 4, 5],
    }  # fmt: skip
    Path("run.vcd").write_text(vcd_text(signals))
    names: dict[str, object] = {}
    examples = re.findall(r"```python\n(.*?)```", GUIDE.read_text(), re.DOTALL)
    assert len(examples) == 4
    for example in examples:
        exec(compile(example, str(GUIDE), "exec"), names)
    used = "\n".join(examples)
    for name in waveform_names:
        assert name in used or name[0].isupper(), f"{name} has no example"


def test_the_failure_that_the_guide_shows_is_what_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, vcd_text: Callable[..., str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("run.vcd").write_text(vcd_text({"req": "0010010000", "ack": "0001000000"}))
    s = Wave.open("run.vcd").sampled("clk")
    with pytest.raises(WaveformError) as error:
        after(s["req"].rose).within(3).expect(s["ack"])
    assert f"```text\n{error.value}\n```" in GUIDE.read_text()


needs_fst = pytest.mark.skipif(fst_writer() is None, reason="needs pylibfst")


@needs_fst
@pytest.mark.skipif(shutil.which("fst2vcd") is None, reason="needs fst2vcd, of GTKWave")
def test_an_fst_says_what_the_vcd_says(vcds: dict[Module, Path], tmp_path: Path) -> None:
    vcd = vcds["cot_array"]
    write_fst(vcd, tmp_path / "x.fst")
    assert (tmp_path / "x.fst").stat().st_size < vcd.stat().st_size / 4
    subprocess.run(["fst2vcd", "-f", "x.fst", "-o", "back.vcd"], cwd=tmp_path, check=True, capture_output=True)
    before, after = Wave.open(vcd), Wave.open(tmp_path / "back.vcd")
    assert before.timescale == after.timescale
    names = {entry.path: entry.width for entry in before.signals}
    assert names == {entry.path: entry.width for entry in after.signals}
    s, t = before.sampled("TOP.clk"), after.sampled("TOP.clk")
    assert np.array_equal(s.times, t.times)
    for path in names:
        assert np.array_equal(s[path].values, t[path].values), path


@needs_fst
def test_an_fst_says_why_its_file_cannot_be_created(
    vcds: dict[Module, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The library opens six files and allocates memory, and says only whether that worked."""
    few = "import resource, runpy, sys; resource.setrlimit(resource.RLIMIT_NOFILE, (7, 7)); "
    run = "sys.argv = sys.argv[1:]; runpy.run_path(sys.argv[0], run_name='__main__')"
    python = tmp_path / "python"
    python.write_text(f'#!/bin/sh\nshift\nexec {shlex.quote(sys.executable)} -c {shlex.quote(few + run)} "$@"\n')
    python.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(python))
    with pytest.raises(OutputError, match=rf"x\.fst: cannot be written: {os.strerror(errno.EMFILE)} \(an FST needs"):
        write_fst(vcds["cot_array"], tmp_path / "x.fst")
    assert list(tmp_path.iterdir()) == [python]


@needs_fst
@pytest.mark.parametrize("room", [0, 300, 4_096, 8_192, -2_000, -100, -1])
def test_an_fst_that_is_cut_off_is_refused(vcds: dict[Module, Path], room: int, tmp_path: Path) -> None:
    """The library ignores that the disk is full: here, that a file may have so many bytes and no more."""
    write_fst(vcds["cot_array"], tmp_path / "whole.fst")
    room += (tmp_path / "whole.fst").stat().st_size if room < 0 else 0
    message = r"x\.fst: cannot be written: (is cut off after \d+ bytes|pylibfst was ended by)"
    with full_disk(room), pytest.raises(OutputError, match=message):
        write_fst(vcds["cot_array"], tmp_path / "x.fst")
    assert [path.name for path in tmp_path.iterdir()] == ["whole.fst"]


@needs_fst
def test_an_fst_in_a_folder_that_is_not_there(vcds: dict[Module, Path], tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"none/x\.fst: cannot be written"):
        write_fst(vcds["cot_array"], tmp_path / "none" / "x.fst")

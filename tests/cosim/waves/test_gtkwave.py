# SPDX-License-Identifier: Apache-2.0
"""GTKWave views: they name what is in the waveform and nothing else, and every value by the name that the contract gives it."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from evcot.events import Events
from evcot.filters.contract import Filter
from evcot.filters.registers import FilterRegisters
from evcot.hardware.config import CotConfig, MotionConfig
from evcot.hardware.contract import Mode, Shape, State
from evcot.hardware.modules import Module
from evcot.hardware.motion import _state
from evcot.hardware.motion.contract import SUB
from evcot.hardware.motion.model import MotionModel
from evcot.tracks.log import Kind
from evcot_cosim.devices.device import Device
from evcot_cosim.lockstep.random_runs import random_outlines
from evcot_cosim.waves import Wave
from evcot_cosim.waves.gtkwave import write_view
from evcot_cosim.waves.views import VIEWS, WITH_MOTION
from support.tokens import ticked

TURNS = ["RUN", "BEGUN", "BUSY", "DUE"]
PHASES = ["RUN", "WALK", "FETCH", "REPORT", "CLEAR", "SETTLE", "JOIN"]
CODES = {
    "phase.txt": dict(enumerate(PHASES)),
    "turn.txt": dict(enumerate(TURNS)),
    **{f"{enum.__name__.lower()}.txt": {int(member): member.name for member in enum} for enum in (Kind, Mode, State)},
}

# Flags of a trace, bit by bit.
DECIMAL, SIGNED, TRANSLATED, CURVE, STRETCH = 1 << 2, 1 << 10, 1 << 13, 1 << 15, 1 << 17
CLOSED, GROUP_BEGIN, GROUP_END, FIXED_POINT = 1 << 22, 1 << 23, 1 << 24, 1 << 30


class View:
    """What a save file says, read the way GTKWave reads it.

    Attributes:
        shown: group -> the (label, trace, flags, file of names) of its rows.
        settings: what stands in brackets before the first group.
        closed: the groups that begin closed.
    """

    def __init__(self, path: Path) -> None:
        self.shown: dict[str, list[tuple[str, str, int, str]]] = {}
        self.settings: dict[str, str] = {}
        self.closed: set[str] = set()
        group, flags, names = "", 0, ""
        for line in path.read_text().splitlines():
            if line.startswith("@"):
                flags, names = int(line[1:], 16), ""
            elif line.startswith("^"):
                names = line.partition(" ")[2]
            elif line.startswith("-") and flags & GROUP_BEGIN:
                group = line[1:]
                assert group not in self.shown
                self.shown[group] = []
                if flags & CLOSED:
                    self.closed.add(group)
            elif line.startswith("-") and flags & GROUP_END:
                assert line[1:] == group
                group = ""
            elif match := re.fullmatch(r"[+#]\{(.*?)\} (.*)", line):
                assert group
                self.shown[group].append((match[1], match[2], flags, names))
            elif (match := re.fullmatch(r"\[(\w+)\] (.*)", line)) and match[1] not in ("color", "fpshift_count"):
                self.settings[match[1]] = match[2].strip('"')

    def rows(self) -> Iterator[tuple[str, str, str, int, str]]:
        for group, rows in self.shown.items():
            for row in rows:
                yield group, *row

    def row(self, group: str, label: str) -> tuple[str, int, str]:
        return next((trace, flags, names) for name, trace, flags, names in self.shown[group] if name == label)


@pytest.fixture
def folder(vcds: dict[Module, Path], tmp_path: Path) -> Path:
    """A run's folder with the waveform and the view of each arrangement."""
    folder = tmp_path / "run"
    folder.mkdir()
    for top, vcd in vcds.items():
        shutil.copy(vcd, folder)
        write_view(folder / vcd.name, folder / f"{top}.gtkw")
    return folder


@pytest.mark.parametrize("top", ["cot_array", "cot_chain"])
def test_a_view_names_only_signals_that_the_waveform_has(folder: Path, top: str) -> None:
    references = {entry.reference for entry in Wave.open(folder / f"{top}.vcd", ["*clk"]).signals}
    traces = [bit for _, _, trace, _, _ in View(folder / f"{top}.gtkw").rows() for bit in trace.split()]
    assert len(traces) > 100
    assert {re.sub(r"^\(\d+\)", "", trace) for trace in traces} <= references


def test_everything_in_the_table_exists_in_the_hardware(folder: Path) -> None:
    """A signal that has been renamed in the RTL would silently leave the view; the tables are for whole modules."""
    for top in ("cot_array", "cot_chain"):
        view = View(folder / f"{top}.gtkw")
        for group in VIEWS[top]:
            shown = {label for label, *_ in view.shown[group.title.replace("{slot}", "2")]}
            wanted = {row.label or row.signal.rpartition(".")[2] for row in group.rows}
            assert wanted - shown <= {"m_pass_tick", "m_pass_event"}, group.title  # only a tracker passes those on


@pytest.mark.parametrize("top", ["cot_array", "cot_chain"])
def test_trackers_behind_filters_are_shown_as_on_their_own(top: Module, config: CotConfig, folder: Path) -> None:
    alone = View(folder / f"{top}.gtkw")
    device = Device(replace(config, filters=FilterRegisters(enable=1 << Filter.POLARITY), module=top))
    with device.dumping(folder / "filtered.vcd"):
        device.stream(ticked(1, 60, 60))
    write_view(folder / "filtered.vcd", folder / "filtered.gtkw")
    behind = View(folder / "filtered.gtkw")
    assert "is_event" in {label for label, *_ in behind.shown.pop("behind the filters")}
    rows = {group: [row[0] for row in rows] for group, rows in behind.shown.items()}
    assert rows == {group: [row[0] for row in rows] for group, rows in alone.shown.items() if group != "registers"}


@pytest.fixture(scope="module", params=[0, 1 << Filter.POLARITY], ids=["alone", "behind filters"])
def moving(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The waveform and view of cot_motion, on an object in the corner, whose first box reaches beyond it."""
    folder = tmp_path_factory.mktemp("moving")
    shape = Shape(n_slots=3, x_w=7, y_w=7)
    config = MotionConfig(shape, filters=FilterRegisters(enable=request.param))
    n, random = 400, np.random.default_rng(7)
    x, y = random.integers(0, 8, (2, n)).astype(np.uint16)
    x[0] = y[0] = 1
    device = Device(config)
    with device.dumping(folder / "moving.vcd"):
        device.stream(Events(np.arange(n, dtype=np.int64) * 20, x, y, random.integers(2, size=n).astype(np.uint8)))
    write_view(folder / "moving.vcd", folder / "moving.gtkw")
    return folder


def test_all_that_is_shown_of_motion_exists_in_the_hardware(moving: Path) -> None:
    view = View(moving / "moving.gtkw")
    filtered = "behind the filters" in view.shown
    for group in VIEWS[WITH_MOTION.format("cot_filtered") if filtered else "cot_motion"]:
        shown = {label for label, *_ in view.shown[group.title.replace("{slot}", "2")]}
        wanted = {row.label or row.signal.rpartition(".")[2] for row in group.rows}
        assert wanted - shown <= {"m_pass_tick", "m_pass_event"}, group.title


def test_boxes_are_curves_and_may_lie_beyond_the_sensor(moving: Path) -> None:
    view, wave = View(moving / "moving.gtkw"), Wave.open(moving / "moving.vcd")
    curves = [label for label, _, flags, _ in view.shown["slot 0"] if flags & CURVE]
    assert curves == ["box_lo_x", "box_hi_x", "box_lo_y", "box_hi_y"]
    for label in curves:
        trace, flags, _ = view.row("slot 0", label)
        assert flags & SIGNED
        signal = next(wave[entry.path] for entry in wave.signals if entry.reference == trace)
        negative = signal.values >= 1 << signal.declared.width - 1
        assert negative.any() == ("lo" in label)


def test_boxes_and_windows_of_a_waveform_are_those_in_effect(tmp_path: Path) -> None:
    shape, shown = Shape(n_slots=3, x_w=7, y_w=7), 0
    fields = {
        name: getattr(_state, f"EV_{name.upper()}")
        for name in ("box_lo_x", "box_hi_x", "box_lo_y", "box_hi_y", "win_lo_x", "win_hi_x", "win_lo_y", "win_hi_y")
    }
    for seed in range(4):
        traffic = random_outlines(np.random.default_rng(seed), shape, 1_500, 10.0)
        model, device = MotionModel(MotionConfig(shape)), Device(MotionConfig(shape))
        model.feed(traffic)
        with device.dumping(tmp_path / f"{seed}.vcd"):
            device.stream(traffic)
        wave = Wave.open(tmp_path / f"{seed}.vcd")
        last = {entry.path.partition("u_match.")[2]: wave[entry.path] for entry in wave.signals if "u_match." in entry.path}
        for slot in np.flatnonzero(np.isin(model._state[:, _state.EV_STATE], (_state.CANDIDATE, _state.VISIBLE))):
            if model._globals[_state.SEEDING] != slot:  # a candidate that is not in effect has neither
                for name, field in fields.items():
                    signal = last[f"{name}[{slot}]"]
                    assert (int(signal.values[-1]) - model._state[slot, field]) % (1 << signal.declared.width) == 0
                    shown += 1
    assert shown > 60


def test_every_slot_has_a_group(folder: Path) -> None:
    for top, title in (("cot_array", "slot"), ("cot_chain", "tracker")):
        groups = [group for group in View(folder / f"{top}.gtkw").shown if group.startswith(title)]
        assert groups == [f"{title} {i}" for i in range(3)]


def test_a_slot_of_a_packed_vector_is_its_own_bits(folder: Path) -> None:
    view = View(folder / "cot_array.gtkw")
    assert view.row("slot 2", "active")[0] == "(0)TOP.cot_array.active[2:0]"  # counted from the left
    assert view.row("slot 0", "active")[0] == "(2)TOP.cot_array.active[2:0]"


def test_a_part_of_a_word_of_memory_is_its_own_bits(folder: Path) -> None:
    """Eleven bits of x, eleven of y, five of g in one word."""
    view = View(folder / "cot_array.gtkw")
    for label, bits in (("cm_x", range(11)), ("cm_y", range(11, 22)), ("g", range(22, 27))):
        word = "TOP.cot_array.u_update.cm[2][26:0]"
        assert view.row("slot 2", label)[0].split() == [f"({i}){word}" for i in bits]


def test_a_single_slot_is_shown_too(tmp_path: Path) -> None:
    vcd = tmp_path / "one.vcd"
    below = "$scope module u_update $end\n$var wire 7 c av_x[1] [6:0] $end\n$upscope $end\n$upscope $end\n"
    scopes = header("cot_array", "N [31:0]", "active", widths=(32, 1)).replace("$upscope $end\n", below, 1)
    vcd.write_text(scopes + "#0\nb1 a\n0b\nb0 c\n#9\n")
    write_view(vcd, tmp_path / "one.gtkw")
    assert [label for label, *_ in View(tmp_path / "one.gtkw").shown["slot 0"]] == ["active", "av_x"]


@pytest.mark.parametrize(
    ("top", "group", "signal", "file"),
    [
        ("cot_array", "decision", "phase", "phase.txt"),
        ("cot_array", "records out", "m_cm_kind", "kind.txt"),
        ("cot_array", "slot 1", "mode", "mode.txt"),
        ("cot_chain", "tracker 1", "state", "state.txt"),
    ],
)
def test_codes_are_shown_by_name(folder: Path, top: str, group: str, signal: str, file: str) -> None:
    _, flags, names = View(folder / f"{top}.gtkw").row(group, signal)
    assert flags & TRANSLATED
    assert flags & DECIMAL, "the codes in the file are decimal"
    assert names == f"/beside/{top}-{file}"
    lines = (folder / f"{top}-{file}").read_text().splitlines()
    assert {int(code): name for code, name in map(str.split, lines)} == CODES[file]


def test_centres_and_radius_are_curves(folder: Path) -> None:
    for top, group, radius in (("cot_array", "slot 0", "g"), ("cot_chain", "tracker 0", "radius")):
        curves = [label for label, _, flags, _ in View(folder / f"{top}.gtkw").shown[group] if flags & CURVE]
        assert curves == ["cm_x", "cm_y", radius]


def test_the_whole_waveform_is_in_sight(folder: Path) -> None:
    view = View(folder / "cot_array.gtkw")
    wave = Wave.open(folder / "cot_array.vcd", ["*clk"])
    begin = int(wave["TOP.clk"].times[0])
    assert int(view.settings["timestart"]) == begin
    zoom = float(re.search(r"^\*(-?[\d.]+)", (folder / "cot_array.gtkw").read_text(), re.MULTILINE)[1])
    width_px = int(view.settings["size"].split()[0]) - int(view.settings["signals_width"])
    shown = 2**-zoom * width_px / 200
    assert wave.end_time - begin <= shown < 1.1 * (wave.end_time - begin)


def test_a_module_without_a_table_shows_its_ports(tmp_path: Path) -> None:
    vcd = tmp_path / "other.vcd"
    vcd.write_text(header("fifo", "clk", "s_data [6:0]", "count [3:0]", widths=(1, 7, 4), ports=2) + "#0\n0a\nb0 b\nb0 c\n#9\n")
    write_view(vcd, tmp_path / "other.gtkw")
    view = View(tmp_path / "other.gtkw")
    assert [(g, label, trace) for g, label, trace, _, _ in view.rows()] == [
        ("ports", "clk", "TOP.clk"),
        ("ports", "s_data", "TOP.s_data[6:0]"),
    ]


def header(module: str, *names: str, widths: tuple[int, ...], ports: int = 0) -> str:
    """A VCD's header; the first `ports` signals also stand in the scope around the module."""
    declared = [
        f"$var wire {width} {chr(97 + i)} {name} $end\n" for i, (name, width) in enumerate(zip(names, widths, strict=True))
    ]
    scopes = ["$scope module TOP $end\n", *declared[:ports], f"$scope module {module} $end\n", *declared]
    return "".join(scopes) + "$upscope $end\n" * 2 + "$enddefinitions $end\n"


# ---- files ---------------------------------------------------------------------------------------------------------------


def test_what_a_view_needs_lies_beside_it_under_any_name(folder: Path) -> None:
    """All paths are in one made-up folder, the save file's own among them; GTKWave turns that into: beside the save file."""
    for top in ("cot_array", "cot_chain"):
        view = View(folder / f"{top}.gtkw")
        needed = [view.settings["dumpfile"], view.settings["savefile"], *(names for *_, names in view.rows() if names)]
        assert {os.path.dirname(path) for path in needed} == {"/beside"}
        assert all((folder / os.path.basename(path)).is_file() for path in needed)
        assert str(folder) not in (folder / f"{top}.gtkw").read_text()


def test_views_in_one_folder_do_not_share_files(folder: Path) -> None:
    assert {path.name for path in folder.glob("*.txt")} == {
        *(f"cot_array-{name}.txt" for name in ("kind", "mode", "phase")),
        *(f"cot_chain-{name}.txt" for name in ("kind", "mode", "state")),
    }  # fmt: skip


# ---- GTKWave itself ------------------------------------------------------------------------------------------------------

needs_gtkwave = pytest.mark.skipif(
    not (shutil.which("gtkwave") and shutil.which("Xvfb")), reason="needs gtkwave and Xvfb, a screen without a screen"
)


@contextmanager
def screen() -> Iterator[str]:
    """A display nobody looks at."""
    read, write = os.pipe()
    server = subprocess.Popen(
        ["Xvfb", "-displayfd", str(write), "-screen", "0", "1600x1000x24"], pass_fds=[write], stderr=subprocess.DEVNULL
    )
    os.close(write)
    try:
        with os.fdopen(read) as pipe:
            yield f":{pipe.readline().strip()}"
    finally:
        server.terminate()
        server.wait()


TELL = """
gtkwave::setMarker %d
for {set i 0} {$i < [gtkwave::getTotalNumTraces]} {incr i} {
    set value [gtkwave::getTraceValueAtMarkerFromIndex $i]
    puts "trace\t[gtkwave::getTraceFlagsFromIndex $i]\t[gtkwave::getTraceNameFromIndex $i]\t$value"
}
flush stdout
exit
"""


def shown_by_gtkwave(arguments: Sequence[Path], time: int, script: Path) -> dict[tuple[str, str], str]:
    """(group, label) -> the value that GTKWave, started in another folder, shows at a time; nothing in a closed group."""
    script.write_text(TELL % time)
    with screen() as display:
        done = subprocess.run(
            ["gtkwave", "-S", str(script), *map(str, arguments)],
            cwd="/", env={**os.environ, "DISPLAY": display, "HOME": str(script.parent)},
            capture_output=True, text=True, check=True, timeout=120,
        )  # fmt: skip
    result = {}
    group = ""
    for line in done.stdout.splitlines():
        if line.startswith("trace\t"):
            flags, label, value = line.split("\t")[1:]
            if int(flags) & GROUP_BEGIN:
                group = label
            elif not int(flags) & (GROUP_END | STRETCH):
                result[group, label] = value
    return result


def meant(view: View, wave: Wave, frac: int, time: int) -> dict[tuple[str, str], str]:
    """The same from the waveform and the contract."""
    paths = {entry.reference: entry.path for entry in wave.signals}
    values = {}
    for group, label, trace, flags, names in view.rows():
        bits = [re.fullmatch(r"(?:\((\d+)\))?(.*)", part) for part in trace.split()]
        signal = wave[paths[bits[0][2]]]
        value = int(signal.values[np.searchsorted(signal.times, time, side="right") - 1])
        if bits[0][1]:
            value = value >> signal.declared.width - 1 - int(bits[-1][1]) & (1 << len(bits)) - 1
        if flags & SIGNED and value >> signal.declared.width - 1:
            value -= 1 << signal.declared.width
        text = f"{value / (1 << frac):.15g}" if flags & FIXED_POINT else str(value)
        text = CODES[names.rpartition("-")[2]][value] if names else text
        values[group, label] = "" if group in view.closed else text
    return values


@needs_gtkwave
@pytest.mark.parametrize(
    ("top", "moment", "both_named"),
    [("cot_chain", "tracker[1].u_cot.updated", False), ("cot_array", "cot_array.found", True)],
)
def test_gtkwave_shows_every_value_after_the_folder_has_been_renamed(
    folder: Path, config: CotConfig, top: str, moment: str, both_named: bool
) -> None:
    moved = folder.rename(folder.with_name("renamed"))
    wave = Wave.open(moved / f"{top}.vcd")
    event = wave[moment]
    time = int(event.times[np.flatnonzero(event.values)[3]])
    opened = [moved / f"{top}.vcd"] * both_named + [moved / f"{top}.gtkw"]
    assert shown_by_gtkwave(opened, time, moved / "values.tcl") == meant(View(opened[-1]), wave, config.shape.frac, time)


@needs_gtkwave
@pytest.mark.parametrize("slots", [1, 2])
def test_gtkwave_finds_vectors_of_one_bit(slots: int, config: CotConfig, tmp_path: Path) -> None:
    shape = replace(config.shape, n_slots=slots)
    device = Device(CotConfig(shape, config.slots[:slots]))
    with device.dumping(tmp_path / "run.vcd"):
        device.stream(ticked(1, 60, 60))
    write_view(tmp_path / "run.vcd", tmp_path / "run.gtkw")
    result = shown_by_gtkwave([tmp_path / "run.vcd", tmp_path / "run.gtkw"], 100, tmp_path / "values.tcl")
    wanted = {"d_slot", "c_slot", "v_slot", "w_slot", "u_slot", "found_slot"}
    assert wanted <= {label for group, label in result if group in ("decision", "pipeline")}
    assert ("slot 0", "active") in result


@needs_gtkwave
def test_gtkwave_shows_signed_values_of_motion(moving: Path) -> None:
    wave, view = Wave.open(moving / "moving.vcd"), View(moving / "moving.gtkw")
    box = next(wave[entry.path] for entry in wave.signals if entry.path.endswith("u_match.box_lo_x[0]"))
    time = int(box.times[np.flatnonzero(box.values >= 1 << box.declared.width - 1)[0]]) + 40
    shown = shown_by_gtkwave([moving / "moving.vcd", moving / "moving.gtkw"], time, moving / "values.tcl")
    assert shown == meant(view, wave, SUB, time)
    assert shown["slot 0", "box_lo_x"].startswith("-")

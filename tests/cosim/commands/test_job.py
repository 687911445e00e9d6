# SPDX-License-Identifier: Apache-2.0
"""Which configuration a run gets: by what is seen in the recording, by a preset, or by a file; what may be changed alone."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from evcot.events import Recording
from evcot.recordings.files import read_recording, write_recording
from evcot.scenes.registry import simulate_scene
from evcot.trackers.auto.estimates import estimate
from evcot.trackers.auto_registers import auto_config, told
from evcot.trackers.config import RunConfig, load_toml
from evcot_cosim.cli import main, parser
from evcot_cosim.commands.actions import job
from evcot_cosim.commands.parsing import claims_of


@pytest.fixture(scope="module")
def discs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("job") / "discs.npz"
    write_recording(simulate_scene("discs", 5, {"duration_us": 1_500_000, "ways": "separate"}).recording, path)
    return path


class Printed:
    """Of `evcot cosim --print-config`: the text, the run that it makes, and what stood on stderr."""

    def __init__(self, capsys: pytest.CaptureFixture[str], folder: Path, *options: str) -> None:
        assert main(["cosim", "--print-config", *options]) == 0
        self.text, self.err = capsys.readouterr()
        path = folder / "printed.toml"
        path.write_text(self.text)
        self.config = load_toml(path, RunConfig())
        self.tables: dict[str, Any] = tomllib.loads(self.text)


def test_a_recording_is_looked_at(discs: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    recording = read_recording(discs)
    seen = estimate([recording.events], (346, 260))
    printed = Printed(capsys, tmp_path, str(discs))
    assert seen.objects is not None
    assert printed.config == auto_config(seen)
    assert printed.err == f"{told(seen, printed.config)}\n"
    assert f"# {told(seen, printed.config)}\n" in printed.text
    assert Printed(capsys, tmp_path, str(discs), "--preset", "auto").text == printed.text
    assert Printed(capsys, tmp_path, str(discs), "-q").err == ""


def test_the_printed_run_is_repeated_without_a_look(discs: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    first = Printed(capsys, tmp_path, str(discs), "--slots", "5")
    again = Printed(capsys, tmp_path, "--config", str(tmp_path / "printed.toml"))
    assert (again.config, again.err) == (first.config, "")
    assert again.config.cot.shape.n_slots == 5


def test_each_choice_can_be_changed_alone(discs: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plain = Printed(capsys, tmp_path, str(discs)).config
    filtered = Printed(capsys, tmp_path, str(discs), "--activity", "7").config
    assert filtered.filters.activity_us == filtered.in_front_of_software.activity_us == 7_000
    assert filtered.filters.refractory_us == plain.filters.refractory_us > 0
    assert filtered.cot == plain.cot
    mine = tmp_path / "mine.toml"
    mine.write_text("[motion]\nbirth_support = 123\n[auto]\ncoast = 2.0\n")
    changed = Printed(capsys, tmp_path, str(discs), "--config", str(mine)).config
    assert changed.cot.motion == replace(plain.cot.motion, birth_support=123)
    assert changed.auto.coast == 2.0
    assert changed.filters == plain.filters


@pytest.mark.parametrize("text", ["[cot]\nmax_ticks = 1234\n", "[[slot]]\nmax_ticks = 1234\n", "[motion]\nenable = 0\n"])
def test_a_file_with_registers_of_slots_is_about_the_array_without_motion(
    discs: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str
) -> None:
    mine = tmp_path / "mine.toml"
    mine.write_text(text)
    paper = Printed(capsys, tmp_path, str(discs), "--preset", "auto-paper").config
    changed = Printed(capsys, tmp_path, str(discs), "--config", str(mine)).config
    assert Printed(capsys, tmp_path, str(discs), "--preset", "auto", "--config", str(mine)).config == changed
    slots = paper.cot.slots
    if "max_ticks" in text:
        changes = len(slots) if "[cot]" in text else 1
        slots = tuple(replace(slot, max_ticks=1234) if i < changes else slot for i, slot in enumerate(slots))
    assert changed == replace(paper, cot=replace(paper.cot, slots=slots))


def test_a_file_with_the_unit_of_time_alone_leaves_motion(
    discs: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mine = tmp_path / "mine.toml"
    mine.write_text("[cot]\ntick_us = 2\n")
    assert Printed(capsys, tmp_path, str(discs), "--config", str(mine)).config.cot.motion.enable == 1


@pytest.mark.parametrize("hardware", ["cot", "cot_chain"])
def test_a_module_without_motion_gets_registers_without_it(
    discs: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], hardware: str
) -> None:
    config = Printed(capsys, tmp_path, str(discs), "--hardware", hardware).config
    assert (config.name, config.cot.motion.enable) == ("auto-paper", 0)


@pytest.mark.parametrize("options", [("--preset", "davis346"), ()])
def test_presets_and_the_box_experiment_stay(
    discs: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], options: tuple[str, ...]
) -> None:
    printed = Printed(capsys, tmp_path, *([str(discs), *options] if options else []))
    assert (printed.config.software, printed.config.name, printed.err) == ("rct", "davis346", "")
    assert "rct" in printed.tables
    assert "auto" not in printed.tables


def test_too_short_a_recording_says_that_none_was_seen(discs: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    recording = read_recording(discs)
    path = tmp_path / "short.npz"
    write_recording(Recording(recording.events[:50], 346, 260, "short"), path)
    printed = Printed(capsys, tmp_path, str(path))
    assert "no object seen for long enough -> 8 slots with motion" in printed.err
    assert printed.config.software == "auto"


def test_a_long_recording_is_looked_at_by_kernels_that_another_process_compiled(
    discs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Compiling takes 100 MB, which a run that is documented at 400 MB has not got."""
    compiled: list[object] = []
    monkeypatch.setattr(job, "compiled_aside", lambda function, *_: compiled.append(function))
    options = parser().parse_args(["cosim", str(discs)])
    options.claims = claims_of(options)
    for most, aside in ((1_000, [estimate]), (None, [])):
        compiled.clear()
        assert job.job_from(options, auto=True, most=most).more == (most is not None)
        assert compiled == aside

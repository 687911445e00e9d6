# SPDX-License-Identifier: Apache-2.0
"""Which configuration a run gets: the default, a preset, or a file; what may be changed alone."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from evcot.recordings.files import write_recording
from evcot.scenes.registry import simulate_scene
from evcot.trackers.config import RunConfig, load_toml
from evcot.trackers.presets import run_config
from evcot_cosim.cli import main, parser
from evcot_cosim.commands.actions import job
from evcot_cosim.commands.parsing import claims_of

from ..conftest import Refused


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


def test_every_recording_gets_the_default(discs: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    printed = Printed(capsys, tmp_path, str(discs))
    assert (printed.config, printed.err) == (run_config(346, 260), "")
    assert Printed(capsys, tmp_path, str(discs), "--preset", "motion").text == printed.text


def test_the_printed_run_is_repeated(discs: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    first = Printed(capsys, tmp_path, str(discs), "--slots", "5")
    again = Printed(capsys, tmp_path, "--config", str(tmp_path / "printed.toml"))
    assert (again.config, again.err) == (first.config, "")
    assert again.config.hardware.shape.n_slots == 5


def test_each_choice_can_be_changed_alone(discs: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plain = Printed(capsys, tmp_path, str(discs)).config
    filtered = Printed(capsys, tmp_path, str(discs), "--activity", "7").config
    assert filtered.filters.activity_us == filtered.in_front_of_software.activity_us == 7_000
    assert filtered.filters.refractory_us == plain.filters.refractory_us > 0
    assert filtered.hardware == plain.hardware
    mine = tmp_path / "mine.toml"
    mine.write_text("[motion]\nbirth_support = 123\n[adaptive]\ncoast = 2.0\n")
    changed = Printed(capsys, tmp_path, str(discs), "--config", str(mine)).config
    assert changed.hardware.registers == replace(plain.hardware.registers, birth_support=123)
    assert changed.adaptive.coast == 2.0
    assert changed.filters == plain.filters


@pytest.mark.parametrize("text", ["[cot]\nmax_ticks = 1234\n", "[[slot]]\nmax_ticks = 1234\n", 'hardware = "cot_array"\n'])
def test_a_file_of_cot_array_changes_the_preset_for_the_sensor(
    discs: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str
) -> None:
    mine = tmp_path / "mine.toml"
    mine.write_text(text)
    plain = Printed(capsys, tmp_path, str(discs), "--hardware", "cot_array").config
    changed = Printed(capsys, tmp_path, str(discs), "--config", str(mine)).config
    slots = plain.hardware.slots
    if "max_ticks" in text:
        changes = len(slots) if "[cot]" in text else 1
        slots = tuple(replace(slot, max_ticks=1234) if i < changes else slot for i, slot in enumerate(slots))
    assert changed == replace(plain, hardware=replace(plain.hardware, slots=slots))


@pytest.mark.parametrize("hardware", ["cot", "cot_chain", "cot_array"])
def test_other_modules_get_the_preset_for_the_sensor(
    discs: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], hardware: str
) -> None:
    config = Printed(capsys, tmp_path, str(discs), "--hardware", hardware).config
    assert (config.name, config.hardware.module) == ("davis346", hardware)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ("--hardware cot_motion --preset traffic", "hardware = 'cot_motion': these registers are those of cot, cot_chain and"),
        ("--hardware cot_array --preset motion", "hardware = 'cot_array': these registers are those of cot_motion with preset"),
        ("--preset auto", "preset 'auto': must be one of motion"),
        ("--hardware cot --slots 2", "shape.n_slots = 2: must be 1 for a single tracker"),
    ],
)
@pytest.mark.usefixtures("home")
def test_a_preset_of_other_hardware_is_refused(discs: Path, refused: Refused, options: str, message: str) -> None:
    assert message in refused("cosim", str(discs), "--print-config", *options.split())


def test_a_preset_stays_as_it_is(discs: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    printed = Printed(capsys, tmp_path, str(discs), "--preset", "davis346")
    assert (printed.config.software, printed.config.name, printed.err) == ("rct", "davis346", "")
    assert "rct" in printed.tables
    assert "adaptive" not in printed.tables


def test_the_box_experiment_is_run_by_the_default(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    printed = Printed(capsys, tmp_path)
    assert (printed.config.hardware.module, printed.config.name, printed.err) == ("cot_motion", "motion", "")


def test_a_long_recording_is_held_in_part(discs: Path) -> None:
    options = parser().parse_args(["cosim", str(discs)])
    options.claims = claims_of(options)
    for most in (1_000, None):
        assert job.job_from(options, most=most).more == (most is not None)

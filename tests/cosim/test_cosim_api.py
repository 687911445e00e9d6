# SPDX-License-Identifier: Apache-2.0
"""`import evcot_cosim`: the co-simulation as a function does and writes what `evcot cosim` does and writes."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import evcot
import evcot_cosim
import evcot_cosim.rtl.build
from evcot_cosim.cli import main


@pytest.fixture(autouse=True)
def in_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("EVCOT_CACHE", str(evcot_cosim.rtl.build.cache_dir()))
    monkeypatch.chdir(tmp_path)


@pytest.fixture(scope="module")
def recording() -> evcot.Recording:
    return evcot.simulate("discs", 3, duration_us=60_000).recording


def same(folder: str, other: str) -> bool:
    """Whether two folders of runs hold the same logs and the same configuration."""
    logs = [(Path(folder) / f"{side}.csv").read_bytes() == (Path(other) / f"{side}.csv").read_bytes() for side in SIDES]
    tables = [tomllib.loads((Path(one) / "run.toml").read_text()) for one in (folder, other)]
    for one in tables:
        del one["files"], one["run"]
    return all(logs) and tables[0] == tables[1]


SIDES = ("hardware", "model", "software")


@pytest.mark.parametrize("options", [{}, {"hardware": "cot_chain"}, {"preset": "discs", "slots": 3}, {"stall_seed": 5}])
def test_a_call_does_what_the_command_does(recording: evcot.Recording, options: dict[str, str | int]) -> None:
    evcot.write(recording, "discs.npz")
    run = evcot_cosim.cosim("discs.npz", **options)  # type: ignore[arg-type]
    summary = run.save("call")
    assert summary["exact"] is True
    words = [f"--{name.replace('stall_seed', 'stalls')}={value}" for name, value in options.items()]
    assert main(["cosim", "discs.npz", "-o", "command", "-q", *words]) == 0
    assert same("call", "command")
    names = [{path.name for path in Path(folder).iterdir()} for folder in ("call", "command")]
    assert names[0] == names[1]


def test_a_recording_in_memory_is_saved_with_its_run_and_repeated(recording: evcot.Recording) -> None:
    run = evcot_cosim.cosim(recording)
    assert run.config.hardware.module == "cot_motion"
    assert np.array_equal(run.hardware.records, run.model.records)
    run.save("run", waves=False)
    assert main(["cosim", "--config", "run/run.toml", "-o", "again", "-q", "--no-waves"]) == 0
    assert same("run", "again")
    run.save("run", waves=False)  # its own files are replaced
    replace(run, source=evcot_cosim.Source("boxes", is_scene=True)).save("boxes", waves=False)  # no file


def test_an_output_is_no_input_and_no_other_s_folder(recording: evcot.Recording) -> None:
    Path("mine").mkdir()
    Path("mine/notes.txt").write_text("mine")
    Path("data").mkdir()
    evcot.write(recording, "data/discs.npz")
    run = evcot_cosim.cosim("data/discs.npz", preset="discs")
    for folder, message in (("mine", "mine: holds files, and evcot did not make it"), ("data", "data: holds ")):
        with pytest.raises(evcot.OutputError, match=f"^{message}"):
            run.save(folder)
    assert Path("mine/notes.txt").read_text() == "mine"


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"config": evcot.run_config(346, 260), "slots": 3}, "config: must not be given with preset, hardware or slots"),
        ({"hardware": "cot_arry"}, "hardware = 'cot_arry': must be one of cot, cot_chain, cot_array, cot_motion; did you mean"),
        ({"hardware": "cot_motion", "preset": "discs"}, "hardware = 'cot_motion': these registers are those of cot, cot_chain"),
    ],
)
def test_what_cannot_be_is_refused(recording: evcot.Recording, options: dict[str, object], message: str) -> None:
    with pytest.raises(evcot.ConfigError) as caught:
        evcot_cosim.cosim(recording, **options)  # type: ignore[arg-type]
    assert str(caught.value).startswith(message)


def test_the_sensor_is_given_once() -> None:
    config = evcot.run_config(346, 260)
    assert config.device_config() == config.device_config(346, 260)
    assert config.device_config().filter_shape.width == 346
    with pytest.raises(evcot.ConfigError, match=r"^device_config: width and height must be given"):
        evcot.RunConfig(filters=evcot.FilterConfig(activity_us=1_000)).device_config()

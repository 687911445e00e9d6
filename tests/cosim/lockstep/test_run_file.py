# SPDX-License-Identifier: Apache-2.0
"""run.toml repeats a run exactly, from any folder, and says so where it cannot."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from evcot.digest import digest
from evcot.errors import ConfigError
from evcot.events import Events, Recording
from evcot.filters.config import FilterConfig
from evcot.hardware.config import CotConfig
from evcot.recordings.files import write_recording
from evcot.trackers.config import RunConfig
from evcot.trackers.presets import PRESETS
from evcot_cosim.lockstep.run_file import RunFile, Source, read_run_file, run_toml, write_run_file


def events(n: int = 50) -> Events:
    t = np.arange(n, dtype=np.int64)
    return Events(t, (t % 40).astype(np.uint16), (t % 30).astype(np.uint16), (t % 2).astype(np.uint8))


def back(run: RunFile, folder: Path) -> RunFile:
    write_run_file(folder / "run.toml", run)
    found = read_run_file(folder / "run.toml")
    assert found is not None
    return found


@pytest.mark.parametrize("name", PRESETS)
def test_every_preset_comes_back_as_it_was(name: str, tmp_path: Path) -> None:
    run = RunFile(Source("boxes", is_scene=True, seed=7), 3, "0123", PRESETS[name])
    assert back(run, tmp_path) == run


def test_slots_and_filters_of_their_own_come_back(tmp_path: Path) -> None:
    base = PRESETS["davis346"].hardware
    slots = tuple(replace(slot, init_radix=11 + i % 3) for i, slot in enumerate(base.slots))
    filters = FilterConfig(region=(1, 2, 30, 40), polarity="on", hot_pixels=((3, 4), (5, 6)), decay_tau_us=1500.0)
    config = RunConfig("own", CotConfig(base.shape, slots, 3), PRESETS["slow"].rct, filters)
    run = RunFile(Source("boxes", is_scene=True, from_us=5, to_us=500), None, "", config)
    assert back(run, tmp_path) == run


def test_a_file_is_named_from_the_root_and_a_scene_by_its_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    config = PRESETS["slow"]
    assert f'recording = "{tmp_path}/x.npz"' in run_toml(RunFile(Source("x.npz"), None, "", config))
    text = run_toml(RunFile(Source("boxes", is_scene=True, seed=0), None, "", config))
    assert 'scene = "boxes"' in text
    assert "recording" not in text
    assert "seed = 0" in text


def test_the_current_folder_changes_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither a file that is called as a scene is, nor one of the recording's name."""
    home, away = tmp_path / "home", tmp_path / "away"
    for folder, count in ((home, 100), (away, 50)):
        folder.mkdir()
        write_recording(Recording(events(count), 40, 30, "x"), folder / "x.npz")
        (folder / "boxes").write_text("no scene")
    (home / "file.toml").write_text("[run]\nrecording = 'x.npz'\n")
    (home / "scene.toml").write_text("[run]\nscene = 'boxes'\nto_us = 1000\n")
    monkeypatch.chdir(away)
    file, scene = read_run_file(Path("../home/file.toml")), read_run_file(home / "scene.toml")
    assert file is not None
    assert scene is not None
    assert len(file.source.read().events) == 100
    assert scene.source.name == "boxes"
    assert len(scene.source.read().events)
    assert scene.source.scene_truth() is not None
    assert back(scene, home) == scene
    assert not Source.named("boxes").is_scene  # on the command line a file comes first
    monkeypatch.chdir(tmp_path)
    assert Source.named("boxes").is_scene


def test_the_digest_tells_every_field_of_every_event() -> None:
    same = digest(events())
    assert same == digest(events()) == digest(events(100)[:50])
    for field in ("t_us", "x", "y", "p"):
        column = getattr(events(), field).copy()
        column[17] ^= 1
        assert digest(replace(events(), **{field: column})) != same


def test_a_recording_that_has_changed_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "x.npz"
    write_recording(Recording(events(), 40, 30, "x"), path)
    source = Source(str(path))
    run = RunFile(source, None, digest(source.read().events), PRESETS["slow"])
    run.check(tmp_path / "run.toml", source.read().events)
    write_recording(Recording(events(49), 40, 30, "x"), path, force=True)
    with pytest.raises(ConfigError, match=r"run\.toml: run\.digest = '\w+': must be that of .*x\.npz, which has changed since"):
        run.check(tmp_path / "run.toml", source.read().events)


def test_a_configuration_alone_is_no_run(tmp_path: Path) -> None:
    (tmp_path / "own.toml").write_text("[cot]\nhist_avg = 2\n")
    assert read_run_file(tmp_path / "own.toml") is None


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("run = 3", r"\[run\] must be a table, not 3"),
        ("[run]\nfile = 'x'", r"\[run\]: unknown field 'file': must be one of digest, from_us, height"),
        ("[run]\nstalls = 3", r"\[run\]: must have either recording, a file, or scene, one of boxes, "),
        ("[run]\nrecording = 'x.npz'\nscene = 'boxes'", r"\[run\]: must have either recording, a file, or scene"),
        ("[run]\nscene = 'nowhere'", r"run\.scene = 'nowhere': must be one of boxes, "),
        ("[run]\nrecording = 3", r"run\.recording = 3: must be text"),
        ("[run]\nrecording = 'boxes'\nfrom_us = -1", r"run\.from_us = -1: must be a whole number, not negative"),
        ("[run]\nrecording = 'boxes'\nstalls = true", r"run\.stalls = True: must be a whole number"),
        ("[run]\nrecording = 'boxes'\nskip_damaged = 1", r"run\.skip_damaged = 1: must be true or false"),
        ("[run]\nrecording = 'boxes'\nhardware = 'cot'", r"\[run\]: unknown field 'hardware'"),
        ("hardware = 'gpu'", r"hardware = 'gpu': must be one of cot, cot_chain, cot_array, cot_motion"),
    ],
)
def test_a_table_run_that_cannot_be_used(text: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "run.toml").write_text(text)
    with pytest.raises(ConfigError, match=r"run\.toml: " + message):
        read_run_file(tmp_path / "run.toml")

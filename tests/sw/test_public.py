# SPDX-License-Identifier: Apache-2.0
"""`import evcot`: what the commands do, as functions."""

from __future__ import annotations

from dataclasses import replace
from inspect import Parameter, signature
from pathlib import Path

import numpy as np
import pytest

import evcot
from evcot.digest import digest
from evcot.filters.run import apply
from evcot.metrics import evaluate as score
from evcot.metrics import load_rule, read_truth
from evcot.trackers.rct.config import PRESETS as RCT
from evcot.trackers.settings import changeable
from support.refusals import refused


@pytest.fixture(scope="module")
def scene() -> evcot.Scene:
    return evcot.simulate("discs", seed=5, duration_us=200_000)


@pytest.fixture
def path(scene: evcot.Scene, tmp_path: Path) -> Path:
    path = tmp_path / "discs.npz"
    evcot.write(scene.recording, path)
    return path


def same(one: evcot.TrackLog, other: evcot.TrackLog) -> bool:
    same_arrays = np.array_equal(one.records, other.records) and np.array_equal(one.owner, other.owner)
    return same_arrays and (one.engine, one.recording) == (other.engine, other.recording)


def test_a_recording_is_written_and_read(scene: evcot.Scene, path: Path) -> None:
    assert digest(evcot.read(path).events) == digest(scene.recording.events)
    part = evcot.read(path, from_us=50_000, to_us=100_000)
    assert 0 < len(part.events) < len(scene.recording.events)
    with evcot.open_recording(path) as file:
        assert sum(map(len, file.blocks())) == len(scene.recording.events)


@pytest.mark.parametrize("engine", evcot.ENGINES)
def test_a_file_and_what_it_holds_give_the_same_log(scene: evcot.Scene, path: Path, engine: str) -> None:
    log = evcot.track(scene.recording, engine)
    assert log.engine == engine
    assert log.recording == digest(scene.recording.events)
    assert len(log.of_kind(evcot.Kind.BORN)) >= (1 if engine == "cot" else 4)  # a single tracker follows one object
    assert same(log, evcot.track(path, engine))


def test_settings_come_from_preset_file_and_keywords(scene: evcot.Scene, tmp_path: Path) -> None:
    config = tmp_path / "mine.toml"
    config.write_text("[rct]\nradius_px = 9.0\nlifetime_us = 7_000\n")
    name = list(RCT)[-1]
    log = evcot.track(scene.recording, "rct", name, config=config, lifetime_us=8_000)
    wanted = replace(RCT[name], radius_px=9.0, lifetime_us=8_000)
    filters = evcot.ENGINES["rct"].filters.get(name)
    assert same(log, evcot.track(scene.recording, "rct", settings=wanted, filters=filters))
    assert not same(log, evcot.track(scene.recording, "rct", name))


def test_the_hardware_s_model_takes_a_run_s_configuration(scene: evcot.Scene) -> None:
    config = evcot.run_config(scene.recording.width, scene.recording.height, "discs", n_slots=6)
    assert config.hardware.shape.n_slots == 6
    log = evcot.track(scene.recording, "cot_array", settings=config)
    assert np.count_nonzero(log.owner == evcot.DROPPED)  # its filters are on
    unfiltered = evcot.track(scene.recording, "cot_array", settings=config, filters=evcot.FilterConfig())
    assert not np.count_nonzero(unfiltered.owner == evcot.DROPPED)


def test_filters_are_those_of_the_room(scene: evcot.Scene) -> None:
    clean = evcot.filter(scene.recording, refractory_us=500, polarity="on")
    wanted, _ = apply(scene.recording, evcot.FilterConfig(refractory_us=500, polarity="on"))
    assert 0 < len(clean.events) < len(scene.recording.events)
    assert digest(clean.events) == digest(wanted.events)


def test_a_log_is_held_against_a_truth_however_it_is_given(scene: evcot.Scene, tmp_path: Path) -> None:
    log = evcot.track(scene.recording, "rct", "discs")
    saved, csv = tmp_path / "log.npz", tmp_path / "truth.csv"
    log.save_npz(saved)
    scene.truth.save(csv)
    rule = load_rule("scene")
    wanted = score(log, read_truth(csv, rule), rule)
    assert wanted.hota > 0.3
    for given in (scene.truth, csv, str(csv)):
        assert evcot.evaluate(log, given) == wanted
    assert evcot.evaluate(saved, csv, "scene") == wanted
    assert evcot.evaluate(log, read_truth(csv, rule), rule) == wanted


def test_a_film_is_written_and_refuses_a_recording_without_events(scene: evcot.Scene, tmp_path: Path) -> None:
    log = evcot.track(scene.recording, "rct", "discs")
    path = tmp_path / "film.gif"
    evcot.render(scene.recording, {"rct": log}, path, fps=10)
    assert path.read_bytes().startswith(b"GIF8")
    with pytest.raises(evcot.OutputError, match=r"film\.gif: exists"):
        evcot.render(scene.recording, {"rct": log}, path)
    empty = evcot.Recording(scene.recording.events[:0], 346, 260)
    with pytest.raises(evcot.RecordingError, match="recording: holds no events: a film needs one at least"):
        evcot.render(empty, {"rct": log}, tmp_path / "empty.gif")


def test_bad_input_is_one_line(scene: evcot.Scene, tmp_path: Path) -> None:
    recording, config = scene.recording, evcot.ConfigError
    nothing = evcot.GroundTruth(np.empty(0, np.int64), np.empty(0), ())
    for make, error, message in (
        (lambda: evcot.track(recording, "rtc"), config, "engine rtc: must be one of cot_motion, cot_array,"),
        (lambda: evcot.track(recording, "rct", "cars"), config, "preset cars: must be one of plain"),
        (lambda: evcot.track(recording, radium=3), config, "cot_motion.radium: no such setting: must be one of"),
        (lambda: evcot.track(recording, "rct", radius_px=-1.0), config, "rct.radius_px = -1.0: must be from "),
        (lambda: evcot.track(recording, "cot_array", "davis346", init_radix=3), config,
         "engine cot_array with preset davis346: no single setting can be changed: its slots have registers of their own"),
        (lambda: evcot.track(recording, "cot_array", settings=RCT["plain"]), config,
         "settings of type RctConfig: must be RunConfig with engine cot_array"),
        (lambda: evcot.track(recording, "rct", "plain", settings=RCT["plain"]), config,
         "settings: must not be given with preset or config"),
        (lambda: evcot.track(tmp_path / "none.raw"), evcot.RecordingError, f"{tmp_path}/none.raw: cannot be read: No such"),
        (lambda: evcot.filter(recording, refractory=3), config, "filters.refractory: no such setting"),
        (lambda: evcot.simulate("disks"), config, "scene 'disks': must be one of boxes,"),
        (lambda: evcot.run_config(346, 260, "none"), config, "preset 'none': must be one of motion, slow,"),
        (lambda: evcot.evaluate(evcot.TrackLog.empty("rct"), nothing), config,
         "rule: must be given with a truth that was read already"),
    ):  # fmt: skip
        with refused(error, start=message):
            make()


def test_no_setting_has_the_name_of_an_argument_of_track() -> None:
    taken = signature(evcot.track).parameters.values()
    arguments = {one.name for one in taken if one.kind in (Parameter.POSITIONAL_OR_KEYWORD, Parameter.KEYWORD_ONLY)}
    assert "engine" in arguments
    for name, engine in evcot.ENGINES.items():
        if name not in ("cot_array", "cot_chain", "cot"):  # of which no single setting can be changed
            for settings in engine.presets.values():
                assert not arguments & set(changeable(name, settings))


@pytest.mark.parametrize("engine", ["cot_motion", "cot_chain", "cot"])
def test_a_configuration_of_another_module_is_refused(scene: evcot.Scene, engine: str, tmp_path: Path) -> None:
    settings = evcot.run_config(346, 260, hardware="cot_array")
    with pytest.raises(evcot.ConfigError, match=r"^settings: are of cot_array: must be given with engine cot_array$"):
        evcot.track(scene.recording, engine, settings=settings)
    (tmp_path / "mine.toml").write_text('hardware = "cot_array"\n')
    with pytest.raises(evcot.ConfigError, match=r"mine.toml: is about cot_array: must be used with engine cot_array$"):
        evcot.track(scene.recording, engine, config=tmp_path / "mine.toml")


def test_registers_of_a_file_stay_those_of_the_engine(scene: evcot.Scene, tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text("[cot]\nmax_ticks = 9_000\n")
    chain = evcot.track(scene.recording, "cot_chain", config=tmp_path / "mine.toml")
    base = evcot.run_config(346, 260, hardware="cot_chain")
    slots = tuple(replace(slot, max_ticks=9_000) for slot in base.hardware.slots)
    assert same(
        chain, evcot.track(scene.recording, "cot_chain", settings=replace(base, hardware=replace(base.hardware, slots=slots)))
    )
    assert not same(chain, evcot.track(scene.recording, "cot_chain"))


def test_a_tracker_as_a_stream_is_what_tracks_a_recording(scene: evcot.Scene) -> None:
    events, whole = scene.recording.events, evcot.track(scene.recording)
    tracker = evcot.tracker((346, 260))
    parts = [tracker.feed(events[begin : begin + 3_000]) for begin in range(0, len(events), 3_000)]
    assert np.array_equal(np.concatenate([records for records, _ in parts] + [tracker.finish()]), whole.records)
    assert np.array_equal(np.concatenate([owner for _, owner in parts]), whole.owner)


def test_a_figure_of_tracks_is_drawn_once(scene: evcot.Scene, tmp_path: Path) -> None:
    log = evcot.track(scene.recording, "rct", "discs")
    evcot.plot(scene.recording, {"rct": log}, tmp_path / "tracks.png", ("tracks", "xy"), dpi=80)
    assert (tmp_path / "tracks.png").read_bytes().startswith(b"\x89PNG")
    with pytest.raises(evcot.OutputError, match="exists"):
        evcot.plot(scene.recording, {"rct": log}, tmp_path / "tracks.png")

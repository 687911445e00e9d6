# SPDX-License-Identifier: Apache-2.0
"""Filters in front of a whole run: hardware, model and software tracker see the same events, and logs number all of them."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from evcot.events import Events, Recording
from evcot.filters.config import FilterConfig
from evcot.filters.hot_pixels import learn_hot_pixels
from evcot.filters.run import apply
from evcot.hardware.modules import Module
from evcot.recordings.files import read_recording, write_recording
from evcot.trackers.presets import fit, for_sensor, run_config
from evcot.tracks.log import DROPPED, TrackLog
from evcot_cosim.cli import main
from evcot_cosim.lockstep.cosim import run_cosim
from shared import SHARED

HOT = (20, 100)


def noisy_blob(count: int = 6_000) -> Recording:
    """A blob that wanders to the right, and a hot pixel at `HOT` that sends every third event."""
    rng = np.random.default_rng(4)
    t_us = np.sort(rng.integers(0, 300_000, count))
    x = np.clip(30 + t_us / 5_000 + rng.normal(0, 3, count), 0, 127).astype(np.uint16)
    y = np.clip(50 + rng.normal(0, 3, count), 0, 127).astype(np.uint16)
    hot = np.arange(count) % 3 == 0
    x[hot], y[hot] = HOT
    return Recording(Events(t_us, x, y, rng.integers(0, 2, count).astype(np.uint8)), 128, 128, "noisy")


def near(log: TrackLog, place: tuple[int, int], reach_px: float = 5) -> int:
    """How many records lie within `reach_px` of a pixel."""
    return int(np.count_nonzero(np.hypot(log.records["x"] - place[0], log.records["y"] - place[1]) < reach_px))


@pytest.mark.parametrize("module", ["cot_array", "cot_chain"])
def test_all_engines_work_behind_the_same_filters(module: Module) -> None:
    recording = noisy_blob()
    filters = FilterConfig(hot_pixels=(HOT,), activity_us=20_000)
    config = replace(run_config(128, 128, n_slots=4, hardware=module), filters=filters)
    run = run_cosim(recording, config)
    _, keep = apply(recording, filters)
    for log in (run.hardware, run.model, run.software):
        np.testing.assert_array_equal(log.owner == DROPPED, ~keep)
        assert len(log.records) > 10
        assert near(log, HOT) == 0
    assert np.array_equal(run.hardware.records, run.model.records)
    moved = run.hardware.records[run.hardware.records["kind"] == 1]
    assert keep[moved["event_index"]].all()  # in the recording's numbers: what moves a centre has stayed
    np.testing.assert_array_equal(moved["t_us"], recording.events.t_us[moved["event_index"]])
    bare = run_cosim(recording, replace(config, filters=FilterConfig()))
    assert near(bare.hardware, HOT) > 10  # it would have held a cluster
    assert near(bare.software, HOT) > 10


@pytest.mark.parametrize("side", [1, 2, 4])
def test_hardware_and_model_have_the_same_memory_of_cells(side: int) -> None:
    recording = noisy_blob()
    filters = FilterConfig(refractory_us=5_000, activity_us=20_000, decay_tau_us=20_000.0, rowcol_us=90_000, cell_px=side)
    config = replace(fit(for_sensor(128), 128, 128, 4), filters=filters)
    run = run_cosim(recording, config)
    _, keep = apply(recording, filters)
    assert 0.02 < keep.mean() < 0.9
    for log in (run.hardware, run.model, run.software):
        np.testing.assert_array_equal(log.owner == DROPPED, ~keep)
    assert np.array_equal(run.hardware.records, run.model.records)


def test_a_config_file_puts_filters_in_front(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_recording(noisy_blob(), tmp_path / "noisy.npz")
    (tmp_path / "hot.txt").write_text(f"# hot pixels of a 128x128 sensor\n{HOT[0]} {HOT[1]}\n")
    toml = tmp_path / "run.toml"
    toml.write_text('[filters]\nhot_pixels_file = "hot.txt"\nactivity_us = 20000\n')
    command = ["cosim", str(tmp_path / "noisy.npz"), "--preset", "dvs128", "--config", str(toml), "-o", str(tmp_path / "out")]
    assert main(command) == 0
    assert "of the events, by mask, activity" in capsys.readouterr().out
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["exact"]
    assert summary["filters"] == ["mask", "activity"]
    assert 0.3 < summary["filtered_fraction"] < 0.5
    assert summary["config"]["filters"]["hot_pixels"] == [list(HOT)]
    view = (tmp_path / "out" / "waves.gtkw").read_text()
    assert "behind the filters" in view
    assert "slot 0" in view


def test_a_hot_pixel_outside_the_sensor_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_recording(noisy_blob(100), tmp_path / "noisy.npz")
    (tmp_path / "run.toml").write_text("[filters]\nhot_pixels = [[200, 5]]\n")
    assert main(["cosim", str(tmp_path / "noisy.npz"), "--config", str(tmp_path / "run.toml")]) == 2
    assert "(200, 5): must lie on the 128x128 sensor" in capsys.readouterr().err


def test_the_hot_pixel_of_the_traffic_recording_holds_no_cluster_behind_its_learned_mask() -> None:
    path = SHARED / "traffic_outbound.aedat4"
    if not path.exists():
        pytest.skip(f"needs {path.name}")
    recording = read_recording(path, to_us=1_000_000)
    hot = learn_hot_pixels([recording.events], (recording.width, recording.height))
    assert (192, 209) in hot
    config = fit(for_sensor(recording.width), recording.width, recording.height)
    before = run_cosim(recording, config)
    after = run_cosim(recording, replace(config, filters=FilterConfig(hot_pixels=tuple(hot))))
    assert near(before.hardware, (192, 209), 2) > 100
    assert near(before.software, (192, 209), 2) > 100
    assert near(after.hardware, (192, 209), 2) < 10
    assert near(after.software, (192, 209), 2) < 10

# SPDX-License-Identifier: Apache-2.0
"""The package of docs/plug_in.md, installed into a folder of its own: the command runs its tracker like ours."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import evcot
from evcot.trackers.plug_in import PlugInTracker
from evcot.tracks.tracking import log_of

PAGE = (Path(__file__).parents[3] / "docs" / "plug_in.md").read_text(encoding="utf-8")
LENGTH_US = 300_000
SWEEP = """
name = "mine"
engines = ["mine", "frames"]
scenes = ["discs"]
[scene_settings]
duration_us = 100000
[fields]
mine.packet_us = [2000, 10000]
"""


def block(language: str) -> str:
    return re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)[0]


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    source = tmp_path_factory.mktemp("my-tracker")
    (source / "pyproject.toml").write_text(block("toml"))
    (source / "my_tracker.py").write_text(block("python"))
    site = tmp_path_factory.mktemp("site")
    command = "pip install --quiet --no-deps --no-index --no-build-isolation --disable-pip-version-check --target"
    done = subprocess.run([sys.executable, "-m", *command.split(), site, source], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return site


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording, drive.aedat4, with its truth."""
    folder = tmp_path_factory.mktemp("drive")
    scene = evcot.simulate("discs", 4, duration_us=LENGTH_US, count=1)
    evcot.write(scene.recording, folder / "drive.aedat4")
    with (folder / "drive.truth.csv").open("wb") as file:
        scene.truth.write(file)
    (folder / "sweep.toml").write_text(SWEEP)
    return folder


def evcot_command(words: str, site: Path, folder: Path) -> subprocess.CompletedProcess[str]:
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(site), *filter(None, sys.path)])}
    command = [sys.executable, "-m", "evcot", *words.split()]
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)


def done(words: str, site: Path, folder: Path) -> str:
    ran = evcot_command(words, site, folder)
    assert ran.returncode == 0, ran.stderr
    return ran.stdout


def test_track_evaluate_and_report_of_the_page(site: Path, folder: Path) -> None:
    for line in block("sh").splitlines()[1:]:
        assert done(line.removeprefix("evcot "), site, folder)
    log = evcot.TrackLog.load(folder / "mine.npz")
    assert log.engine == "mine"
    assert len(log.tracks) == 1
    assert abs(len(log.tracks[0].path) - LENGTH_US / 5_000) <= 1
    assert '<th scope="row">software</th><td class="words">mine</td>' in (folder / "mine.html").read_text()
    assert "mine: tracker of package my-tracker" in " ".join(done("track --help", site, folder).split())


def test_a_sweep_sets_its_fields_and_scores_it_beside_ours(site: Path, folder: Path) -> None:
    dataset = pytest.importorskip("pyarrow.dataset")
    done("sweep sweep.toml -o swept --jobs 1 -q", site, folder)
    rows = dataset.dataset(folder / "swept" / "runs", format="parquet").to_table().to_pylist()
    assert {(row["engine"], row["mine.packet_us"], row["status"]) for row in rows} == {
        ("mine", 2_000, "done"), ("mine", 10_000, "done"), ("frames", None, "done"),
    }  # fmt: skip
    assert all(row["hota"] is not None for row in rows)
    codes = {row["engine"]: row["code"] for row in rows}
    assert codes["mine"] != codes["frames"]  # another version of the package is another run


def test_splitting_into_runs_changes_nothing(site: Path, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(site)
    import my_tracker  # type: ignore[import-not-found]

    events = evcot.read(folder / "drive.aedat4").events
    whole, parts = (
        log_of("mine", PlugInTracker("mine", my_tracker.MyTracker(346, 260)), blocks)
        for blocks in ([events], [events[at : at + 997] for at in range(0, len(events), 997)])
    )
    np.testing.assert_array_equal(whole.records, parts.records)


def test_a_filter_can_be_put_in_front(site: Path, folder: Path) -> None:
    found = json.loads(done("track drive.aedat4 --engine mine --activity 5 --json", site, folder))
    assert found["filtered"] > 0
    assert found["events"] == found["owned"] + found["filtered"]


@pytest.mark.parametrize(
    ("right", "wrong", "message"),
    [
        (
            "import numpy as np",
            "import no_such_package",
            "cannot be loaded: ModuleNotFoundError: No module named 'no_such_package'",
        ),
        ("return records", "return None", "feed: records are NoneType: must be a 1-d array of dtype evcot.TRACK"),
        ("= Kind.MOVED, -1, 0.5", "= Kind.MOVED, -1, 1.5", "feed: record 0: confidence = 1.5: must be a number from 0 to 1"),
        ("complete), np.zeros", "complete) / 0, np.zeros", "feed failed: "),
    ],
)
def test_a_tracker_that_does_not_work_ends_the_command_in_one_line(
    site: Path, folder: Path, tmp_path: Path, right: str, wrong: str, message: str
) -> None:
    for path in site.rglob("*"):
        if path.is_file() and "__pycache__" not in path.parts:
            copy = tmp_path / path.relative_to(site)
            copy.parent.mkdir(parents=True, exist_ok=True)
            copy.write_bytes(path.read_bytes())
    module = tmp_path / "my_tracker.py"
    assert right in module.read_text()
    module.write_text(module.read_text().replace(right, wrong))
    ran = evcot_command("track drive.aedat4 --engine mine -o wrong.npz -q", tmp_path, folder)
    assert ran.returncode == 2
    assert ran.stderr.startswith(f"evcot: engine mine of package my-tracker: my_tracker:MyTracker: {message}")
    assert ran.stderr.count("\n") == 1
    assert not (folder / "wrong.npz").exists()
    if "cannot be loaded" in message:
        assert evcot_command("track drive.aedat4 --engine frames -q", tmp_path, folder).returncode == 0
        for words in (
            "sweep sweep.toml --dry-run",
            "presets --engine mine",
            "track drive.aedat4 --engine mine --set packet_us=3",
        ):
            said = evcot_command(words, tmp_path, folder).stderr
            assert said == ran.stderr

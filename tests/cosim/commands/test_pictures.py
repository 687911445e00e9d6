# SPDX-License-Identifier: Apache-2.0
"""`evcot plot` and `evcot render`: a recording with its logs, or the folder of a run."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from evcot.digest import digest
from evcot.events import Recording
from evcot.recordings.files import write_recording
from evcot.scenes.registry import simulate_scene
from evcot.trackers.config import RunConfig
from evcot.trackers.presets import fit, preset
from evcot.trackers.rct.config import PRESETS
from evcot.trackers.rct.tracker import track
from evcot.tracks.log import TrackLog
from evcot_cosim.cli import main
from evcot_cosim.lockstep.run_file import RunFile, Source, write_run_file

from ..conftest import Refused

OUTPUT = {"plot": "a.png", "render": "a.gif"}


@pytest.fixture(scope="module")
def discs() -> Recording:
    """Four discs for 0.3 s."""
    return simulate_scene("discs", 5, {"duration_us": 300_000}).recording


@pytest.fixture
def folder(discs: Recording, home: Path) -> Path:
    """A recording, its log, and what `evcot cosim` leaves of a run."""
    write_recording(discs, "discs.npz")
    log = track(discs, PRESETS["plain"])
    log.save_npz("log.npz")
    Path("run").mkdir()
    for name in ("hardware", "software", "model"):
        log.save_npz(f"run/{name}.npz")
    config: RunConfig = fit(preset("davis346"), discs.width, discs.height)
    sensor = {"width": discs.width, "height": discs.height}
    run = RunFile(Source("discs.npz", **sensor), None, digest(discs.events), config)
    write_run_file(Path("run/run.toml"), run)
    return home


def size_of(path: str) -> tuple[int, int]:
    with Image.open(path) as image:
        return image.size


def test_a_figure_of_a_recording(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert (
        main(["plot", "discs.npz", "log.npz", "-o", "a.png", "--kind", "tracks, alive", "--columns", "2", "--dpi", "100"]) == 0
    )
    assert capsys.readouterr().out == "a.png: tracks, alive of log\n"
    assert size_of("a.png")[0] == pytest.approx(178 / 25.4 * 100, abs=1)
    assert main(["plot", "discs.npz", "log.npz", "-o", "b.pdf", "-q", "--from", "100", "--to", "200", "--width", "60"]) == 0
    assert capsys.readouterr().out == ""
    assert Path("b.pdf").read_bytes().startswith(b"%PDF")


def test_a_figure_of_a_run_has_hardware_and_software(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["plot", "run", "-o", "a.svg"]) == 0
    assert main(["plot", "run", "model", "-o", "b.svg"]) == 0
    assert capsys.readouterr().out == "a.svg: tracks of hardware, software\nb.svg: tracks of model\n"


def test_a_film_of_a_part(folder: Path, discs: Recording, capsys: pytest.CaptureFixture[str]) -> None:
    options = ["--from", "100", "--to", "200", "--fps", "20", "--speed", "0.5", "--width", "300"]
    assert main(["render", "discs.npz", "log.npz", "-o", "a.gif", *options]) == 0
    printed = capsys.readouterr()
    assert printed.out.startswith("a.gif: 5 pictures in ")
    assert printed.err == ""
    with Image.open("a.gif") as gif:
        assert gif.n_frames == 5  # type: ignore[attr-defined]
        assert gif.width >= 300
        assert gif.width % discs.width in (0, 1)
        assert len(np.unique(np.asarray(gif.convert("RGB")).reshape(-1, 3), axis=0)) > 5


@pytest.mark.parametrize("source", ["discs.npz log.npz", "run"])
def test_a_film_of_a_part_begins_with_the_events_before_it(folder: Path, source: str) -> None:
    """Without them, its first picture is almost black."""
    for name, more in (("whole", ""), ("part", "--from 100 --to 200")):
        assert main(["render", *source.split(), "-o", f"{name}.gif", "--fps", "10", "-q", *more.split()]) == 0
    with Image.open("whole.gif") as whole, Image.open("part.gif") as part:
        whole.seek(1)  # at 100 ms
        pictures = [np.asarray(gif.convert("RGB")).astype(int)[:400] for gif in (whole, part)]  # below is the time
    green = [np.count_nonzero((picture[..., 1] > 100) & (picture[..., 0] < 80)) for picture in pictures]
    assert green[0] > 500
    assert green[1] == pytest.approx(green[0], rel=0.02)


def test_a_film_of_a_run(folder: Path) -> None:
    assert main(["render", "run", "-o", "a.gif", "--fps", "10", "-q"]) == 0
    assert main(["render", "run", "software", "-o", "b.gif", "--fps", "10", "-q"]) == 0
    assert Path("a.gif").read_bytes() != Path("b.gif").read_bytes()


@pytest.mark.parametrize("command", ["plot", "render"])
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("discs.npz", "discs.npz: is no folder of a run: the recording's track logs must be given after it"),
        ("discs.npz none.npz", "none.npz: cannot be read: No such file or directory"),
        ("discs.npz discs.npz", "discs.npz: has no array engine: must have engine, records, owner"),
        ("none.npz log.npz", "none.npz: cannot be read: No such file or directory"),
        ("run none", "none: must be one of hardware, software, model with the folder of a run"),
        ("run --from 9999", "holds no events from"),
        ("discs.npz log.npz --from 9999", "holds no events from"),
        ("discs.npz log.npz -o a.xyz", "a.xyz: must end in "),
    ],
)
def test_what_is_wrong_is_said_in_one_line(folder: Path, refused: Refused, command: str, arguments: str, message: str) -> None:
    assert message in refused(command, "-o", OUTPUT[command], *arguments.split())


@pytest.mark.parametrize("command", ["plot", "render"])
def test_a_log_of_another_recording_is_refused(folder: Path, refused: Refused, command: str) -> None:
    log = TrackLog.load_npz("log.npz")
    write_recording(simulate_scene("discs", 6, {"duration_us": 300_000}).recording, "other.npz")
    TrackLog(log.engine, log.records, log.owner[:-1]).save_npz("run/hardware.npz", force=True)
    replace(log, recording="0123456789abcdef").save_npz("marked.npz")
    for arguments, message in (
        ("other.npz log.npz", "log.npz: does not belong to other.npz: owner has "),
        ("other.npz log.npz --from 100", "log.npz: does not belong to other.npz: owner has "),
        ("discs.npz log.npz marked.npz", "marked.npz: does not belong to discs.npz: recording = '0123456789abcdef': "),
        ("run software hardware", f"run/hardware.npz: does not belong to {folder}/discs.npz: owner has "),
    ):
        assert refused(command, *arguments.split(), "-o", OUTPUT[command]).startswith(message)


def test_a_log_may_be_of_the_part_alone(folder: Path, discs: Recording) -> None:
    part = discs.window(100_000, 200_000)
    track(part, PRESETS["plain"]).save_npz("part.npz")
    assert main(["plot", "discs.npz", "part.npz", "--from", "100", "--to", "200", "-o", "a.png"]) == 0
    assert main(["plot", "discs.npz", "part.npz", "--from", "100", "--to", "201", "-o", "b.png"]) == 2


def test_a_run_whose_recording_has_changed_is_refused(folder: Path, refused: Refused) -> None:
    write_recording(simulate_scene("discs", 6, {"duration_us": 100_000}).recording, "discs.npz", force=True)
    assert "which has changed since" in refused("plot", "run", "-o", "a.png")

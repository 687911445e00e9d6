# SPDX-License-Identifier: Apache-2.0
"""`evcot waves` and `evcot assert` as a user meets them: a run looked at again, around a moment, and asked."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import evcot_cosim.rtl.build
from evcot.tracks.log import Kind, TrackLog
from evcot_cosim.cli import main
from evcot_cosim.waves import Wave

from ..conftest import Refused

Capture = pytest.CaptureFixture[str]
RUN = "build/cosim/boxes"
SCENE = ("boxes", "--preset", "davis346", "--to", "500", "--stalls", "4")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a run of half a second of the box experiment, with stalls; without motion, since clusters merge then."""
    folder = tmp_path_factory.mktemp("runs")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("EVCOT_CACHE", str(evcot_cosim.rtl.build.cache_dir()))
        patch.chdir(folder)
        assert main(["cosim", *SCENE, "-q"]) == 0
    return folder


@pytest.fixture(autouse=True)
def inside(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("EVCOT_CACHE", str(evcot_cosim.rtl.build.cache_dir()))
    monkeypatch.chdir(folder)


def description(folder: str) -> str:
    """What a run was made of: run.toml without the list of the folder's files."""
    return Path(folder, "run.toml").read_text().partition("\n[made]")[0]


def test_a_run_repeats_from_its_own_description(capsys: Capture) -> None:
    assert main(["cosim", "--config", f"{RUN}/run.toml", "-q", "--no-waves", "-o", "again"]) == 0
    for name in ("hardware.npz", "model.npz", "software.npz"):
        assert Path("again", name).read_bytes() == Path(RUN, name).read_bytes(), name
    # What was seen is said where it was estimated; the repetition estimates nothing.
    seen = [line for line in description(RUN).splitlines() if not line.startswith("# auto: ")]
    assert description("again").splitlines() == seen
    assert json.loads(Path("again/summary.json").read_text())["seed"] == 4


def test_a_description_is_printed_without_a_run(capsys: Capture) -> None:
    assert main(["cosim", *SCENE, "--print-config"]) == 0
    assert capsys.readouterr().out == description(RUN)


def test_the_surroundings_of_a_merge_with_markers_where_it_is_caused_and_told(capsys: Capture) -> None:
    merge = TrackLog.load_npz(f"{RUN}/hardware.npz").of_kind(Kind.MERGED)[1]
    track_id = merge["track_id"]
    assert main(["waves", RUN, "--around", f"merge:{track_id}", "--reach", "50", "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["folder"] == f"build/waves/boxes-merge-{track_id}"
    assert set(result["files"]) >= {"waves.vcd", "waves.gtkw"}
    assert (result["first_event"], result["last_event"]) == (merge["event_index"] - 50, merge["event_index"] + 50)

    view = (Path(result["folder"]) / "waves.gtkw").read_text().splitlines()
    primary, taken, record = map(int, next(line for line in view if line.startswith("*")).split()[1:])
    assert [line for line in view if line.startswith("[markername]")] == [
        "[markername] Aevent",
        f"[markername] Bmerge {track_id}",
    ]
    assert primary == record > taken
    s = Wave.open(Path(result["folder"]) / "waves.vcd").sampled("TOP.clk")
    at = {int(time): i for i, time in enumerate(s.times)}
    handed = s["TOP.m_cm_valid"] & s["TOP.m_cm_ready"]
    assert handed.true[at[record]]
    assert s["TOP.m_cm_kind"].values[at[record]] == Kind.MERGED
    assert s["TOP.m_cm_id"].values[at[record]] == merge["track_id"]
    assert s["TOP.m_cm_seq"].values[at[record]] == merge["event_index"]
    assert (s["TOP.s_valid"] & s["TOP.s_ready"] & s["TOP.s_event"]).true[at[taken]]
    events = np.cumsum((s["TOP.s_valid"] & s["TOP.s_ready"] & s["TOP.s_event"]).true)
    assert abs(int(events[at[taken]]) - 51) <= 2  # the window begins with the token before its first event


@pytest.mark.parametrize("moment", ["birth", "move:1", "time:12.5", "event:77"])
def test_any_moment_of_a_run_or_of_a_scene(moment: str, capsys: Capture) -> None:
    assert main(["waves", RUN, "--around", moment, "--reach", "5"]) == 0
    name = f"boxes-{moment.replace(':', '-')}"
    assert f"build/waves/{name}/" in capsys.readouterr().out
    assert Path("build/waves", name, "waves.vcd").is_file()


def test_properties_are_put_to_the_waveform_that_a_run_has_left(capsys: Capture) -> None:
    Path("own.py").write_text(
        "from evcot_cosim.waves import *\n"
        "def property_n_ev_is_positive(s): return always(s['TOP.m_cm_n_ev'] > 0, where=s['TOP.m_cm_valid'])\n"
    )
    assert main(["assert", RUN, "own.py"]) == 0
    assert "n_ev_is_positive" in capsys.readouterr().out
    Path("own.py").write_text(
        "from evcot_cosim.waves import *\ndef property_no_merge(s): never(s['TOP.m_cm_valid'] & (s['TOP.m_cm_kind'] == 2))\n"
    )
    assert main(["assert", RUN, "own.py"]) == 1
    printed = capsys.readouterr().out
    assert "BROKEN" in printed
    assert "no_merge: never(" in printed


def test_properties_are_put_to_a_part_that_is_simulated_for_them(capsys: Capture) -> None:
    assert main(["assert", RUN, "--around", "merge", "--reach", "60", "--json"]) == 0
    assert main(["assert", "boxes", "--to", "3", "--json"]) == 0
    for line in capsys.readouterr().out.split("]\n[\n"):
        assert '"holds": true' in line


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("waves", RUN, "--preset", "slow"), "--preset: must not be given with the folder of a run"),
        (("waves", RUN, "--reach", "5"), "--reach: must be given with --around"),
        (("waves", RUN, "--around", "birth", "--to", "5"), "--around: must not be given with --from and --to"),
        (("waves", RUN, "--around", "birth", "--reach", "-1"), "--reach -1: must be from 0 to 1000000 events"),
        (("waves", RUN, "--around", "merge:9999"), "--around merge:9999: must be the id of a track with a merge: "),
        (("assert", RUN, "none.py"), "none.py: cannot be read: No such file or directory"),
        (("assert", "none.vcd"), "none.vcd: cannot be read: No such file or directory"),
        (("assert", RUN, "--clock", "tock"), f"{RUN}/waves.vcd: no signal tock"),
    ],
)
def test_what_cannot_be_done_is_one_line(arguments: tuple[str, ...], message: str, refused: Refused) -> None:
    assert refused(*arguments).startswith(message)


@pytest.mark.skipif(not (shutil.which("gtkwave") and shutil.which("xvfb-run")), reason="needs gtkwave and Xvfb")
def test_gtkwave_opens_the_view_on_its_markers() -> None:
    assert main(["waves", RUN, "--around", "merge", "--reach", "50", "-q"]) == 0
    script = Path("asked.tcl")
    script.write_text(
        'puts "primary [gtkwave::getMarker]"\n'
        'puts "A [gtkwave::getNamedMarker A]"\nputs "B [gtkwave::getNamedMarker B]"\nexit\n'
    )
    view = Path("build/waves/boxes-merge")
    done = subprocess.run(
        ["xvfb-run", "-a", "gtkwave", str(view / "waves.vcd"), str(view / "waves.gtkw"), "-S", str(script)],
        capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
    result = dict(line.split() for line in done.stdout.splitlines() if line.count(" ") == 1)
    times = next(line for line in (view / "waves.gtkw").read_text().splitlines() if line.startswith("*")).split()[1:]
    assert [result.get("primary"), result.get("A"), result.get("B")] == times, done.stdout + done.stderr

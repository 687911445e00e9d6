# SPDX-License-Identifier: Apache-2.0
"""`evcot report`: of a run's folder, of a log, and one line for everything that can be mended."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import pytest

from evcot.events import Recording
from evcot.recordings.files import read_recording, write_recording
from evcot.scenes import simulate_scene
from evcot_cosim.cli import main

from ..conftest import Refused

Capture = pytest.CaptureFixture[str]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of 60 ms of the box experiment; and, of the same recording in a file, a software tracker's log."""
    folder = tmp_path_factory.mktemp("made")
    recording = folder / "b.aedat4"
    assert main(["simulate", "boxes", "--duration", "0.06", "-o", str(recording), "-q"]) == 0
    assert main(["cosim", str(recording), "--no-waves", "-q", "-o", str(folder / "run")]) == 0
    assert main(["track", str(recording), "-o", str(folder / "log.npz"), "-q"]) == 0
    events = read_recording(recording).events
    mirrored = replace(events, x=events.x.max() - events.x)
    write_recording(Recording(mirrored, 346, 260, "other"), folder / "other.npz")  # as many events at the same times
    return folder


def test_a_run_leaves_a_report_that_can_be_made_again(made: Path, home: Path, capsys: Capture) -> None:
    first = (made / "run" / "report.html").read_text()
    assert main(["report", str(made / "run")]) == 0
    assert capsys.readouterr().out.startswith(f"{made / 'run' / 'report.html'}: ")
    assert (made / "run" / "report.html").read_text() == first
    assert "hardware = model" in first
    assert '<a href="hardware.npz" download>' in first
    assert main(["report", str(made / "run"), "-o", "again.html", "-q"]) == 0
    assert "download" not in Path("again.html").read_text().partition("<script")[0], "its files are elsewhere"
    assert "9 objects at" in first  # the truth that stood beside the recording


def test_a_report_of_a_log(made: Path, home: Path, capsys: Capture) -> None:
    command = ["report", str(made / "log.npz"), "--recording", str(made / "b.aedat4"), "-o", "log.html", "--json"]
    assert main(command) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["report"] == "log.html"
    assert found["bytes"] == Path("log.html").stat().st_size
    assert found["events"] == len(simulate_scene("boxes", 1, {"duration_us": 60_000}).recording.events)
    text = Path("log.html").read_text()
    assert "Agreement" not in text.partition("<main>")[2].partition("<script")[0]
    assert "9 objects at" in text


def test_further_engines_stand_beside_hardware_and_software(made: Path, home: Path, capsys: Capture) -> None:
    assert main(["track", str(made / "b.aedat4"), "--engine", "frames", "-o", "k.npz", "-q"]) == 0
    assert main(["report", str(made / "run"), "k.npz", str(made / "log.npz"), "-o", "all.html", "-q"]) == 0
    text = Path("all.html").read_text()
    facts = json.loads(text.partition('id="facts">')[2].partition("</script>")[0])
    assert [side["name"] for side in facts["sides"]] == ["hardware", "software", "frames", "cot_motion", "truth"]
    looks = [side["look"] for side in facts["sides"]]
    assert len(set(looks)) == 5
    for side in facts["sides"][:-1]:
        assert f'<b class="{side["look"]}-name">{side["name"]}</b>: ' in text
    assert main(["report", "k.npz", str(made / "log.npz"), "--recording", str(made / "b.aedat4"), "-o", "logs.html", "-q"]) == 0
    names = json.loads(Path("logs.html").read_text().partition('id="facts">')[2].partition("</script>")[0])["sides"]
    assert [side["name"] for side in names] == ["frames", "cot_motion", "truth"]


def test_two_runs_are_compared(made: Path, home: Path, capsys: Capture) -> None:
    command = ["cosim", str(made / "b.aedat4"), "--preset", "slow", "--no-waves", "-q", "-o"]
    assert main([*command, "slow"]) == 0
    assert main([*command, "more", "--activity", "5"]) == 0
    assert main(["report", "slow", "more", "-o", "changed.html", "-q"]) == 0
    text = Path("changed.html").read_text()
    facts = json.loads(text.partition('id="facts">')[2].partition("</script>")[0])
    assert [side["name"] for side in facts["sides"]][:2] == ["a", "b"]
    section = text.partition('id="panel-differences"')[2].partition("</section>")[0]
    changed = re.findall(
        r'<th scope="row">([^<]*)</th><td class="words a-name">([^<]*)</td><td class="words b-name">([^<]*)</td>', section
    )
    assert ("filters.activity_us", "0", "5000") in changed
    assert [row for row in changed if row[0].startswith("cot.")] == []
    assert "Isolated events filtered out, %" in section
    assert "Objects that only one run has" in section
    assert re.search(r'<strong class="">(A is better|B is better|A and B are as good)</strong>', text)
    assert main(["report", "slow", "slow", "-o", "same.html", "-q"]) == 0
    assert "decided the same in every record" in Path("same.html").read_text()
    assert "The hardware decided alike" not in text


def test_what_is_not_of_one_recording_is_not_compared(made: Path, home: Path, refused: Refused) -> None:
    assert main(["track", str(made / "other.npz"), "-o", "stranger.npz", "-q"]) == 0
    assert "stranger.npz: does not belong to" in refused("report", str(made / "run"), "stranger.npz", "-o", "all.html")
    assert main(["cosim", str(made / "other.npz"), "--preset", "slow", "--no-waves", "-q", "-o", "elsewhere"]) == 0
    for arguments, message in (
        (
            ["elsewhere", "-o", "all.html"],
            f"{made / 'run'} was made of b, elsewhere of other: both runs must be of the same events",
        ),
        (["elsewhere"], "-o: must be given to say where the comparison"),
        ([str(made / "log.npz")], "-o: must be given with further logs"),
        (["elsewhere", "elsewhere"], "RUN: must be one folder"),
    ):
        assert message in refused("report", str(made / "run"), *arguments)


def test_a_truth_may_be_given(made: Path, home: Path) -> None:
    lines = (made / "b.truth.csv").read_text().splitlines()
    Path("one.csv").write_text("\n".join([lines[0], *(line for line in lines[1:] if line.split(",")[1] == "3")]) + "\n")
    assert main(["report", str(made / "run"), "--truth", "one.csv", "--rule", "scene", "-o", "one.html", "-q"]) == 0
    assert "1 object at" in Path("one.html").read_text()


def test_a_truth_of_another_time_is_refused(made: Path, home: Path, refused: Refused) -> None:
    head, *lines = (made / "b.truth.csv").read_text().splitlines()
    late = [",".join([str(int(line.split(",")[0]) + 10**9), *line.split(",")[1:]]) for line in lines]
    Path("late.csv").write_text("\n".join([head, *late]) + "\n")
    said = refused("report", str(made / "run"), "--truth", "late.csv", "--rule", "scene", "-o", "late.html")
    assert said == "late.csv: has no instant within the time of b: must be the truth of this recording"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["nowhere"], "nowhere: cannot be read: No such file or directory"),
        (["nowhere", "--recording", "{made}/b.aedat4"], "nowhere: cannot be read: No such file or directory"),
        (["{made}/log.npz"], "{made}/log.npz: a log does not hold the events: must be given with --recording FILE"),
        (["{made}/log.npz", "--recording", "{made}/b.aedat4", "--to", "20"], "{made}/log.npz: does not belong to "),
        (["{made}/log.npz", "--recording", "{made}/other.npz"], "{made}/log.npz: does not belong to {made}/other.npz: rec"),
        (["{made}/run", "--recording", "{made}/other.npz"], "{made}/run/hardware.npz: does not belong to {made}/other.npz: "),
        (["{made}/run", "--rule", "scene"], "--rule: must be given with --truth"),
        (["{made}/run", "--truth", "nowhere.csv"], "nowhere.csv: cannot be read: No such file or directory"),
        (["."], "summary.json: cannot be read: No such file or directory"),
        (["{made}/run", "-o", "nowhere/x.html"], "-o nowhere/x.html: cannot be written: No such file or directory"),
    ],
)  # fmt: skip
def test_what_can_be_mended(made: Path, home: Path, arguments: list[str], message: str, refused: Refused) -> None:
    assert refused("report", *(argument.format(made=made) for argument in arguments)).startswith(message.format(made=made))


def test_a_truth_beside_a_recording_that_cannot_be_used_is_warned_of(made: Path, home: Path, capsys: Capture) -> None:
    Path("b.aedat4").write_bytes((made / "b.aedat4").read_bytes())
    Path("b.truth.csv").write_text("what,is,this\n1,2,3\n")
    assert main(["report", str(made / "log.npz"), "--recording", "b.aedat4", "-o", "b.html", "-q"]) == 0
    assert "warning: the report goes without the truth: b.truth.csv: " in capsys.readouterr().err
    assert "No truth: HOTA not known" in Path("b.html").read_text()


@pytest.mark.parametrize(
    ("summary", "message"),
    [
        *(
            (
                json.dumps({"parts": [{"page": "part-00000.html"}, {"page": page}]}),
                "parts: each must have a page with a name such as",
            )
            for page in ("javascript:alert(1)", "../part-00000.html", None)
        ),
        ("{", "is not JSON"),
        ("[]", "must hold an object"),
    ],
)
def test_a_summary_that_is_none(summary: str, message: str, home: Path, refused: Refused) -> None:
    Path("summary.json").write_text(summary)
    assert f"summary.json: {message}" in refused("report", ".")

# SPDX-License-Identifier: Apache-2.0
"""`import evcot_cosim`: the co-simulation as a function does and writes what `evcot cosim` does and writes."""

from __future__ import annotations

import re
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import evcot
import evcot_cosim
from evcot.errors import ConfigError
from evcot.page import Page
from evcot_cosim.cli import main
from support.logs import log_of

pytestmark = pytest.mark.usefixtures("home")


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


@pytest.mark.parametrize("options", [{}, {"hardware": "cot_chain"}, {"preset": "discs", "slots": 3, "stall_seed": 5}])
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


@pytest.fixture(scope="module")
def notebook_recording() -> evcot.Recording:
    return evcot.simulate("discs", 4, duration_us=300_000, count=2).recording


@pytest.fixture(scope="module")
def log(notebook_recording: evcot.Recording) -> evcot.TrackLog:
    return evcot.track(notebook_recording, "rct", "discs")


def sides_of(page: Page) -> list[str]:
    """The name of each side of a page."""
    return re.findall(r'"name":"(\w+)","label":"\w+","short":', page.text)


def test_a_recording_is_shown_with_its_logs(notebook_recording: evcot.Recording, log: evcot.TrackLog) -> None:
    assert sides_of(notebook_recording.show()) == []
    assert sides_of(notebook_recording.show(log)) == ["software"]
    assert sides_of(notebook_recording.show(log, log)) == ["rct", "rct_2"]


def test_a_page_is_small_unless_more_events_are_wanted(notebook_recording: evcot.Recording) -> None:
    small, all_of_it = (notebook_recording.show(events_max=most) for most in (1_000, 50_000))
    assert len(notebook_recording.events) > 10_000
    assert len(small.text) < len(all_of_it.text) - 5 * len(notebook_recording.events) // 2
    assert notebook_recording._repr_html_() == notebook_recording.show()._repr_html_()
    assert 'style="width: 100%; height: 300px;' in notebook_recording.show(height_px=300)._repr_html_()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"events_max": 0}, "events_max = 0: must be an integer from 1000 to 2000000 (events in the page)"),
        ({"height_px": 2.5}, "height_px = 2.5: must be an integer from 100 to 10000 (height of the frame)"),
    ],
)
def test_a_value_outside_its_range_is_refused(
    notebook_recording: evcot.Recording, options: dict[str, int], message: str
) -> None:
    with pytest.raises(ConfigError) as error:
        notebook_recording.show(**options)
    assert str(error.value) == message


def test_what_is_no_log_of_the_recording_is_refused(notebook_recording: evcot.Recording) -> None:
    with pytest.raises(ConfigError, match=r"show: a log of type str: must be a TrackLog"):
        notebook_recording.show("log.npz")
    other = evcot.TrackLog("rct", log_of([]).records, np.zeros(len(notebook_recording.events) + 1, np.int16))
    with pytest.raises(ConfigError, match=r"must be of the same recording"):
        notebook_recording.show(other)


def test_a_run_is_shown_with_hardware_and_software(notebook_recording: evcot.Recording) -> None:
    run = evcot_cosim.cosim(notebook_recording.window(0, 50_000))
    assert sides_of(run.show()) == ["hardware", "software"]
    assert run._repr_html_().startswith("<iframe ")


def test_a_browser_draws_the_frame(
    browser: Any, notebook_recording: evcot.Recording, log: evcot.TrackLog, tmp_path: Path
) -> None:
    notebook = tmp_path / "notebook.html"
    notebook.write_text(f"<!doctype html><body>{notebook_recording.show(log)._repr_html_()}</body>", encoding="utf-8")
    view = browser.new_page()
    errors: list[str] = []
    view.on("pageerror", lambda error: errors.append(str(error)))
    view.goto(notebook.as_uri())
    frame = view.frames[1]
    frame.wait_for_function(PAINTED)
    assert "discs" in frame.inner_text("body")
    assert errors == []
    view.close()


PAINTED = """() => [...document.querySelectorAll("canvas")].some((canvas) => {
  const context = canvas.getContext("2d");
  return context && new Set(context.getImageData(0, 0, canvas.width, canvas.height).data).size > 2;
})"""

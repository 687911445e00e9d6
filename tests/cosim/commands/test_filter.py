# SPDX-License-Identifier: Apache-2.0
"""`evcot filter`: a recording in, a recording out, and a table of what each filter dropped."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from evcot.events import Events, Recording
from evcot.filters.config import FilterConfig
from evcot.filters.hot_pixels import save_hot_pixels
from evcot.filters.run import apply
from evcot.recordings.files import read_recording, write_recording
from evcot_cosim.cli import main

from ..conftest import Refused

HOT = (20, 7)


@pytest.fixture
def source(home: Path) -> Path:
    """Noise on a 64x48 sensor for a second, and a hot pixel; alone in a folder."""
    random = np.random.default_rng(2)
    count = 20_000
    x, y = random.integers(0, 64, count), random.integers(0, 48, count)
    x[::20], y[::20] = HOT
    events = Events(
        np.sort(random.integers(0, 1_000_000, count)),
        x.astype(np.uint16),
        y.astype(np.uint16),
        random.integers(0, 2, count).astype(np.uint8),
    )
    write_recording(Recording(events, 64, 48, "source"), home / "source.npz")
    return home / "source.npz"


def filtered(source: Path, *options: str) -> Events:
    assert main(["filter", str(source), "out.npz", "-q", "--force", *options]) == 0
    return read_recording("out.npz").events


@pytest.mark.parametrize(
    ("options", "config"),
    [
        ("--region 3,4,50,40", FilterConfig(region=(3, 4, 50, 40))),
        ("--polarity off", FilterConfig(polarity="off")),
        ("--refractory 2.5", FilterConfig(refractory_us=2_500)),
        ("--activity 3", FilterConfig(activity_us=3_000)),
        ("--activity 9 --activity-support 2", FilterConfig(activity_us=9_000, activity_support=2)),
        ("--recent 3", FilterConfig(recent_us=3_000)),
        (
            "--recent 3 --recent-radius 9 --recent-support 4 --recent-depth 64",
            FilterConfig(recent_us=3_000, recent_radius=9, recent_support=4, recent_depth=64),
        ),
        ("--decay-tau 4", FilterConfig(decay_tau_us=4_000)),
        (
            "--decay-tau 4 --decay-epsilon 0.3 --decay-support 0.7",
            FilterConfig(decay_tau_us=4_000, decay_epsilon=0.3, decay_support=0.7),
        ),
        ("--activity 3 --refractory 2 --cell 2", FilterConfig(activity_us=3_000, refractory_us=2_000, cell_px=2)),
        ("--decay-tau 4 --cell 4", FilterConfig(decay_tau_us=4_000, cell_px=4)),
        ("--rowcol 3", FilterConfig(rowcol_us=3_000)),
        (
            "--rowcol 3 --rowcol-radius 5 --rowcol-support 2",
            FilterConfig(rowcol_us=3_000, rowcol_radius=5, rowcol_support=2),
        ),
        ("--polarity on --activity 3", FilterConfig(polarity="on", activity_us=3_000)),
    ],
)
def test_options_are_the_configurations_fields(source: Path, options: str, config: FilterConfig) -> None:
    got, (wanted, keep) = filtered(source, *options.split()), apply(read_recording(source), config)
    assert 0 < len(got) < len(keep)
    for name in ("t_us", "x", "y", "p"):
        np.testing.assert_array_equal(getattr(got, name), getattr(wanted.events, name))


def test_an_unknown_suffix_is_refused_before_anything_is_done(source: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["filter", str(source), "out.xyz", "--learn-hot-pixels", "--save-hot-pixels", "hot.txt"]) == 2
    assert "out.xyz: suffix '.xyz': must be one of " in capsys.readouterr().err
    assert not Path("hot.txt").exists()


def test_the_window_and_the_sensor_are_chosen_as_elsewhere(source: Path) -> None:
    events = read_recording(source).events
    from_us = events.t_us[0] + 200_000
    part = events[int(np.searchsorted(events.t_us, from_us)) : int(np.searchsorted(events.t_us, from_us + 300_000))]
    got = filtered(source, "--from", "200", "--to", "500", "--sensor", "70x50", "--region", "0,0,69,49")
    np.testing.assert_array_equal(got.t_us, part.t_us)
    assert (read_recording("out.npz").width, read_recording("out.npz").height) == (70, 50)


def test_the_table_says_what_each_filter_dropped(source: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["filter", str(source), "out.npz", "--polarity", "on", "--region", "0,0,31,47"]) == 0
    lines = capsys.readouterr().out.splitlines()
    events = read_recording(source).events
    left = np.count_nonzero(events.x <= 31)
    kept = len(read_recording("out.npz").events)
    assert [line.split() for line in lines] == [
        ["filter", "events", "in", "dropped", "share"],
        ["region", "20,000", f"{20_000 - left:,}", f"{1 - left / 20_000:.1%}"],
        ["polarity", f"{left:,}", f"{left - kept:,}", f"{1 - kept / left:.1%}"],
        ["all", "20,000", f"{20_000 - kept:,}", f"{1 - kept / 20_000:.1%}"],
    ]


def test_and_json_says_the_same_with_the_configuration(source: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["filter", str(source), "out.npz", "--polarity", "on", "--json"]) == 0
    summary = json.loads(capsys.readouterr().out)
    kept = len(read_recording("out.npz").events)
    assert (summary["seen"], summary["kept"]) == (20_000, kept)
    assert summary["filters"] == [{"filter": "polarity", "seen": 20_000, "dropped": 20_000 - kept}]
    assert FilterConfig(**summary["config"]) == FilterConfig(polarity="on")


class TestHotPixels:
    def test_they_are_learned_silenced_and_listed(self, source: Path, capsys: pytest.CaptureFixture[str]) -> None:
        got = filtered(source, "--learn-hot-pixels", "--save-hot-pixels", "hot.txt")
        assert not np.any((got.x == HOT[0]) & (got.y == HOT[1]))
        assert 18_900 < len(got) < 19_000
        assert Path("hot.txt").read_text() == "# hot pixels of a 64x48 sensor\n20 7\n"
        np.testing.assert_array_equal(filtered(source, "--learn-hot-pixels").t_us, got.t_us)
        np.testing.assert_array_equal(filtered(source, "--hot-pixels", "hot.txt").t_us, got.t_us)

    def test_a_list_for_another_sensor_is_refused(self, source: Path, refused: Refused) -> None:
        save_hot_pixels("hot.txt", [HOT], (346, 260))
        message = refused("filter", str(source), "out.npz", "--hot-pixels", "hot.txt")
        assert message == "hot.txt: line 1: is for a 346x260 sensor: must be for 64x48"


class TestConfig:
    def test_options_come_on_top_of_the_file(self, source: Path) -> None:
        Path("run.toml").write_text("[filters]\npolarity = 'on'\nactivity_us = 3_000\nhot_pixels = [[20, 7]]\n")
        got = filtered(source, "--config", "run.toml", "--activity", "0", "--region", "0,0,31,47")
        config = FilterConfig(polarity="on", hot_pixels=(HOT,), region=(0, 0, 31, 47))
        np.testing.assert_array_equal(got.t_us, apply(read_recording(source), config)[0].events.t_us)

    def test_the_files_tick_counts(self, source: Path) -> None:
        Path("run.toml").write_text("[cot]\ntick_us = 1000\n[filters]\nrefractory_us = 3_000\n")
        got = filtered(source, "--config", "run.toml")
        wanted = apply(read_recording(source), FilterConfig(refractory_us=3_000), tick_us=1_000)[0].events
        np.testing.assert_array_equal(got.t_us, wanted.t_us)
        assert len(got) != len(filtered(source, "--refractory", "3"))

    @pytest.mark.parametrize(
        ("options", "message"),
        [
            ("", "no filter is on: see `evcot filter --help`"),
            ("--activity 0", "no filter is on: see `evcot filter --help`"),
            ("--activity -1", "filters.activity_us = -1000: must be from 0 to 1000000000 (oldest neighbour that supports "),
            ("--activity 600", "filters.activity_us = 600000: must be from 1 to 524287, 1 to 524287 ticks of 1 us"),
            ("--activity 3 --activity-support 9", "filters.activity_support = 9: must be from 1 to 8 (neighbours "),
            ("--region 5,0,4,9", "filters.region = [5, 0, 4, 9]: must have x0 <= x1 and y0 <= y1"),
            ("--region 5,0,9", "filters.region = (5, 0, 9): must be [x0, y0, x1, y1], each from 0 to 65535"),
            ("--hot-pixels absent.txt", "absent.txt: cannot be read: No such file or directory"),
            ("--config absent.toml", "absent.toml: cannot be read: No such file or directory"),
        ],
    )
    def test_what_is_wrong_is_said_in_one_line(self, source: Path, refused: Refused, options: str, message: str) -> None:
        assert refused("filter", str(source), "out.npz", *options.split()).startswith(message)

    @pytest.mark.parametrize("text", ["x", "inf", "nan", "0.0004"])
    def test_milliseconds_that_are_none(self, source: Path, capsys: pytest.CaptureFixture[str], text: str) -> None:
        with pytest.raises(SystemExit, match="2"):
            main(["filter", str(source), "out.npz", "--activity", text])
        assert f"argument --activity: invalid milliseconds value: '{text}'" in capsys.readouterr().err

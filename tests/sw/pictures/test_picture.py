# SPDX-License-Identifier: Apache-2.0
"""Pictures of runs; figures and pictures of a log in a notebook."""

from __future__ import annotations

import base64
import io
import re
import struct
import subprocess
import sys
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from matplotlib.collections import LineCollection, PatchCollection
from matplotlib.figure import Figure
from matplotlib.text import Text
from PIL import Image

from evcot.errors import ConfigError, OutputError
from evcot.events import Events, Recording
from evcot.pictures.panels import END_MARKERS, TimeAxis, draw_alive, draw_merges
from evcot.pictures.picture import SIZE_PX, draw
from evcot.tracks.log import Kind, TrackLog
from evcot.tracks.timeline import OPEN
from support import logs
from support.refusals import refused

EMPTY = TrackLog.empty("rct")
log_of = partial(logs.log_of, engine="cot_array")


def recording_of(n: int, width: int = 120, height: int = 80, duration_us: int = 100_000) -> Recording:
    """ON events in the left half of the sensor, OFF events in the right half."""
    rng = np.random.default_rng(1)
    t_us = np.sort(rng.integers(0, duration_us, n))
    x = rng.integers(0, width, n).astype(np.uint16)
    y = rng.integers(0, height, n).astype(np.uint16)
    return Recording(Events(t_us, x, y, (x < width // 2).astype(np.uint8)), width, height, "halves")


TWO_MEET = log_of(
    [
        (1_000, Kind.BORN, 0, 20.0, 20.0),
        (2_000, Kind.BORN, 1, 90.0, 20.0),
        (50_000, Kind.MOVED, 0, 40.0, 20.0),
        (60_000, Kind.MERGED, 1, 60.0, 20.0, 0),
        (60_000, Kind.MOVED, 0, 50.0, 20.0),
        (90_000, Kind.LOST, 0, 50.0, 20.0),
    ]
)


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> list[Figure]:
    """The figures that were saved."""
    figures: list[Figure] = []
    save = Figure.savefig

    def keep(self: Figure, *args: object, **kwargs: object) -> None:
        figures.append(self)
        save(self, *args, **kwargs)  # type: ignore[arg-type]

    monkeypatch.setattr(Figure, "savefig", keep)
    return figures


def texts(figure: Figure) -> list[str]:
    """Everything that is written in a figure."""
    return [text.get_text() for text in figure.findobj(Text) if isinstance(text, Text) and text.get_text()]


def png_size(path: Path) -> tuple[int, int]:
    """Width and height from a PNG's header; a file without its end is not whole."""
    content = path.read_bytes()
    assert content.startswith(b"\x89PNG\r\n\x1a\n")
    assert content.endswith(b"IEND\xaeB`\x82")
    width, height = struct.unpack(">II", content[16:24])
    return width, height


@pytest.mark.parametrize(("width", "height"), [(120, 80), (128, 128), (64, 640), (1280, 720)])
def test_every_picture_is_a_png_of_the_same_size(tmp_path: Path, width: int, height: int) -> None:
    draw(recording_of(2_000, width, height), TWO_MEET, TWO_MEET, tmp_path / "run.png", "A run")
    assert png_size(tmp_path / "run.png") == SIZE_PX
    assert [path.name for path in tmp_path.iterdir()] == ["run.png"]


def test_the_scene_has_its_origin_top_left_and_square_pixels(tmp_path: Path, drawn: list[Figure]) -> None:
    draw(recording_of(5_000), TWO_MEET, EMPTY, tmp_path / "run.png", "A run")
    scene = drawn[0].axes[0]
    assert (scene.get_xlim(), scene.get_ylim()) == ((-0.5, 119.5), (79.5, -0.5))
    assert scene.get_aspect() == 1.0
    assert (scene.get_xlabel(), scene.get_ylabel()) == ("x (px)", "y (px)")
    image = np.asarray(scene.images[0].get_array())
    assert image.shape == (80, 120, 3)
    on, off = image[:, :60].mean(axis=(0, 1)), image[:, 60:].mean(axis=(0, 1))
    assert on[1] > on[0]  # green
    assert off[1] < off[0]  # purple


def test_an_event_colours_its_own_pixel(tmp_path: Path, drawn: list[Figure]) -> None:
    one = Recording(
        Events(np.array([5], np.int64), np.array([7], np.uint16), np.array([3], np.uint16), np.array([1], np.uint8)), 20, 10
    )
    draw(one, EMPTY, EMPTY, tmp_path / "run.png", "One event")
    image = np.asarray(drawn[0].axes[0].images[0].get_array())
    assert np.argwhere((image < 1).any(axis=2)).tolist() == [[3, 7]]


def test_paths_windows_counts_and_merges_are_those_of_the_log(tmp_path: Path, drawn: list[Figure]) -> None:
    draw(recording_of(5_000), TWO_MEET, EMPTY, tmp_path / "run.png", "A run")
    scene, count, lives, *moments = drawn[0].axes
    paths = [c for c in scene.collections if isinstance(c, LineCollection)][1]
    ends = [(tuple(path[0]), tuple(path[-1])) for path in paths.get_segments()]
    assert ends == [((20.0, 20.0), (50.0, 20.0)), ((90.0, 20.0), (90.0, 20.0))]
    assert not [c for c in scene.collections if isinstance(c, PatchCollection)]
    boxes = [next(c for c in ax.collections if isinstance(c, PatchCollection)).get_paths() for ax in moments]
    corners = [sorted(tuple(np.asarray(path.vertices)[0].tolist()) for path in paths) for paths in boxes]
    both, later = [(10.0, 14.0), (80.0, 14.0)], [(30.0, 14.0), (80.0, 14.0)]  # boxes of 20 x 12 px, a moment's alone
    assert corners == [both, both, later, [(40.0, 14.0)]]
    assert max(np.asarray(count.lines[0].get_ydata())) == 2
    joins = [c.get_segments() for c in lives.collections if isinstance(c, LineCollection)][-1]
    ((top, bottom),) = joins
    assert top[0] == bottom[0] == pytest.approx(60, abs=0.05)
    assert abs(top[1] - bottom[1]) == 1


def test_a_moment_has_the_events_just_before_it_alone(tmp_path: Path, drawn: list[Figure]) -> None:
    recording = recording_of(5_000)
    draw(recording, TWO_MEET, TWO_MEET, tmp_path / "run.png", "A run")
    _, _, _, *moments = drawn[0].axes
    assert [ax.get_title(loc="left") for ax in moments] == ["1", "2", "3", "4"]
    coloured = [(np.asarray(ax.images[0].get_array()) < 1).any(axis=2).sum() for ax in moments]
    assert all(0 < count < 60 for count in coloured)  # 0.4 % of 5,000 events
    everything = np.asarray(drawn[0].axes[0].images[0].get_array())
    assert (everything < 1).any(axis=2).sum() > 3_000


def test_the_labels_name_engines_units_and_title(tmp_path: Path, drawn: list[Figure]) -> None:
    draw(recording_of(5_000), TWO_MEET, EMPTY, tmp_path / "run.png", "A run")
    written = texts(drawn[0])
    for text in ("A run", "hardware (cot_array)", "software (rct)", "clusters alive", "time since the first event (ms)"):
        assert text in written
    draw(recording_of(5_000, duration_us=10_000_000), TWO_MEET, EMPTY, tmp_path / "run.png", "Longer", force=True)
    assert "time since the first event (s)" in texts(drawn[1])


def test_a_tracker_that_saw_nothing_is_said_to_have(tmp_path: Path, drawn: list[Figure]) -> None:
    path = tmp_path / "run.png"
    draw(recording_of(5_000), TWO_MEET, EMPTY, path, "Half")
    draw(recording_of(5_000), EMPTY, EMPTY, path, "None", force=True)
    draw(Recording(Events.empty(), 32, 32), EMPTY, EMPTY, path, "No events", force=True)
    draw(recording_of(5_000), TWO_MEET, TWO_MEET, path, "Both", force=True)
    assert [texts(figure).count("no cluster became visible") for figure in drawn] == [1, 2, 2, 0]
    assert "halves: 5,000 events in 0.1 s   ·   120 × 80 px   ·   no cluster became visible" in texts(drawn[1])


def test_of_very_many_tracks_the_longest_are_drawn_and_the_picture_says_so(tmp_path: Path, drawn: list[Figure]) -> None:
    births = [(100 * i, Kind.BORN, i, 10.0 + i % 100, 40.0) for i in range(300)]
    ends = [(60_000 + 10 * i, Kind.LOST, i, 10.0 + i % 100, 40.0) for i in range(300)]
    draw(recording_of(5_000), log_of([*births, *ends]), TWO_MEET, tmp_path / "run.png", "Many")
    assert any("the 40 longest of 300 hardware tracks drawn" in text for text in texts(drawn[0]))
    bars = next(c for c in drawn[0].axes[2].collections if isinstance(c, LineCollection))
    assert len(bars.get_segments()) == 40
    assert png_size(tmp_path / "run.png") == SIZE_PX


def test_a_picture_that_cannot_be_written_leaves_nothing(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"run\.png: cannot be written: No such file or directory$"):
        draw(recording_of(10), EMPTY, EMPTY, tmp_path / "absent" / "run.png", "A run")
    assert list(tmp_path.iterdir()) == []


def test_drawing_keeps_away_from_pyplot() -> None:
    check = "import sys, evcot.pictures.picture; sys.exit('matplotlib.pyplot' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", check], check=False).returncode == 0


@pytest.mark.parametrize(("length_us", "unit", "position"), [(1_999_999, "ms", 500.0), (2_000_000, "s", 0.5)])
def test_two_seconds_and_more_are_in_seconds(length_us: int, unit: str, position: float) -> None:
    axis = TimeAxis(1_000, length_us)
    assert axis.unit == unit
    assert axis(np.array([1_000, 501_000])).tolist() == [0.0, position]
    assert set(END_MARKERS) == {Kind.LOST, Kind.MERGED, OPEN}
    assert len(set(END_MARKERS.values())) == 3


def test_the_tallest_line_fits() -> None:
    ax = Figure().add_subplot()
    draw_alive(ax, np.arange(3.0), [(np.array([0, 2, 1]), {"color": "k"}), (np.array([5, 0, 0]), {"color": "r"})], "alive")
    assert ax.get_ylim() == (0, pytest.approx(5.6))
    assert ax.get_ylabel() == "alive"
    assert [line.get_ydata().tolist() for line in ax.get_lines()] == [[0, 2, 1], [5, 0, 0]]  # type: ignore[union-attr]


def test_a_merge_is_a_line_to_its_survivor() -> None:
    ax = Figure().add_subplot()
    draw_merges(ax, [((3.0, 0.0), (3.0, 4.0))], 0.5)
    (lines,) = ax.collections
    assert [path.vertices.tolist() for path in lines.get_paths()] == [[[3.0, 0.0], [3.0, 4.0]]]


LOG = logs.log_of([(10, Kind.BORN, 0, 5.0, 6.0), (30, Kind.MOVED, 0, 40.0, 20.0), (90, Kind.LOST, 0, 40.0, 20.0)])


def test_without_a_recording_the_axes_hold_the_tracks() -> None:
    (axes,) = LOG.plot().axes
    assert axes.get_xlim() == (-0.5, 50.5)  # 40 + half the width of 20, one more for the pixel at 0
    assert axes.get_ylim() == (26.5, -0.5)
    path = axes.lines[-1].get_xydata()
    assert path[0].tolist() == [5.0, 6.0]
    assert path[-1].tolist() == [40.0, 20.0]


def test_a_recording_gives_events_and_the_size_of_the_sensor() -> None:
    events = Events(np.array([10, 20]), *np.array([[3, 3], [4, 4]], np.uint16), np.ones(2, np.uint8))
    recording = Recording(events, 64, 48)
    figure = LOG.plot(recording, ("tracks", "alive"))
    assert len(figure.axes) == 2
    assert figure.axes[0].get_xlim() == (-0.5, 63.5)
    grey = np.asarray(figure.axes[0].images[0].get_array())
    assert grey.shape == (48, 64)
    assert np.argwhere(grey < 1).tolist() == [[4, 3]]


def test_a_recording_with_fewer_events_than_the_log_is_refused() -> None:
    log = TrackLog("rct", LOG.records, np.zeros(3, np.int16))
    with refused(ConfigError, "plot: drive has 0 events: must be the recording of the log, of 3 events at least"):
        log.plot(Recording(Events.empty(), 64, 48, "drive"))


def test_a_notebook_shows_a_figure_as_png_and_a_panel_that_is_none_is_refused() -> None:
    assert Image.open(io.BytesIO(LOG.plot()._repr_png_())).format == "PNG"  # type: ignore[attr-defined]
    with pytest.raises(ConfigError, match="tracks, xy, alive, lifetimes"):
        LOG.plot(panels=("track",))


@pytest.mark.parametrize("log", [LOG, TrackLog.empty("rct")], ids=["tracks", "no tracks"])
def test_a_notebook_shows_a_line_and_a_picture(log: TrackLog) -> None:
    shown = log._repr_html_()
    assert f"&lt;TrackLog {log.engine}: {len(log.tracks)} tracks" in shown
    (picture,) = re.findall(r'src="data:image/png;base64,([^"]+)"', shown)
    assert Image.open(io.BytesIO(base64.b64decode(picture))).width == 649


def test_a_track_far_outside_does_not_take_memory_without_end() -> None:
    far = logs.log_of([(10, Kind.BORN, 0, 1e9, 6.0)])
    (axes,) = far.plot().axes
    assert (axes.get_xlim(), axes.get_ylim()) == ((-0.5, 4095.5), (1023.5, -0.5))

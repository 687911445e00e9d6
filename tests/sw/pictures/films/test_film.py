# SPDX-License-Identifier: Apache-2.0
"""Films: each picture shows the events up to its time and the tracks of that moment."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image, ImageSequence

from evcot.errors import ConfigError
from evcot.events import Events
from evcot.pictures.films import Look, render, side_of
from evcot.pictures.films.draw import EVENTS, GROUND, SIDES, Surface, compose, palette
from evcot.pictures.films.film import GIF_PIXELS_MAX, Follower, GifEncoder, picture_times
from evcot.tracks.log import TRACK, Kind, TrackLog
from support.logs import verdicts_of

SENSOR = (32, 20)
WINDOW = (1_000_000, 1_900_000)
BOX = SIDES[0]


def log() -> TrackLog:
    """One track, born at 1.2 s, that moves from (8, 10) to (24, 10) at 1.5 s and is lost at 1.8 s."""
    records = np.zeros(3, TRACK)
    records["t_us"], records["event_index"] = (1_200_000, 1_500_000, 1_800_000), (0, 1, 2)
    records["kind"], records["track_id"] = (Kind.BORN, Kind.MOVED, Kind.LOST), 4
    records["x"], records["y"], records["radius"], records["other_id"] = (8, 24, 24), 10, 3, -1
    records["width"] = records["height"] = 7
    return TrackLog("rct", records, np.zeros(2, np.int16))


def blinking() -> Events:
    """ON events at (2, 17) and OFF events at (29, 17), every millisecond up to 1.5 s, then none until the last one."""
    t_us = np.append(np.repeat(np.arange(1_000_000, 1_500_001, 1_000), 2), WINDOW[1])
    on = np.append(np.tile([1, 0], len(t_us) // 2), 1).astype(np.uint8)
    return Events(t_us, np.where(on == 1, 2, 29).astype(np.uint16), np.full(len(t_us), 17, np.uint16), on)


def film(path: Path, look: Look | None = None, events: Events | None = None) -> int:
    events = events or blinking()
    blocks = [events[begin : begin + 37] for begin in range(0, len(events), 37)]
    return render(blocks, SENSOR, [side_of(0, "a", log())], path, WINDOW, look or Look(fps=10, width_px=320))


def gif_pictures(path: Path) -> tuple[list[NDArray[np.uint8]], list[int]]:
    """Pictures and their durations in ms."""
    with Image.open(path) as gif:
        pairs = [(np.asarray(each.convert("RGB")), int(each.info["duration"])) for each in ImageSequence.Iterator(gif)]
    return [picture for picture, _ in pairs], [duration for _, duration in pairs]


def test_a_surface_shows_a_pixels_latest_event_fading() -> None:
    surface = Surface((4, 2), decay_us=100)
    assert (surface.picture(0) == GROUND).all()
    t, one = np.array([10, 20], np.int64), np.ones(2, np.uint16)
    surface.add(Events(t, one, one * 0, np.array([0, 1], np.uint8)))
    assert surface.picture(20)[0, 1].tolist() == list(EVENTS[1])
    half = surface.picture(20 + 69)[0, 1].astype(int)
    assert half == pytest.approx(np.add(EVENTS[1], GROUND) / 2, abs=3)
    assert surface.picture(20 + 600)[0, 1].tolist() == list(GROUND)


def test_every_picture_shows_its_own_moment(tmp_path: Path) -> None:
    assert film(tmp_path / "a.gif") == 10
    pictures, durations_ms = gif_pictures(tmp_path / "a.gif")
    assert (len(pictures), sum(durations_ms)) == (10, 1_000)
    assert all(picture.shape == (200, 320, 3) for picture in pictures)
    at = np.arange(10) / 10 + 1.0
    for t_s, picture in zip(at, pictures, strict=True):
        boxes = {x: (picture[100, 10 * x - 30 + 1] == BOX).all() for x in (8, 24)}
        assert boxes[8] == (1.2 <= t_s < 1.5), t_s
        assert boxes[24] == (1.5 <= t_s < 1.8), t_s
        # Pictures fall on events, up to 1.5 s; the next is faded by then.
        places = ((2, EVENTS[1]), (29, EVENTS[0]))
        on, off = (np.abs(picture[175, 10 * x + 5] - np.array(rgb)).max() < 12 for x, rgb in places)
        assert on == (t_s < 1.55 or t_s > 1.85), t_s
        assert off == (t_s < 1.55), t_s


def test_speed_and_rate_set_how_many_pictures_there_are(tmp_path: Path) -> None:
    for speed, fps, count in ((1.0, 10, 10), (0.5, 10, 19), (1.0, 25, 24), (3.0, 10, 4)):
        look = Look(speed=speed, fps=fps)
        times_us = picture_times(WINDOW, look)
        assert len(times_us) == count
        assert times_us[0] == WINDOW[0]
        assert times_us[-1] >= WINDOW[1] > times_us[-2]
        assert np.diff(times_us) == pytest.approx(1e6 * speed / fps, abs=1)


def test_an_mp4_is_a_film_that_others_read(tmp_path: Path) -> None:
    av = pytest.importorskip("av", reason="PyAV is not installed")
    assert film(tmp_path / "a.mp4") == 10
    with av.open(str(tmp_path / "a.mp4")) as container:
        stream = container.streams.video[0]
        assert (stream.codec_context.width, stream.codec_context.height, stream.average_rate) == (320, 200, 10)
        pictures = [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]
    assert len(pictures) == 10
    inside, outside = pictures[4][100, 50:54].astype(int), pictures[4][100, 150:154].astype(int)
    assert inside.max() > outside.max() + 60, "the window's left edge at x = 8 - 3"


def test_rerun_reads_what_was_written_for_it(tmp_path: Path) -> None:
    pytest.importorskip("rerun", reason="rerun-sdk is not installed")
    assert film(tmp_path / "a.rrd") == 10
    assert (tmp_path / "a.rrd").read_bytes()[:4] == b"RRF2"
    assert (tmp_path / "a.rrd").stat().st_size > 5_000
    assert [path.name for path in tmp_path.iterdir()] == ["a.rrd"]


@pytest.mark.parametrize("suffix", [".gif", ".mp4"])
def test_the_same_film_has_the_same_bytes(tmp_path: Path, suffix: str) -> None:
    if suffix == ".mp4":
        pytest.importorskip("av", reason="PyAV is not installed")
    for name in ("a", "b"):
        film(tmp_path / f"{name}{suffix}")
    assert (tmp_path / f"a{suffix}").read_bytes() == (tmp_path / f"b{suffix}").read_bytes()


def test_what_ends_early_leaves_no_film(tmp_path: Path) -> None:
    class Ends(Exception):
        pass

    def blocks():  # type: ignore[no-untyped-def]
        yield blinking()[:500]
        raise Ends

    with pytest.raises(Ends):
        render(blocks(), SENSOR, [side_of(0, "a", log())], tmp_path / "a.gif", WINDOW, Look())
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("speed", 0.0, "speed = 0: must be from 0.0001 to 1000"),
        ("fps", 500.0, "fps = 500: must be from 1 to 100"),
        ("decay_ms", float("nan"), "decay_ms = nan: must be from 0.001 to 100000"),
        ("width_px", 10, "width_px = 10: must be from 64 to 4096"),
    ],
)
def test_looks_that_cannot_be(name: str, value: float, message: str) -> None:
    with pytest.raises(ConfigError, match=f"^{re.escape(message)}$"):
        Look(**{name: value})  # type: ignore[arg-type]


def test_films_that_cannot_be(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"a\.avi: must end in \.mp4, \.gif, \.rrd$"):
        film(tmp_path / "a.avi")
    with pytest.raises(ConfigError, match=r"^1000001 pictures: must be at most 1000000"):
        picture_times((0, 1_000_000_000), Look(speed=0.1, fps=100))
    with (tmp_path / "a.gif").open("wb") as file:
        gif = GifEncoder(file, (16_384, GIF_PIXELS_MAX // 16_384), 10)
        picture = Image.new("RGB", (1, 1))
        gif.add(picture)
        with pytest.raises(ConfigError, match=r"^\.gif: must have at most 1 pictures of this size"):
            gif.add(picture)


def test_the_palette_has_every_colour_that_is_drawn() -> None:
    known = {tuple(rgb) for rgb in palette().tolist()}
    assert len(palette()) == 256
    assert {GROUND, *EVENTS, *SIDES} <= known


def test_a_box_is_drawn_by_its_own_sides_and_turned_by_its_angle() -> None:
    """24 x 8 px at (40, 30) in a picture of twice the size: upright, lying on its side, and at half a right angle."""
    base = log()
    base.records["x"], base.records["y"], base.records["width"], base.records["height"] = 40, 30, 24, 8
    bounds = {}
    for angle in (0.0, np.pi / 2, np.pi / 4):
        base.records["angle"] = angle
        follower = Follower(side_of(0, "software", base), np.array([1_300_000]))
        image = compose(np.full((64, 96, 3), 7, np.uint8), 2, (192, 128), [follower], 0, "")
        drawn = (np.asarray(image) == BOX).all(axis=2)
        drawn[:44] = False  # above it is its id
        rows, columns = np.nonzero(drawn)
        bounds[angle] = (int(columns.min()), int(columns.max()), int(rows.max()))
    assert bounds[0.0] == pytest.approx((57, 104, 68), abs=1)
    assert bounds[np.pi / 2] == pytest.approx((73, 88, 84), abs=1)
    reach = (24 + 8) / 2**0.5
    assert bounds[np.pi / 4] == pytest.approx((81 - reach, 81 + reach, 61 + reach), abs=2)


def test_a_track_is_called_by_its_class_from_its_first_verdict_on() -> None:
    """No verdict at 1.25 s, a cup at 1.3 s, none of the classes at 1.5 s."""
    classified = replace(log(), verdicts=verdicts_of((1_300_000, 4, 2), (1_450_000, 4, -1)), class_names={2: "cup"})
    follower = Follower(side_of(0, "a", classified), np.array([1_250_000, 1_300_000, 1_500_000, 1_850_000]))
    assert [follower.at(picture)[1] for picture in range(4)] == [["4"], ["4 cup"], ["4 ?"], []]


def test_a_long_name_stays_in_the_picture() -> None:
    """The track stands 8 px from the right edge of 32 px, enlarged tenfold; its name is wider than these 80 px."""
    classified = replace(log(), verdicts=verdicts_of((1_300_000, 4, 2)), class_names={2: "W" * 12})
    follower = Follower(side_of(0, "a", classified), np.array([1_600_000]))
    image = np.asarray(compose(np.zeros((20, 32, 3), np.uint8), 10, (320, 200), [follower], 0, ""))
    columns = np.flatnonzero((image[:62] == BOX).all(axis=2).any(axis=0))  # above the box
    assert columns.max() < 318
    assert np.ptp(columns) > 120

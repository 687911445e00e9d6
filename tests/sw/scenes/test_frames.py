# SPDX-License-Identifier: Apache-2.0
"""Events from images and videos: light, times, sizes, and refused input."""

from __future__ import annotations

import builtins
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from evcot.errors import ConfigError, RecordingError
from evcot.events import Events
from evcot.scenes.frames import Footage, _log_intensity, open_film
from support.refusals import refused

STEPS = (0, 128, 255, 20)


def folder(path: Path, greys: tuple[int, ...] = STEPS, size: tuple[int, int] = (6, 4), suffix: str = "png") -> Path:
    path.mkdir(exist_ok=True)
    for i, grey in enumerate(greys):
        Image.new("L", size, grey).save(path / f"frame_{i:03}.{suffix}")
    return path


def events_of(path: Path, footage: Footage) -> Events:
    return Events.joined(open_film(path, footage).events())


def log_light(grey: int, offset: float = 0.01) -> float:
    code = grey / 255
    return float(np.log((code / 12.92 if code <= 0.04045 else ((code + 0.055) / 1.055) ** 2.4) + offset))


def test_images_become_log_of_linear_light() -> None:
    for grey in (0, 5, 10, 11, 128, 255):
        image = np.full((2, 3, 3), grey, np.uint8)
        np.testing.assert_allclose(_log_intensity(image, Footage()), log_light(grey))
    red, green, blue = (np.zeros((1, 1, 3), np.uint8) for _ in range(3))
    red[..., 0] = green[..., 1] = blue[..., 2] = 255
    light = [float(np.exp(_log_intensity(image, Footage()))[0, 0]) - 0.01 for image in (red, green, blue)]
    assert light == pytest.approx([0.2126, 0.7152, 0.0722])


@pytest.mark.parametrize("suffix", ["png", "PNG", "jpg", "jpeg"])
def test_a_pixel_makes_an_event_for_every_threshold_that_the_images_span(tmp_path: Path, suffix: str) -> None:
    events = events_of(folder(tmp_path / "f", suffix=suffix), Footage(fps=100.0))
    memory, expected = log_light(0), []
    for grey in STEPS[1:]:
        steps = int(abs(log_light(grey) - memory) / 0.2)
        up = log_light(grey) > memory
        expected += [int(up)] * steps
        memory += steps * (0.2 if up else -0.2)
    mine = events.where((events.x == 2) & (events.y == 3))
    assert mine.p.tolist() == expected
    assert len(events) == 24 * len(expected)
    assert mine.t_us[0] < 10_000 < 20_000 < mine.t_us[-1] <= 30_000


def test_times_come_from_the_file_beside_the_images_unless_a_rate_is_given(tmp_path: Path) -> None:
    path = folder(tmp_path / "f", (0, 255, 0))
    (path / "timestamps.txt").write_text("5.0\n5.001\n5.5\n")
    own, given = events_of(path, Footage()), events_of(path, Footage(fps=10.0))
    assert own.t_us[own.p == 1].max() <= 1_000
    assert own.t_us[own.p == 0].min() > 1_000
    assert 400_000 < own.t_us[-1] <= 500_000
    assert given.t_us[given.p == 1].max() <= 100_000
    assert 180_000 < given.t_us[-1] <= 200_000


def test_images_can_be_shrunk_and_cut_short(tmp_path: Path) -> None:
    path = tmp_path / "f"
    path.mkdir()
    for i, value in enumerate((0, 255)):
        image = np.zeros((5, 7), np.uint8)
        image[0:2, 2:4] = value
        Image.fromarray(image).save(path / f"{i}.png")
    film = open_film(path, Footage(fps=10.0, shrink=2))
    assert (film.width, film.height) == (3, 2)
    events = Events.joined(film.events())
    assert set(zip(events.x.tolist(), events.y.tolist(), strict=True)) == {(1, 0)}
    assert not len(events_of(path, Footage(fps=10.0, duration_us=50_000)))


def test_sixteen_bits_of_grey_are_read(tmp_path: Path) -> None:
    path = tmp_path / "f"
    path.mkdir()
    for i, value in enumerate((0, 65_535)):
        Image.fromarray(np.full((4, 6), value, np.uint16)).save(path / f"{i}.png")
    assert len(events_of(path, Footage(fps=10.0))) == 24 * int((log_light(255) - log_light(0)) / 0.2)


def test_noise_and_seeds_reach_the_camera(tmp_path: Path) -> None:
    path = folder(tmp_path / "f", (100, 100, 100))
    from evcot.scenes.pixel import PixelModel

    noisy = Footage(fps=1.0, pixel=PixelModel(noise_hz=20.0))
    assert 700 < len(events_of(path, noisy)) < 1_250


def writes(name: str, content: str | bytes) -> Any:
    data = content.encode() if isinstance(content, str) else content
    return lambda path: (path / name).write_bytes(data)


@pytest.mark.parametrize(
    ("spoil", "fps", "message"),
    [
        (lambda path: [file.unlink() for file in path.iterdir()], 1.0, "f: holds no images: must hold files named"),
        (lambda _: None, 0.0, "f/timestamps.txt: is missing: must hold a time in seconds for each image"),
        (writes("timestamps.txt", "0\n1\n2\n"), 0.0, "f/timestamps.txt: 3 times for 4 images"),
        (writes("timestamps.txt", "0\n1\nx\n3\n"), 0.0, "f/timestamps.txt: line 3: 'x': must be a time in seconds"),
        (writes("timestamps.txt", "0\n1\n1\n3\n"), 0.0, "f: frame 2: t = 1000000 us after 1000000 us: time must advance"),
        (writes("timestamps.txt", b"\xff\xfe"), 0.0, "f/timestamps.txt: cannot be read"),
        (lambda path: Image.new("L", (7, 4)).save(path / "frame_002.png"), 1.0,
         "f: frame 2: 7x4 pixels: must be 6x4, as the first"),
        (writes("frame_001.png", b"nonsense"), 1.0, "f/frame_001.png: is no readable image: cannot identify image file"),
        (lambda path: (path / "frame_001.png").write_bytes((path / "frame_001.png").read_bytes()[:45]), 1.0,
         "f/frame_001.png: is no readable image:"),
    ],
)  # fmt: skip
def test_images_that_make_no_film_are_refused(tmp_path: Path, spoil: Any, fps: float, message: str) -> None:
    path = folder(tmp_path / "f")
    spoil(path)
    with refused(RecordingError, start=f"{tmp_path}/{message}"):
        events_of(path, Footage(fps=fps) if fps else Footage())


def test_every_cut_of_an_image_is_refused_or_read_and_never_worse(tmp_path: Path) -> None:
    path = folder(tmp_path / "f", (0, 255), suffix="png")
    whole = (path / "frame_001.png").read_bytes()
    for length in range(len(whole)):
        (path / "frame_001.png").write_bytes(whole[:length])
        with suppress(RecordingError):
            assert len(events_of(path, Footage(fps=1.0)))


def test_settings_outside_their_range_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"footage\.shrink = 0: must be from 1 to 64"):
        Footage(shrink=0)
    with pytest.raises(ConfigError, match=r"footage\.shrink = 5: must leave a pixel of 6x4"):
        open_film(folder(tmp_path / "f"), Footage(fps=1.0, shrink=5))


def test_a_video_gives_its_frames_and_times(tmp_path: Path) -> None:
    av = pytest.importorskip("av")
    path = tmp_path / "steps.mkv"
    with av.open(str(path), "w") as container:
        stream = container.add_stream("ffv1", rate=25)
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        for grey in (16, 128, 235, 16):
            frame = av.VideoFrame.from_ndarray(np.full((48, 64, 3), grey, np.uint8), format="rgb24")
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
    film = open_film(path, Footage())
    assert (film.width, film.height) == (64, 48)
    events = Events.joined(film.events())
    mine = events.where((events.x == 0) & (events.y == 0))
    assert set(mine.p[mine.t_us <= 80_000].tolist()) == {1}
    assert set(mine.p[mine.t_us > 80_000].tolist()) == {0}
    assert 100_000 < mine.t_us[-1] <= 120_000
    assert events_of(path, Footage(fps=50.0)).t_us[-1] <= 60_000
    whole = path.read_bytes()
    for cut in (b"", b"nonsense" * 50, whole[: len(whole) // 8]):
        path.write_bytes(cut)
        with pytest.raises(RecordingError, match=r"steps\.mkv: (is no readable video|holds no)"):
            events_of(path, Footage())
    with pytest.raises(RecordingError, match=r"none\.mp4: cannot be read: No such file"):
        events_of(tmp_path / "none.mp4", Footage())


def test_without_pyav_a_video_names_the_extra(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    real = builtins.__import__

    def without(name: str, *rest: Any, **others: Any) -> Any:
        if name == "av":
            raise ImportError(name)
        return real(name, *rest, **others)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(ConfigError, match=r"v\.mp4: a video needs PyAV: must be installed, with pip install 'evcot\[video\]'"):
        open_film(tmp_path / "v.mp4", Footage())

# SPDX-License-Identifier: Apache-2.0
"""A film of a recording, fading events with tracks over them, and its encoders: MP4, GIF, and Rerun's recordings (the extra
`rerun`)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any, BinaryIO, Protocol, cast

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from ...errors import ConfigError
from ...events import Events
from ...outputs import written_aside
from ...recordings.formats.source import Sensor
from ...tracks.record import upright_sides
from . import GIF, MP4, RERUN, SUFFIXES, Look
from .draw import EVENTS, Follower, Side, Surface, compose, palette, size_of

__all__ = ["GIF_PIXELS_MAX", "check_suffix", "picture_times", "render"]

GIF_PIXELS_MAX = 1 << 29

_CRF = "20"  # quality of H.264: preserves thin lines and single pixels


class Encoder(Protocol):
    """A film being written."""

    def __init__(self, file: BinaryIO, size: tuple[int, int], fps: float) -> None: ...

    def add(self, image: Image.Image) -> None:
        """Append a picture."""
        ...

    def close(self) -> None:
        """Finish the film; closing the file itself is up to the caller."""
        ...


class Mp4Encoder:
    """H.264 in MP4, or MPEG-4 if the codec is missing."""

    def __init__(self, file: BinaryIO, size: tuple[int, int], fps: float) -> None:
        import av

        self._film = av.open(file, "w", format="mp4")
        name = "libx264" if "libx264" in av.codecs_available else "mpeg4"
        rate = Fraction(fps).limit_denominator(1001)
        options = {"crf": _CRF} if name == "libx264" else {"qscale": "3"}
        self._stream = cast(Any, self._film).add_stream(name, rate=rate, options=options)
        self._stream.width, self._stream.height = size
        self._stream.pix_fmt = "yuv420p"
        self._from_image = av.VideoFrame.from_ndarray

    def add(self, image: Image.Image) -> None:
        """See `Encoder`."""
        self._film.mux(self._stream.encode(self._from_image(np.asarray(image), format="rgb24")))

    def close(self) -> None:
        """See `Encoder`."""
        self._film.mux(self._stream.encode())
        self._film.close()


class GifEncoder:
    """GIF, with one palette for all pictures and a time resolution of 10 ms. Held in memory until the end."""

    def __init__(self, file: BinaryIO, size: tuple[int, int], fps: float) -> None:
        self._file, self._fps = file, fps
        self._palette = Image.new("P", (1, 1))
        self._palette.putpalette(palette().tobytes())
        self._pictures: list[Image.Image] = []
        self._most = GIF_PIXELS_MAX // (size[0] * size[1])

    def add(self, image: Image.Image) -> None:
        """See `Encoder`."""
        if len(self._pictures) >= self._most:
            raise ConfigError(f".gif: must have at most {self._most} pictures of this size: a shorter part, or .mp4, has room")
        self._pictures.append(image.quantize(palette=self._palette, dither=Image.Dither.NONE))

    def close(self) -> None:
        """See `Encoder`."""
        ends_cs = np.round(np.arange(len(self._pictures) + 1) * 100 / self._fps).astype(int)
        durations_ms = (np.diff(ends_cs) * 10).tolist()
        first, *others = self._pictures
        first.save(self._file, "GIF", save_all=True, append_images=others, duration=durations_ms, loop=0, optimize=False)


ENCODERS: dict[str, type[Encoder]] = {MP4: Mp4Encoder, GIF: GifEncoder}


def check_encoder(suffix: str) -> None:
    """Raise ConfigError if films with this suffix cannot be written on this machine."""
    if suffix == MP4:
        try:
            import av  # noqa: F401
        except ImportError as error:
            raise ConfigError(".mp4: PyAV must be installed: pip install 'evcot[video]'; .gif needs nothing more") from error


_POINT_PX = 0.5  # radius


def check_rerun() -> None:
    """Raise ConfigError if Rerun's library is not installed."""
    try:
        import rerun  # noqa: F401
    except ImportError as error:
        raise ConfigError(".rrd: rerun-sdk must be installed: pip install 'evcot[rerun]'") from error


def write_rerun(
    file: BinaryIO, sensor: Sensor, pictures: Iterable[tuple[int, list[Events]]], followers: Sequence[Follower], zero_us: int,
    progress: Callable[[int, int], None] | None,
) -> None:  # fmt: skip
    """Write events and tracks up to each picture's time; the file must have a name."""
    import rerun

    stream = rerun.RecordingStream("evcot", recording_id="evcot", send_properties=False)
    stream.save(file.name)
    frame = rerun.Boxes2D(mins=[(-0.5, -0.5)], sizes=[sensor], colors=[(90, 98, 108)])
    stream.log("sensor", frame, static=True)
    for number, (now_us, part) in enumerate(pictures):
        stream.set_time("recording", duration=(now_us - zero_us) / 1e6)
        events = Events.joined(part)
        places = np.column_stack([events.x, events.y]).astype(np.float32)
        colours = np.array(EVENTS, np.uint8)[events.p]
        stream.log("events", rerun.Points2D(places, colors=colours, radii=_POINT_PX))
        for follower in followers:
            _log_side(rerun, stream, follower, number)
        if progress is not None:
            progress(number + 1, now_us - zero_us)
    stream.flush()
    stream.disconnect()


def _log_side(rerun: Any, stream: Any, follower: Follower, picture: int) -> None:
    states, labels, trails = follower.at(picture)
    name, colour = follower.side.name, follower.side.colour
    centres = np.column_stack([states["x"], states["y"]])
    half = np.column_stack(upright_sides(states)) / 2  # Boxes2D has no angle
    stream.log(f"{name}/boxes", rerun.Boxes2D(centers=centres, half_sizes=half, labels=labels, colors=[colour] * len(states)))
    lines = [list(trail) for trail in trails.values() if len(trail) > 1]
    stream.log(f"{name}/trails", rerun.LineStrips2D(lines, colors=[colour] * len(lines)))


_PICTURES_MAX = 1_000_000

Progress = Callable[[int, int], None]
"""Progress callback: number of pictures done, and time of the recording in us after the start of the window."""


def render(
    blocks: Iterable[Events], sensor: Sensor, sides: Sequence[Side], path: Path | str, window: tuple[int, int],
    look: Look | None = None, progress: Progress | None = None, *, force: bool = False,
) -> int:  # fmt: skip
    """Write a film in the format of the path's suffix, one of `SUFFIXES`, and return its number of pictures.

    Args:
        blocks: the events of the window, in order. Events before the window fade in its first pictures.
        window: times of the first and the last event.
        force: replace an existing file.

    Raises:
        ConfigError: unknown suffix, missing package, or too many pictures.
        OutputError: the file exists, or cannot be written.
    """
    path, look = Path(path), look or Look()
    suffix = path.suffix.lower()
    check_suffix(path)
    times_us = picture_times(window, look)
    followers = [Follower(side, times_us) for side in sides]
    parts = _parts(blocks, times_us)
    with written_aside(path, force=force) as file:
        if suffix == RERUN:
            write_rerun(file, sensor, zip(times_us.tolist(), parts, strict=True), followers, window[0], progress)
            return len(times_us)
        enlarged, width, height = size_of(sensor, look.width_px)
        encoder = ENCODERS[suffix](file, (width, height), look.fps)
        surface = Surface(sensor, look.decay_ms * 1e3 * look.speed)
        for picture, (now_us, part) in enumerate(zip(times_us.tolist(), parts, strict=True)):
            for events in part:
                surface.add(events)
            caption = f"{(now_us - window[0]) / 1e6:.3f} s"
            encoder.add(compose(surface.picture(now_us), enlarged, (width, height), followers, picture, caption))
            if progress is not None:
                progress(picture + 1, now_us - window[0])
        encoder.close()
    return len(times_us)


def check_suffix(path: Path) -> None:
    """Raise ConfigError if films with the path's suffix cannot be written on this machine."""
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise ConfigError(f"{path}: must end in {', '.join(SUFFIXES)}")
    if suffix == RERUN:
        check_rerun()
    else:
        check_encoder(suffix)


def picture_times(window: tuple[int, int], look: Look) -> NDArray[np.int64]:
    """(n,) the time of each picture; the last is that of the end of the window."""
    step_us = 1e6 * look.speed / look.fps
    count = int(np.ceil((window[1] - window[0]) / step_us)) + 1
    if count > _PICTURES_MAX:
        raise ConfigError(f"{count} pictures: must be at most {_PICTURES_MAX}: a shorter part, or a higher speed, has fewer")
    times_us: NDArray[np.int64] = np.round(window[0] + step_us * np.arange(count)).astype(np.int64)
    return times_us


def _parts(blocks: Iterable[Events], times_us: NDArray[np.int64]) -> Iterator[list[Events]]:
    """For each time, the events after the previous time up to it."""
    source = iter(blocks)
    rest = Events.empty()
    for now_us in times_us.tolist():
        part = []
        while True:
            end = int(np.searchsorted(rest.t_us, now_us, "right"))
            part.append(rest[:end])
            rest = rest[end:]
            if len(rest) or (block := next(source, None)) is None:
                break
            rest = block
        yield part

# SPDX-License-Identifier: Apache-2.0
"""Encoders of film files: MP4, GIF, and Rerun's recordings (the extra `rerun`)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction
from typing import Any, BinaryIO, Protocol, cast

import numpy as np
from PIL import Image

from ...errors import ConfigError
from ...events import Events
from ...recordings.formats.source import Sensor
from ...tracks.boxes import upright_sides
from .draw import EVENTS, Follower, palette
from .look import GIF, MP4

__all__ = ["ENCODERS", "GIF_PIXELS_MAX", "Encoder", "check_encoder", "check_rerun", "write_rerun"]


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

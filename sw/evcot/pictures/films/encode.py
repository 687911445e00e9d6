# SPDX-License-Identifier: Apache-2.0
"""Encoders of film files."""

from __future__ import annotations

from fractions import Fraction
from typing import Any, BinaryIO, Protocol, cast

import numpy as np
from PIL import Image

from ...errors import ConfigError
from .colours import palette
from .look import GIF, MP4

__all__ = ["ENCODERS", "GIF_PIXELS_MAX", "Encoder", "check_encoder"]

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

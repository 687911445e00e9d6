# SPDX-License-Identifier: Apache-2.0
"""Events from frames: a folder of images or a video file, seen by a `PixelCamera`. There is no ground truth.

Frames are assumed to be sRGB and converted to linear light by its transfer function (IEC 61966-2-1), then to luminance (ITU-R
BT.709); log intensity is log(luminance + offset). Between frames it is interpolated linearly, so the frame rate should be high
enough that nothing moves much more than a pixel per frame.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from ..errors import ConfigError, RecordingError
from ..events import Events
from ..ranges import check_ranges, setting
from .pixel import PixelCamera, PixelModel

__all__ = ["SUFFIXES", "TIMES_FILE", "Film", "Footage", "open_film"]

SUFFIXES = (".png", ".jpg", ".jpeg")
TIMES_FILE = "timestamps.txt"

_SIDE_MAX = 16_384
_LUMINANCE = (0.2126, 0.7152, 0.0722)


@dataclass(frozen=True)
class Footage:
    """Settings of the conversion from frames.

    Raises:
        ConfigError: a value outside its range.
    """

    fps: float = setting(0.0, 0.0, 1e6, "frames per second; 0 for the file's own times")
    shrink: int = setting(1, 1, 64, "binning factor: pixels per side of the frame that are averaged to one")
    offset: float = setting(0.01, 1e-4, 1.0, "added to luminance before the logarithm; white is 1")
    duration_us: int = setting(0, 0, 10**15, "how much of it; 0 for all")
    seed: int = setting(1, 0, 2**63 - 1, "seed of mismatch and noise")
    pixel: PixelModel = field(default_factory=PixelModel)

    def __post_init__(self) -> None:
        check_ranges("footage", self)


class Film:
    """A sequence of frames of one size.

    Attributes:
        width, height: of the sensor, in pixels.
    """

    def __init__(self, name: str, frames: Iterator[tuple[float | None, NDArray[np.uint8]]], footage: Footage) -> None:
        """
        Args:
            name: for messages.
            frames: time in seconds, None if unknown, and (height, width, 3) sRGB.
        """
        self._name = name
        self._frames = frames
        self._footage = footage
        first = next(frames, None)
        if first is None:
            raise RecordingError(f"{name}: holds no frames")
        self._first = first
        self._shape = first[1].shape
        self.height, self.width = (side // footage.shrink for side in self._shape[:2])
        if not self.width or not self.height:
            raise ConfigError(f"footage.shrink = {footage.shrink}: must leave a pixel of {self._shape[1]}x{self._shape[0]}")

    def events(self) -> Iterator[Events]:
        """The events between each frame and the next; can be iterated only once.

        Raises:
            RecordingError: a frame cannot be read, has another size, or has no time or one that does not advance.
        """
        footage = self._footage
        camera = PixelCamera(footage.pixel, self.width, self.height, footage.seed)
        last_us = -1
        for number, (t_s, image) in enumerate(self._all()):
            t_us = self._time_us(number, t_s, last_us)
            if image.shape != self._shape:
                size, wanted = (f"{shape[1]}x{shape[0]}" for shape in (image.shape, self._shape))
                raise RecordingError(f"{self._name}: frame {number}: {size} pixels: must be {wanted}, as the first")
            if footage.duration_us and t_us > footage.duration_us:
                return
            yield camera.step(_log_intensity(image, footage), t_us)
            last_us = t_us

    def _all(self) -> Iterator[tuple[float | None, NDArray[np.uint8]]]:
        yield self._first
        yield from self._frames

    def _time_us(self, number: int, t_s: float | None, last_us: int) -> int:
        if self._footage.fps:
            return round(number * 1e6 / self._footage.fps)
        if t_s is None or self._first[0] is None:
            raise RecordingError(f"{self._name}: frame {number}: has no time: frames per second must be given")
        t_us = round((t_s - self._first[0]) * 1e6)
        if t_us <= last_us:
            raise RecordingError(f"{self._name}: frame {number}: t = {t_us} us after {last_us} us: time must advance")
        return t_us


def open_film(path: Path | str, footage: Footage) -> Film:
    """Open a folder of images, or a video file.

    A folder's frames are its PNG and JPEG files, sorted by name; their times are the lines of its timestamps.txt, in seconds,
    or come from `footage.fps`. Video needs PyAV, the extra `video`.

    Raises:
        ConfigError: PyAV is missing, or the settings leave no pixel.
        RecordingError: the file does not exist, there are no images, or the first one cannot be read; names file and rule.
    """
    path = Path(path)
    frames = _images(path, footage) if path.is_dir() else _video(path)
    return Film(str(path), frames, footage)


def _log_intensity(image: NDArray[np.uint8], footage: Footage) -> NDArray[np.float64]:
    luminance = _LINEAR[image] @ np.array(_LUMINANCE)
    k = footage.shrink
    if k > 1:
        height, width = (side // k * k for side in luminance.shape)
        luminance = luminance[:height, :width].reshape(height // k, k, width // k, k).mean(axis=(1, 3))
    return np.asarray(np.log(luminance + footage.offset))


def _linear() -> NDArray[np.float64]:
    code = np.arange(256) / 255
    return np.where(code <= 0.04045, code / 12.92, ((code + 0.055) / 1.055) ** 2.4)


_LINEAR = _linear()


def _images(folder: Path, footage: Footage) -> Iterator[tuple[float | None, NDArray[np.uint8]]]:
    try:
        paths = sorted(path for path in folder.iterdir() if path.suffix.lower() in SUFFIXES)
    except OSError as error:
        raise RecordingError(f"{folder}: cannot be read: {error.strerror or error}") from error
    if not paths:
        raise RecordingError(f"{folder}: holds no images: must hold files named *{', *'.join(SUFFIXES)}")
    times_s: list[float] | None = None
    if not footage.fps:
        times_s = _times(folder / TIMES_FILE, len(paths))
    for number, path in enumerate(paths):
        yield None if times_s is None else times_s[number], _image(path)


def _times(path: Path, count: int) -> list[float]:
    if not path.exists():
        raise RecordingError(f"{path}: is missing: must hold a time in seconds for each image, or fps must be given")
    try:
        lines = path.read_text(encoding="utf-8").split()
    except (OSError, UnicodeDecodeError) as error:
        raise RecordingError(f"{path}: cannot be read: {error}") from error
    times = []
    for number, line in enumerate(lines, 1):
        try:
            times.append(float(line))
        except ValueError:
            times.append(math.nan)
        if not abs(times[-1]) < 1e9:
            raise RecordingError(f"{path}: line {number}: {line[:40]!r}: must be a time in seconds")
    if len(times) != count:
        raise RecordingError(f"{path}: {len(times)} times for {count} images: must be one each")
    return times


def _image(path: Path) -> NDArray[np.uint8]:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", Image.DecompressionBombWarning)
            with Image.open(path) as image:
                if max(image.size) > _SIDE_MAX:
                    raise RecordingError(f"{path}: {image.width}x{image.height} pixels: a side must be at most {_SIDE_MAX}")
                if image.mode.startswith("I"):  # 16 bits of grey
                    grey = (np.asarray(image).astype(np.int64) >> 8).astype(np.uint8)
                    return np.repeat(grey[:, :, None], 3, axis=2)
                return np.asarray(image.convert("RGB"))
    except RecordingError:
        raise
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError, Image.DecompressionBombWarning) as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise RecordingError(f"{path}: is no readable image: {reason}") from error


def _video(path: Path) -> Iterator[tuple[float | None, NDArray[np.uint8]]]:
    try:
        import av
    except ImportError as error:
        raise ConfigError(f"{path}: a video needs PyAV: must be installed, with pip install 'evcot[video]'") from error
    if not path.exists():
        raise RecordingError(f"{path}: cannot be read: No such file or directory")
    try:
        with av.open(str(path)) as container:
            if not container.streams.video:
                raise RecordingError(f"{path}: holds no video")
            for frame in container.decode(container.streams.video[0]):
                yield frame.time, np.asarray(frame.to_ndarray(format="rgb24"), np.uint8)
    except (av.error.FFmpegError, OSError) as error:
        raise RecordingError(f"{path}: is no readable video: {error.strerror or error}") from error

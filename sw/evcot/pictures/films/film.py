# SPDX-License-Identifier: Apache-2.0
"""A film of a recording: fading events with tracks over them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...errors import ConfigError
from ...events import Events
from ...outputs import written_aside
from ...recordings.formats.source import Sensor
from .draw import Follower, Side, Surface, compose, size_of
from .encode import ENCODERS, check_encoder, check_rerun, write_rerun
from .look import RERUN, SUFFIXES, Look

__all__ = ["check_suffix", "picture_times", "render"]

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

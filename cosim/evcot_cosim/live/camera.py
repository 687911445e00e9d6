# SPDX-License-Identifier: Apache-2.0
"""USB cameras, through dv-processing (the extra `camera`)."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from evcot.errors import ConfigError, RecordingError
from evcot.events import Events

from .sources import StreamSource

__all__ = ["CameraSource"]

_NAP_S = 0.001


class CameraSource(StreamSource):
    """The first camera found, or the one with a given serial number. See `sources.LiveSource`.

    Raises:
        ConfigError: dv-processing is not installed.
        RecordingError: no such camera.
    """

    def __init__(self, serial: str | None = None) -> None:
        try:
            import dv_processing  # type: ignore[import-not-found, unused-ignore]
        except ImportError as error:
            raise ConfigError("camera: dv-processing must be installed: pip install 'evcot[camera]'") from error
        found = [str(each.serialNumber) for each in dv_processing.io.camera.discover()]
        if not found:
            raise RecordingError("camera: none is connected, or this user may not open it")
        if serial is not None and serial not in found:
            raise RecordingError(f"camera:{serial}: is not connected: must be one of {', '.join(found)}")
        try:
            capture = dv_processing.io.camera.open(serial or found[0])
        except RuntimeError as error:
            raise RecordingError(f"camera:{serial or found[0]}: cannot be opened: {' '.join(str(error).split())}") from error
        width, height = capture.getEventResolution()
        super().__init__(capture.getCameraName(), lambda wanted: _batches(capture, wanted), (width, height), lambda: None)


def _batches(capture: Any, wanted: Callable[[], bool]) -> Iterator[Events]:
    """Batches of events from the camera's driver, until the camera is disconnected."""
    while wanted() and capture.isRunning():
        batch = capture.getNextEventBatch()
        if batch is None or not len(batch):
            time.sleep(_NAP_S)
            continue
        yield _events(batch.numpy())


def _events(batch: Any) -> Events:
    """Events of dv-processing's structured array: timestamp, x, y, polarity."""
    t_us, x, y = batch["timestamp"].astype(np.int64), batch["x"].astype(np.uint16), batch["y"].astype(np.uint16)
    return Events(t_us, x, y, batch["polarity"].astype(np.uint8))

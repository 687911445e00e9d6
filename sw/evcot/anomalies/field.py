# SPDX-License-Identifier: Apache-2.0
"""The field of normal motion: statistics of the tracks in each cell of the picture, as sums that can be smoothed."""

from __future__ import annotations

import zipfile
import zlib
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt, gaussian_filter

from ..errors import ConfigError
from ..outputs import note_input, written_aside
from ..ranges import check_ranges, setting
from .layout import Field
from .motion import Steps

__all__ = ["FieldConfig", "NormalMotion"]

_FORMAT = 1
_NEAR_PX = 64.0  # maximum distance over which a supported cell's speed is used
_LEAST_DEVIATION = 0.1  # of the logarithm of speed
_SUMS = ("visits", "ends", "turns", "x", "y", "log_speed", "log_speed_squared")
_SMALL = 1e-9


@dataclass(frozen=True)
class FieldConfig:
    """Settings of the field's grid.

    Raises:
        ConfigError: a value outside its range.
    """

    cell_px: int = setting(8, 1, 1024, "side of a cell")
    smooth_cells: float = setting(1.0, 0.0, 100.0, "standard deviation of the Gaussian by which cells share what they know")

    def __post_init__(self) -> None:
        check_ranges("field", self)


@dataclass(frozen=True, eq=False)
class NormalMotion:
    """Sums over visits: a track's passage through a cell counts once, however long it takes.

    Attributes:
        sensor: (width, height) in pixels.
        config: size of the cells, which begin at pixel (0, 0), and smoothing.
        measured: settings with which velocities were measured.
        tracks: number of tracks learned from.
        visits: (rows, columns) number of tracks that passed through.
        ends: number of tracks lost there.
        turns: number of visits with a direction; x, y: sums of their unit vectors.
        log_speed, log_speed_squared: sums of log(px/s) and of its square.
    """

    sensor: tuple[int, int]
    config: FieldConfig
    measured: Steps
    tracks: int
    visits: NDArray[np.float64]
    ends: NDArray[np.float64]
    turns: NDArray[np.float64]
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    log_speed: NDArray[np.float64]
    log_speed_squared: NDArray[np.float64]

    def smoothed(self, min_support: float = 0.0) -> Field:
        """The field for the rules. Sums are smoothed before division, so neighbours are weighted by their number of visits.
        Deviations are those within cells: differences of speed between cells, as caused by perspective, are not included.
        `near_speed` is that of the nearest cell with `min_support`."""
        sums = {name: self._shared(getattr(self, name)) for name in _SUMS}
        support, length = sums["visits"], np.hypot(sums["x"], sums["y"])
        log_speed = sums["log_speed"] / np.maximum(support, _SMALL)
        squares = self._shared(self.log_speed_squared - self.log_speed**2 / np.maximum(self.visits, 1.0))
        variance = np.maximum(squares / np.maximum(self._shared(np.maximum(self.visits - 1.0, 0.0)), _SMALL), 0.0)
        return Field(
            cell_px=float(self.config.cell_px),
            support=support,
            ends=sums["ends"],
            x=sums["x"] / np.maximum(length, _SMALL),
            y=sums["y"] / np.maximum(length, _SMALL),
            concentration=np.minimum(length / np.maximum(sums["turns"], _SMALL), 1.0),
            log_speed=log_speed,
            deviation=np.maximum(np.sqrt(variance), _LEAST_DEVIATION),
            near_speed=self._near(np.exp(log_speed), support >= max(min_support, _SMALL)),
        )

    def _shared(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(gaussian_filter(values, self.config.smooth_cells, mode="constant"), np.float64)

    def _near(self, speed: NDArray[np.float64], there: NDArray[np.bool_]) -> NDArray[np.float64]:
        if not there.any():
            return np.full(speed.shape, np.nan)
        away, (row, column) = distance_transform_edt(~there, return_indices=True)
        return np.where(away * self.config.cell_px <= _NEAR_PX, speed[row, column], np.nan)

    def save(self, path: Path | str, *, force: bool = False) -> None:
        """Write an .npz file; equal fields give identical files.

        Args:
            force: replace an existing file.

        Raises:
            OutputError: the file exists, or cannot be written.
        """
        head = {"format": _FORMAT, "sensor": self.sensor, "tracks": self.tracks}
        arrays: dict[str, Any] = {name: np.array(value, np.int64) for name, value in head.items()}
        arrays |= {f.name: np.array(float(getattr(self.config, f.name))) for f in fields(FieldConfig)}
        arrays |= {name: np.array(float(value)) for name, value in self.measured._asdict().items()}
        arrays |= {name: getattr(self, name) for name in _SUMS}
        with written_aside(Path(path), force=force) as file:
            np.savez_compressed(file, **arrays)

    @classmethod
    def load(cls, path: Path | str) -> NormalMotion:
        """Read a field written by `save`.

        Raises:
            ConfigError: the file is missing, damaged, or not a field of normal motion.
        """
        stored = _stored(Path(path))
        try:
            return cls._from(stored)
        except ConfigError as error:
            raise ConfigError(f"{path}: {error}") from error

    @classmethod
    def _from(cls, stored: dict[str, NDArray[Any]]) -> NormalMotion:
        (number,) = _integers(stored, "format", 1, 1, _FORMAT)
        assert number == _FORMAT
        width, height = _integers(stored, "sensor", 2, 1, 65_536)
        (tracks,) = _integers(stored, "tracks", 1, 0, 2**53)
        names = (*(f.name for f in fields(FieldConfig)), *Steps._fields)
        settings = {name: float(_array(stored, name, np.float64, ())) for name in names}
        for name in ("cell_px", "step_us"):
            if not settings[name].is_integer():
                raise ConfigError(f"{name} = {settings[name]}: must be an integer")
        config = FieldConfig(int(settings["cell_px"]), settings["smooth_cells"])
        measured = Steps(int(settings["step_us"]), settings["window_us"], settings["travel_px"])
        shape = grid((width, height), config)
        sums = {name: _array(stored, name, np.float64, shape) for name in _SUMS}
        for name, values in sums.items():
            good = np.isfinite(values) & ((values >= 0) | (name not in ("visits", "ends", "turns", "log_speed_squared")))
            if not good.all():
                row, column = np.argwhere(~good)[0]
                raise ConfigError(
                    f"{name}[{row}, {column}] = {values[row, column]}: must be a number, sums of squares not below 0"
                )
        return cls((width, height), config, measured, tracks, **sums)


def grid(sensor: tuple[int, int], config: FieldConfig) -> tuple[int, int]:
    """(rows, columns) of cells that cover a sensor of (width, height) pixels."""
    width, height = sensor
    return -(-height // config.cell_px), -(-width // config.cell_px)


def _stored(path: Path) -> dict[str, NDArray[Any]]:
    note_input(path)
    try:
        with open(path, "rb") as file:
            if not zipfile.is_zipfile(file):
                raise ConfigError(f"{path}: is not an npz file, or is cut off")
            with zipfile.ZipFile(file) as archive:
                damaged = archive.testzip()
            if damaged:
                raise ConfigError(f"{path}: is damaged: wrong checksum of {damaged}")
            file.seek(0)
            with np.load(file, allow_pickle=False) as content:
                missing = [name for name in ("format", "sensor", "tracks", *_SUMS) if name not in content.files]
                if missing:
                    raise ConfigError(f"{path}: has no array {missing[0]}: must be a field of normal motion (--learn)")
                return {name: content[name] for name in content.files}
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read: {error.strerror or error}") from error
    except ConfigError:
        raise
    except (zipfile.BadZipFile, zlib.error, EOFError, ValueError, RuntimeError, MemoryError) as error:
        raise ConfigError(f"{path}: is damaged: {' '.join(str(error).split()) or 'ends too soon'}") from error


def _array(stored: dict[str, NDArray[Any]], name: str, dtype: Any, shape: tuple[int, ...]) -> NDArray[Any]:
    array = stored.get(name)
    if array is None or array.dtype != dtype or array.shape != shape:
        found = "nothing" if array is None else f"{array.dtype} of shape {array.shape}"
        raise ConfigError(f"{name} is {found}: must be {np.dtype(dtype)} of shape {shape}")
    return array


def _integers(stored: dict[str, NDArray[Any]], name: str, count: int, low: int, high: int) -> list[int]:
    values = _array(stored, name, np.int64, (count,) if count > 1 else ()).ravel().tolist()
    if not all(low <= value <= high for value in values):
        raise ConfigError(f"{name} = {values}: must be from {low} to {high}")
    return values

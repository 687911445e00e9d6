# SPDX-License-Identifier: Apache-2.0
"""A simulated scene: its recording and exact ground truth; and rectangles on piecewise linear paths.

Positions are in event coordinates: the centre of pixel (x, y) is at (x, y), so a truth centre and a tracker's centre of mass
can be compared directly.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path
from typing import BinaryIO, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import RecordingError
from ..events import Recording
from ..outputs import written_aside
from ..tracks.formats.base import BOX, Boxes

__all__ = ["TRUTH", "TRUTH_COLUMNS", "Box", "Label", "ObjectClass", "Scene", "Truth", "on_sensor", "sample"]


class ObjectClass(IntEnum):
    """What an object of a scene is; scenes without kinds have objects alone."""

    OBJECT = 0
    CAR = 1
    LORRY = 2
    PERSON = 3
    ANIMAL = 4


TRUTH = np.dtype(
    [
        ("t_us", "<i8"),
        ("object_id", "<i4"),
        ("x", "<f8"),
        ("y", "<f8"),
        ("width", "<f8"),
        ("height", "<f8"),
        ("vx", "<f8"),
        ("vy", "<f8"),
        ("visible", "?"),
        ("occluded", "<f8"),
        ("class_id", "<i8"),
    ]
)

TRUTH_COLUMNS = ("t_us", "object_id", "left", "top", "width", "height", "vx", "vy", "visible", "occluded", "class_id")
_FORMATS = ("%d", "%d", "%.4f", "%.4f", "%.4f", "%.4f", "%.3f", "%.3f", "%d", "%.4f", "%d")
_WITHOUT_CLASSES = TRUTH_COLUMNS[:-1]  # files of evcot 0.2

_COUNTED_OCCLUDED_MAX = 0.5  # as of the rule "scene"


@dataclass(frozen=True, eq=False)
class Box:
    """A rectangle that moves in a straight line from each waypoint to the next, and stops at the last.

    Attributes:
        width, height: size in pixels.
        brighter: whether it is brighter than the background.
        t_us, x, y: (k,) float64 waypoints of its centre; times strictly increasing.
    """

    width: float
    height: float
    brighter: bool
    t_us: NDArray[np.float64]
    x: NDArray[np.float64]
    y: NDArray[np.float64]

    def centre(self, t_us: NDArray[np.int64] | NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Exact centre at times of any shape, in microseconds."""
        return np.interp(t_us, self.t_us, self.x), np.interp(t_us, self.t_us, self.y)

    def velocity(self, t_us: NDArray[np.int64] | NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Exact velocity at times of any shape, pixels per second; at a waypoint, that of the following segment."""
        leg = np.searchsorted(self.t_us, t_us, side="right")
        seconds = np.diff(self.t_us) * 1e-6
        vx, vy = (np.concatenate(([0.0], np.diff(axis) / seconds, [0.0])) for axis in (self.x, self.y))
        return vx[leg], vy[leg]


class Label(NamedTuple):
    """The anomalous behaviour of an object, with its first and last time, inclusive."""

    object_id: int
    kind: str
    begin_us: int
    end_us: int


@dataclass(frozen=True, eq=False)
class Truth:
    """The objects of a scene: sampled, and, in the box experiment, in closed form.

    Attributes:
        samples: (n,) of dtype `TRUTH`, by time, then by object: centre of the object's bounding box in event coordinates and
            its size in pixels, velocity of that centre in pixels per second; `visible` while the centre lies on the sensor;
            `occluded`, the part of the object's area that nearer objects hide or that lies outside the sensor; `class_id`, a
            number of `ObjectClass`.
        boxes: the objects of the box experiment; `object_id` is the index.
        labels: what is abnormal in the scene; not part of the file.
    """

    samples: NDArray[np.void]
    boxes: tuple[Box, ...] = ()
    labels: tuple[Label, ...] = ()

    def write(self, file: BinaryIO) -> None:
        """Write the samples as CSV with the columns `TRUTH_COLUMNS`: left and top edge and size of the box, in pixels with 4
        decimals (the sensor begins at -0.5), and velocity, in pixels per second with 3."""
        samples = self.samples
        left, top = samples["x"] - samples["width"] / 2, samples["y"] - samples["height"] / 2
        columns = (
            samples["t_us"], samples["object_id"], left, top, samples["width"], samples["height"], samples["vx"], samples["vy"],
            samples["visible"], samples["occluded"], samples["class_id"],
        )  # fmt: skip
        table = np.stack(columns, axis=1, dtype=np.float64)
        np.savetxt(file, table, _FORMATS, ",", header=",".join(TRUTH_COLUMNS), comments="")

    def save(self, path: Path | str, *, force: bool = False) -> None:
        """`write` to a file, which appears under its name only when it is complete.

        Args:
            force: replace a file that exists.

        Raises:
            OutputError: the file exists, or cannot be written.
        """
        with written_aside(Path(path), force=force) as file:
            self.write(file)

    @classmethod
    def load(cls, path: Path | str) -> Truth:
        """Read samples written by `write`; in files without `class_id` all are `ObjectClass.OBJECT`.

        Raises:
            RecordingError: the file is missing, has other columns, or an invalid line.
        """
        path = Path(path)
        try:
            with path.open(encoding="utf-8") as file:
                header = file.readline().strip()
                columns = TRUTH_COLUMNS if header == ",".join(TRUTH_COLUMNS) else _WITHOUT_CLASSES
                if header != ",".join(columns):
                    raise RecordingError(f"{path}: line 1: {header[:80]!r}: must be {','.join(TRUTH_COLUMNS)}")
                lines = file.readlines()
            table = np.loadtxt(lines, delimiter=",", ndmin=2) if lines else np.empty((0, len(columns)))
        except OSError as error:
            raise RecordingError(f"{path}: cannot be read: {error.strerror or error}") from error
        except UnicodeDecodeError as error:
            raise RecordingError(f"{path}: byte {error.start}: must be UTF-8 text") from error
        except RecordingError:
            raise
        except ValueError as error:
            raise RecordingError(f"{path}: {error}") from error
        if table.shape[1] != len(columns):
            raise RecordingError(f"{path}: line 2: {table.shape[1]} values: must be {len(columns)}")
        samples = np.zeros(len(table), TRUTH)
        for name, column in zip(columns, table.T, strict=True):
            samples[{"left": "x", "top": "y"}.get(name, name)] = column
        samples["x"] += samples["width"] / 2
        samples["y"] += samples["height"] / 2
        return cls(samples)

    def labelled_boxes(self, sensor: tuple[int, int] | None = None) -> Boxes:
        """The visible objects as boxes with classes; those that are mostly occluded do not count.

        Args:
            sensor: (width, height) in pixels, which files of boxes state.
        """
        samples = self.samples[self.samples["visible"]]
        instants_us, instant = np.unique(samples["t_us"], return_inverse=True)
        rows = np.zeros(len(samples), BOX)
        rows["instant"], rows["id"], rows["class_id"] = instant, samples["object_id"], samples["class_id"]
        for low, axis, side in (("left", "x", "width"), ("top", "y", "height")):
            rows[low], rows[side] = samples[axis] - samples[side] / 2, samples[side]
        rows["confidence"], rows["visibility"] = 1.0, 1 - samples["occluded"]
        rows["counted"] = samples["occluded"] <= _COUNTED_OCCLUDED_MAX
        return Boxes(instants_us, rows, sensor, class_names={one.value: one.name.lower() for one in ObjectClass})


def sample(boxes: tuple[Box, ...], times_us: NDArray[np.int64], sensor: tuple[int, int]) -> NDArray[np.void]:
    """`Truth.samples` of boxes that do not occlude each other, at (k,) times, for a sensor of (width, height) pixels."""
    samples = np.zeros((len(times_us), len(boxes)), TRUTH)
    samples["t_us"] = times_us[:, None]
    samples["object_id"] = np.arange(len(boxes))
    for i, box in enumerate(boxes):
        column = samples[:, i]
        column["x"], column["y"] = box.centre(times_us)
        column["vx"], column["vy"] = box.velocity(times_us)
        column["width"], column["height"] = box.width, box.height
    samples["visible"] = on_sensor(samples, sensor)
    within = [
        np.clip(
            np.minimum(samples[axis] + samples[side] / 2, size - 0.5) - np.maximum(samples[axis] - samples[side] / 2, -0.5),
            0,
            None,
        )
        for axis, side, size in zip("xy", ("width", "height"), sensor, strict=True)
    ]
    samples["occluded"] = 1 - within[0] * within[1] / (samples["width"] * samples["height"])
    return samples.ravel()


def on_sensor(samples: NDArray[np.void], sensor: tuple[int, int]) -> NDArray[np.bool_]:
    """Whether each sample's centre lies on the sensor."""
    inside: NDArray[np.bool_] = np.ones(samples.shape, bool)
    for axis, size in zip("xy", sensor, strict=True):
        inside &= (samples[axis] >= -0.5) & (samples[axis] < size - 0.5)
    return inside


@dataclass(frozen=True, eq=False)
class Scene:
    """A simulated recording, its ground truth, and the seed."""

    recording: Recording
    truth: Truth
    seed: int

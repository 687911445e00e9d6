# SPDX-License-Identifier: Apache-2.0
"""What is known exactly about a simulated scene: rectangles on piecewise straight paths.

Positions are in event coordinates: the centre of pixel (x, y) lies at (x, y), so a truth centre and a tracker's centre of
mass compare as they are.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["TRUTH", "Box", "Truth", "sample"]

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
    ]
)


@dataclass(frozen=True, eq=False)
class Box:
    """A rectangle that moves in a straight line from each waypoint to the next, and stands still after the last.

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
        """Exact velocity at times of any shape, pixels per second; at a waypoint, that of the stretch after it."""
        leg = np.searchsorted(self.t_us, t_us, side="right")
        seconds = np.diff(self.t_us) * 1e-6
        vx, vy = (np.concatenate(([0.0], np.diff(axis) / seconds, [0.0])) for axis in (self.x, self.y))
        return vx[leg], vy[leg]


@dataclass(frozen=True, eq=False)
class Truth:
    """The objects of a scene: sampled, and in closed form.

    Attributes:
        samples: (objects * times,) of dtype `TRUTH`, by time, then by object: centre in event coordinates and size in pixels,
            velocity in pixels per second; `visible` while the centre lies on the sensor.
        boxes: the objects themselves; `object_id` is the index.
    """

    samples: NDArray[np.void]
    boxes: tuple[Box, ...]


def sample(boxes: tuple[Box, ...], times_us: NDArray[np.int64], sensor: tuple[int, int]) -> NDArray[np.void]:
    """`Truth.samples` of boxes at (k,) times before a sensor of (width, height) pixels."""
    samples = np.zeros((len(times_us), len(boxes)), TRUTH)
    samples["t_us"] = times_us[:, None]
    samples["object_id"] = np.arange(len(boxes))
    for i, box in enumerate(boxes):
        column = samples[:, i]
        column["x"], column["y"] = box.centre(times_us)
        column["vx"], column["vy"] = box.velocity(times_us)
        column["width"], column["height"] = box.width, box.height
    on_sensor = [(samples[axis] >= -0.5) & (samples[axis] < size - 0.5) for axis, size in zip("xy", sensor, strict=True)]
    samples["visible"] = on_sensor[0] & on_sensor[1]
    return samples.ravel()

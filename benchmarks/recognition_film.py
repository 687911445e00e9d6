# SPDX-License-Identifier: Apache-2.0
"""A film of classified tracks, docs/images/recognition.gif: outlines of four shapes, and what the classifier calls them.

    python benchmarks/recognition_film.py            # writes the film, and prints how many tracks have the right class
    python benchmarks/recognition_film.py --keep DIR # keeps recordings, labels, weights and logs there, for other commands

It runs the commands of docs/recognition.md: `evcot train`, `track`, `evaluate` and `render`.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

import evcot
from evcot.events import Events, Recording
from evcot.tracks.formats.base import BOX, Boxes, FrameClock
from evcot.tracks.formats.registry import write_boxes
from evcot_cosim.cli import main as run_command

SENSOR = 240, 180
NAMES = {1: "square", 2: "triangle", 3: "cross", 4: "disc"}
SIDE_PX = 34.0
EVENTS_PER_S = 40_000  # of a shape
NOISE_PER_S = 4_000  # over the sensor
INSTANT_US = 10_000  # between two labels


class Way(NamedTuple):
    """A Lissajous figure around a point, in pixels; `speed` in rad/s."""

    middle: NDArray[np.float64]
    speed: NDArray[np.float64]
    phase: NDArray[np.float64]

    def at(self, t_us: NDArray[np.float64] | NDArray[np.int64]) -> NDArray[np.float64]:
        """Positions at n times, (n, 2)."""
        return np.asarray(self.middle + (32, 20) * np.sin(t_us[:, None] / 1e6 * self.speed + self.phase), np.float64)


def outline(class_id: int, count: int, random: np.random.Generator) -> NDArray[np.float64]:
    """Points at random on the outline of a shape of side 1 around (0, 0), (count, 2)."""
    if NAMES[class_id] == "disc":
        angle = random.uniform(0, 2 * np.pi, count)
        return np.stack((np.cos(angle), np.sin(angle)), axis=1) / 2
    corners = {
        "square": [(-1, -1), (1, -1), (1, 1), (-1, 1)],
        "triangle": [(0, -1), (1, 1), (-1, 1)],
        "cross": [(-3, -9), (3, -9), (3, -3), (9, -3), (9, 3), (3, 3), (3, 9), (-3, 9), (-3, 3), (-9, 3), (-9, -3), (-3, -3)],
    }[NAMES[class_id]]
    path = np.array([*corners, corners[0]], float)
    path /= 2 * np.abs(path).max()
    lengths = np.hypot(*np.diff(path, axis=0).T)
    along = random.uniform(0, lengths.sum(), count)
    ends = np.append(0, np.cumsum(lengths))
    return np.stack([np.interp(along, ends, path[:, axis]) for axis in (0, 1)], axis=1)


def scene(seed: int, seconds: float) -> tuple[Recording, Boxes]:
    """Four shapes, each in its own quarter, on Lissajous figures; their labelled boxes."""
    random = np.random.default_rng(seed)
    count = int(EVENTS_PER_S * seconds)
    noise = int(NOISE_PER_S * seconds)
    parts = [np.column_stack((random.uniform(0, 1e6 * seconds, noise), random.uniform(0, 1, (noise, 2)) * SENSOR))]
    instants_us = np.arange(0, int(1e6 * seconds), INSTANT_US)
    rows = []
    for quarter, class_id in enumerate(random.permutation(list(NAMES)).tolist()):
        middle = np.array([(quarter % 2 + 0.5) * SENSOR[0], (quarter // 2 + 0.5) * SENSOR[1]]) / 2
        way = Way(middle, random.uniform(1.5, 3, 2), random.uniform(0, 2 * np.pi, 2))
        side = SIDE_PX * random.uniform(0.85, 1.15)

        t_us = np.sort(random.uniform(0, 1e6 * seconds, count))
        places = way.at(t_us) + side * outline(class_id, count, random) + random.normal(0, 0.4, (count, 2))
        parts.append(np.column_stack((t_us, places)))
        own = np.zeros(len(instants_us), BOX)
        own["instant"], own["id"], own["class_id"] = np.arange(len(instants_us)), quarter, class_id
        own["left"], own["top"] = (way.at(instants_us) - side / 2).T
        own["width"] = own["height"] = side
        own["confidence"] = own["visibility"] = 1.0
        own["counted"] = True
        rows.append(own)
    points = np.concatenate(parts)
    points = points[np.argsort(points[:, 0], kind="stable")]
    x, y = (np.rint(points[:, axis]).clip(0, size - 1).astype(np.uint16) for axis, size in ((1, SENSOR[0]), (2, SENSOR[1])))
    events = Events(points[:, 0].astype(np.int64), x, y, random.integers(0, 2, len(points)).astype(np.uint8))
    boxes = np.concatenate(rows)
    boxes = boxes[np.argsort(boxes["instant"], kind="stable")]
    return Recording(events, *SENSOR, f"shapes{seed}"), Boxes(instants_us, boxes, SENSOR, class_names=NAMES)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--keep", type=Path, metavar="DIR", help="folder for all files")
    parser.add_argument("-o", "--output", type=Path, default=Path("docs/images/recognition.gif"), metavar="GIF")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.keep or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        seeds = dict.fromkeys((1, 2, 3), 6.0) | {9: 2.5}
        for seed, seconds in seeds.items():
            recording, boxes = scene(seed, seconds)
            evcot.write(recording, folder / f"{seed}.aedat4", force=True)
            write_boxes(folder / f"{seed}.json", boxes, FrameClock(INSTANT_US), force=True)
        learned, labels = ([str(folder / f"{seed}.{suffix}") for seed in (1, 2, 3)] for suffix in ("aedat4", "json"))
        weights, log, new = (str(folder / name) for name in ("shapes.npz", "log.npz", "9.aedat4"))
        force = ["--force"]
        for command in (
            ["train", *learned, "--labels", *labels, "--window-log2", "9", "-o", weights, *force],
            ["track", new, "--classify", weights, "-o", log, *force],
            ["evaluate", log, "--truth", str(folder / "9.json")],
            [
                "render",
                new,
                log,
                "-o",
                str(options.output),
                "--to",
                "1500",
                "--fps",
                "10",
                "--speed",
                "0.5",
                "--width",
                "480",
                *force,
            ],
        ):
            assert run_command(command) == 0, command


if __name__ == "__main__":
    main()

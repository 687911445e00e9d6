# SPDX-License-Identifier: Apache-2.0
"""Speed of the simulation of scenes, and of the pixel model alone, on one thread."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from evcot.scenes import SCENES, PixelCamera, PixelModel, simulate_scene
from measure import Clock, Goal, Result, Timing, take_turns, timed

__all__ = ["measure"]

_BOXES_GOAL_M, _GOAL_M = 20.0, 2.0
_FRAMES = 10


def measure(_folder: Path, quick: bool) -> Iterator[Result]:
    """pixel_rate, and scene_rate_NAME of every scene."""
    seconds = 0.5 if quick else 2.0
    counts: dict[str, int] = {}

    def scene(name: str) -> Timing:
        # The box experiment at its full length: its events are made all at once.
        overrides = {} if name == "boxes" else {"duration_us": round(seconds * 1e6)}

        def work() -> None:
            counts[name] = len(simulate_scene(name, 1, overrides).recording.events)

        return timed(work)

    random = np.random.default_rng(1)
    frames = [random.random((260, 346)) * 2 for _ in range(_FRAMES)]

    def pixels() -> Timing:
        camera = PixelCamera(PixelModel(mismatch=0.03), 346, 260, 1)

        def work() -> None:
            counts["pixels"] = sum(len(camera.step(frame, 1_000 * i)) for i, frame in enumerate(frames))

        return timed(work)

    runs = {"pixels": pixels} | {name: lambda name=name: scene(name) for name in SCENES}  # type: ignore[misc]
    turns = take_turns(runs, 3 if quick else 7)
    rate = counts["pixels"] / turns.seconds("pixels", Clock.CPU) / 1e6
    yield Result("pixel_rate", rate, "M events/s", how="full 346x260 frames of random light; CPU time")
    for name in SCENES:
        took_s = turns.seconds(name, Clock.CPU)
        rate = counts[name] / took_s / 1e6
        if name == "boxes":
            goal = Goal(1)
            yield Result(f"scene_rate_{name}", rate, "M events/s", _BOXES_GOAL_M, "goal", goal=goal, how="default; CPU time")
        else:
            how = f"{took_s / seconds:.2f} s of CPU per simulated second, truth included"
            yield Result(f"scene_rate_{name}", rate, "M events/s", _GOAL_M, "goal", goal=Goal(1), how=how)

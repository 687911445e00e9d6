# SPDX-License-Identifier: Apache-2.0
"""Cars, lorries and people on the simulated motorway: how often the class of a track is right, by image, size and speed.

    python benchmarks/vehicles.py           # validation: trained on seeds 1 to 24, scored on 25 to 36
    python benchmarks/vehicles.py --test    # scored on seeds 101 to 124, which were used for nothing else

The class of a track is that of its last verdict; its true class that of the labelled box which most of its windows lie in.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from evcot.recognition.training import (
    UNLABELLED,
    LabelledWindows,
    fitted_size_speed,
    label_windows,
    registers_for,
    train,
    verdicts_of,
    windows_of,
)
from evcot.recognition.weights import Weights, inputs_of
from evcot.scenes.registry import simulate_scene
from evcot.scenes.truth import ObjectClass
from evcot.tracks.formats.base import Boxes
from recognition import config_for, in_blocks

CLASSES = ObjectClass.CAR, ObjectClass.LORRY, ObjectClass.PERSON
TRAINING, VALIDATION, TEST = range(1, 25), range(25, 37), range(101, 125)
SCENE = {
    "duration_us": 20_000_000, "truth_step_us": 10_000, "story": 0, "lorry_share": 0.3, "crossing": 1, "loitering": 2,
}  # fmt: skip
LONG = 10  # windows of a track
INPUTS = {"image": (), "image, size": (0, 1), "image, speed": (2,), "image, size, speed": (0, 1, 2)}


class Found(NamedTuple):
    """Windows of all recordings; the recording of a track is its id >> 32, its recording's seed."""

    windows: LabelledWindows
    states: NDArray[np.void]
    labels: list[Boxes]


def found_in(seeds: Iterable[int], scale_start: int | None = None) -> Found:
    """Simulate recordings and run the tracker over them; without a start scale, that of their labels."""
    scenes = {seed: simulate_scene("highway", seed, SCENE) for seed in seeds}
    labels = [scene.truth.labelled_boxes() for scene in scenes.values()]
    registers = registers_for(labels) if scale_start is None else replace(registers_for(labels), scale_start=scale_start)
    parts, states = [], []
    for (seed, scene), boxes in zip(scenes.items(), labels, strict=True):
        windows = windows_of(in_blocks(scene.recording.events), config_for(scene.recording), registers)
        found = label_windows(windows, boxes)
        parts.append(replace(found, track_id=found.track_id + (seed << 32)))
        states.append(windows.states)
    return Found(LabelledWindows.of(parts), np.concatenate(states), labels)


def of_classes(found: Found) -> LabelledWindows:
    """The windows; those of animals without a label, since the network has three classes."""
    class_id = np.where(np.isin(found.windows.class_id, CLASSES), found.windows.class_id, UNLABELLED)
    return replace(found.windows, class_id=class_id)


def last_and_true(windows: LabelledWindows) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Of each track the row of its last window, the class of its object, and the number of its windows."""
    tracks, track, counts = np.unique(windows.track_id, return_inverse=True, return_counts=True)
    last = np.zeros(len(tracks), np.int64)
    np.maximum.at(last, track, np.arange(len(track)))
    names, name = np.unique(windows.class_id, return_inverse=True)
    met = np.zeros((len(tracks), len(names)), np.int64)
    np.add.at(met, (track, name), 1)
    return last, names[met.argmax(axis=1)], counts


def print_scores(weights: Weights, trained: Found, scored: Found) -> None:
    """The share of right tracks, its standard error over recordings, the share of long tracks, and the recall of each class."""
    windows = of_classes(scored)
    last, true, counts = last_and_true(windows)
    winner, margin, voted = verdicts_of(weights, windows)
    class_ids = np.array(weights.class_ids)
    labelled, recording = true != UNLABELLED, windows.track_id[last] >> 32
    classes = len(class_ids)
    for name, used in INPUTS.items():
        index = winner
        if used:
            constant = [trained.states.copy(), scored.states.copy()]
            for states in constant:
                for field in (*(() if 0 in used else ("width", "height")), *(() if 2 in used else ("vx", "vy"))):
                    states[field] = 1.0
            table = fitted_size_speed(weights, of_classes(trained), constant[0])
            index = np.argmax(inputs_of(winner, margin, voted, constant[1], classes) @ table, axis=1)
        right = class_ids[index[last]] == true
        shares = [right[labelled & (recording == seed)].mean() for seed in np.unique(recording[labelled])]
        error = np.std(shares, ddof=1) / len(shares) ** 0.5
        long = labelled & (counts >= LONG)
        recall = ", ".join(f"{one.name.lower()} {right[true == one].mean():.2f} of {(true == one).sum()}" for one in CLASSES)
        print(
            f"{name:18s} tracks {right[labelled].mean():.3f} +- {error:.3f} of {labelled.sum()}; "
            f"of {LONG} windows and more {right[long].mean():.3f} of {long.sum()}; recall: {recall}", flush=True,
        )  # fmt: skip
    print(f"{(~labelled).sum()} tracks with a verdict are of no car, lorry or person: they get a class, too")


def main() -> None:
    """Train, and score the validation or the test set."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--test", action="store_true", help="score the test set")
    parser.add_argument("--seed", type=int, default=1, help="seed of the training")
    options = parser.parse_args()
    trained = found_in(TRAINING)
    registers = registers_for(trained.labels)
    weights = train(of_classes(trained), registers, "cot_motion", options.seed)
    print(f"{'test' if options.test else 'validation'}; start scale {registers.scale_start}")
    print_scores(weights, trained, found_in(TEST if options.test else VALIDATION, registers.scale_start))


if __name__ == "__main__":
    main()

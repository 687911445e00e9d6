# SPDX-License-Identifier: Apache-2.0
"""`evcot train`: labelled recordings into the weights of a classifier."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from evcot.errors import ConfigError, TrackLogError
from evcot.hardware.config import MotionConfig
from evcot.hardware.modules import DEFAULT_MODULE
from evcot.recognition.training import (
    UNLABELLED,
    LabelledWindows,
    fitted_size_speed,
    label_windows,
    registers_for,
    train,
    windows_of,
)
from evcot.trackers.presets import fit
from evcot.trackers.settings import engine_settings
from evcot.tracks.formats.base import Boxes
from evcot.tracks.formats.registry import read_boxes

from ...standard_streams import as_file
from ...tables import print_table
from ..options import clock_from
from .files import open_from
from .spinner import Counting

__all__ = ["run"]


def run(options: argparse.Namespace, _arguments: Sequence[str]) -> int:
    """Train a classifier; 0."""
    if len(options.labels) != len(options.recordings):
        given = f"{len(options.labels)} files of labels, {len(options.recordings)} recordings"
        raise ConfigError(f"--labels: {given}: must be one for each recording, in the same order")
    clock = clock_from(options)
    labels = [read_boxes(as_file(path), clock, options.labels_format) for path in options.labels]
    names = _names(options.labels, labels)
    registers = registers_for(labels, options.window_log2, options.margin_min)
    parts: list[LabelledWindows] = []
    states = []
    for path, label_path, boxes in zip(options.recordings, options.labels, labels, strict=True):
        with open_from(options, path) as file, Counting(f"tracking {path}", enabled=not options.json) as counting:
            run_config, filters = engine_settings(DEFAULT_MODULE, file.sensor, options.preset, options.config, mark="--")
            config = replace(fit(run_config, *file.sensor), filters=filters).device_config(*file.sensor)
            assert isinstance(config, MotionConfig)
            windows = windows_of(counting.watched(file.blocks(required=True), file.t0_us), config, registers)
        found = label_windows(windows, boxes)
        if len(windows.t_us) and (found.class_id == UNLABELLED).all():
            raise TrackLogError(f"{label_path}: no track of {path} is in a box: must be the labels of this recording")
        parts.append(replace(found, track_id=found.track_id + (len(parts) << 32)))
        states.append(windows.states)
    with Counting("training", enabled=not options.json):
        every = LabelledWindows.of(parts)
        weights = train(every, registers, config.module, options.seed).named(names)
        if options.size_speed:
            weights = replace(weights, size_speed=fitted_size_speed(weights, every, np.concatenate(states)))
    weights.save(options.output, force=options.force)
    class_id = np.concatenate([part.class_id for part in parts])
    counts = {name: int((class_id == number).sum()) for number, name in weights.names.items()}
    if options.json:
        said = {"weights": str(options.output), "windows": counts}
        print(json.dumps(said | {"unlabelled": int((class_id == UNLABELLED).sum())}, indent=2))
    else:
        print_table([("class", "windows"), *((name, f"{count:,}") for name, count in counts.items())])
    return 0


def _names(paths: Sequence[Path], labels: Sequence[Boxes]) -> dict[int, str]:
    """The names of the classes in all files; ConfigError for a class that two files name differently, or one name twice."""
    names: dict[int, str] = {}
    for path, boxes in zip(paths, labels, strict=True):
        for number, name in boxes.class_names.items():
            if names.setdefault(number, name) != name:
                raise ConfigError(f"{path}: class {number} = {name!r}: must be {names[number]!r}, as in the files before")
    if len(set(names.values())) < len(names):
        twice = next(name for name in names.values() if list(names.values()).count(name) > 1)
        numbers = ", ".join(str(number) for number, name in names.items() if name == twice)
        raise ConfigError(f"--labels: classes {numbers} = {twice!r}: must have different names")
    return names

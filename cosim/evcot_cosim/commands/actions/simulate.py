# SPDX-License-Identifier: Apache-2.0
"""`evcot simulate`: a scene, a video or a folder of images into a recording, and the truth beside it."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from dataclasses import asdict
from pathlib import Path
from typing import Any

from evcot.errors import ConfigError, meant
from evcot.events import Events
from evcot.outputs import written_aside
from evcot.ranges import read_pair
from evcot.recordings.files import write_events
from evcot.scenes.registry import SCENES, adjusted, scene_settings
from evcot.tracks.formats.base import FrameClock
from evcot.tracks.formats.coco import CocoBoxes

from ...standard_streams import STANDARD_OUTPUT, format_name
from ..options import sensor_from
from .spinner import Counting

__all__ = ["run"]


def run(options: argparse.Namespace, _arguments: Sequence[str]) -> int:
    """Write a simulated recording and its truth, or list the scenes; 0."""
    if options.list:
        _list(options)
        return 0
    if options.scene is None:
        raise ConfigError(f"SCENE: must be one of {', '.join(SCENES)}, a video file or a folder of images")
    if options.output is None:
        raise ConfigError("-o FILE: must say where the recording goes")
    with Counting(f"simulating {options.scene}", enabled=not (options.quiet or options.json)):
        report = _scene(options) if options.scene in SCENES else _footage(options)
    if options.json:
        print(json.dumps(report, indent=2, allow_nan=False))
    elif not options.quiet:
        beside = f"; the truth in {report['truth']}" if report["truth"] else ""
        print(f"{report['events']:,} events, {report['width']}x{report['height']} pixels, in {report['recording']}{beside}")
    return 0


def _list(options: argparse.Namespace) -> None:
    if options.scene is not None:
        settings = _flat(asdict(scene_settings(options.scene)))
        if options.json:
            print(json.dumps(settings, indent=2))
        else:
            for key, value in settings.items():
                print(f"{key} = {value}")
    elif options.json:
        print(json.dumps({name: kind.title for name, kind in SCENES.items()}, indent=2))
    else:
        for name, kind in SCENES.items():
            print(f"{name:10}{kind.title}")


def _scene(options: argparse.Namespace) -> dict[str, Any]:
    name = options.scene
    settings = scene_settings(name, options.seed, _overrides(options, name))
    if options.output == STANDARD_OUTPUT and options.truth is None:
        raise ConfigError("--truth: must be given with -o -: standard output has no folder for it")
    truth_path = options.truth or options.output.with_name(f"{options.output.stem}.truth.csv")
    options.claims.write("--truth", truth_path, force=options.force)

    def blocks() -> Iterator[Events]:  # simulated only once the output can be written
        scene = SCENES[name].simulate(settings)
        scene.truth.write(truth_file)
        if labels_file is not None:
            CocoBoxes.write(labels_file, options.labels, scene.truth.labelled_boxes(sensor), FrameClock())
        yield scene.recording.events

    sensor, kind = (settings.width, settings.height), format_name(options.output)
    with ExitStack() as held:
        truth_file = held.enter_context(written_aside(truth_path, force=options.force))
        labels_file = options.labels and held.enter_context(written_aside(options.labels, force=options.force))
        count = write_events(options.output, sensor, blocks(), kind, force=options.force)
    return _report(options, count, settings.width, settings.height, settings, str(truth_path))


def _footage(options: argparse.Namespace) -> dict[str, Any]:
    from evcot.scenes.frames import Footage, open_film

    path = Path(options.scene)
    if not path.exists():
        rule = f"must be one of {', '.join(SCENES)}, a video file or a folder of images"
        raise ConfigError(f"SCENE {options.scene!r}: {rule}{meant(options.scene, SCENES)}")
    for option in ("sensor", "truth", "labels"):
        if getattr(options, option) is not None:
            raise ConfigError(f"--{option}: must not be given for footage, whose sensor is its own and whose truth is unknown")
    footage = adjusted("footage", Footage(), {"seed": options.seed, **_overrides(options, "footage")})
    film = open_film(path, footage)
    sensor, kind = (film.width, film.height), format_name(options.output)
    count = write_events(options.output, sensor, film.events(), kind, force=options.force)
    return _report(options, count, film.width, film.height, footage, None)


def _overrides(options: argparse.Namespace, name: str) -> dict[str, Any]:
    """What the command line changes in a scene's settings."""
    overrides: dict[str, Any] = {}
    if options.duration is not None:
        if not 0 < options.duration < 1e9:
            raise ConfigError(f"--duration {options.duration:g}: must be more than 0 seconds")
        overrides["duration_us"] = round(options.duration * 1e6)
    sensor = sensor_from(options)
    if sensor is not None:
        overrides["width"], overrides["height"] = sensor
    for setting in options.set:
        key, value = read_pair("--set", setting, f"; `evcot simulate {name} --list` shows the keys")
        overrides[key] = value
    return overrides


def _flat(settings: dict[str, Any]) -> dict[str, Any]:
    pixel: dict[str, Any] = settings.pop("pixel", {})
    return settings | pixel


def _report(
    options: argparse.Namespace, count: int, width: int, height: int, settings: Any, truth: str | None
) -> dict[str, Any]:
    return {
        "recording": str(options.output),
        "truth": truth,
        "scene": options.scene,
        "events": count,
        "width": width,
        "height": height,
        "settings": _flat(asdict(settings)),
    }

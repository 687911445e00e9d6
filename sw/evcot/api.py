# SPDX-License-Identifier: Apache-2.0
"""The commands as functions, which `import evcot` offers by name."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .errors import ConfigError, RecordingError
from .events import Events, Recording
from .filters.config import FilterConfig
from .metrics.rule import Rule, load_rule
from .metrics.scores import Scores, warn_of_other_truth
from .metrics.scores import evaluate as score
from .metrics.truth import GroundTruth, ground_truth_of, read_truth, rule_for
from .recordings.formats.source import Sensor
from .scenes.registry import simulate_scene
from .scenes.truth import Scene, Truth
from .trackers.config import RunConfig
from .trackers.engines import DEFAULT, ENGINES
from .trackers.settings import changed, engine_settings
from .tracks.formats.base import FrameClock
from .tracks.formats.of_log import log_of_boxes
from .tracks.formats.registry import is_boxes, read_boxes
from .tracks.log import TrackLog
from .tracks.log_files import in_the_name_of, open_log
from .tracks.tracking import Tracker, signed_log_of

if TYPE_CHECKING:
    from .hough.contract import HoughConfig

__all__ = ["evaluate", "filter_recording", "lines", "plot", "render", "simulate", "track", "tracker"]


def filter_recording(recording: Recording, config: FilterConfig | None = None, **settings: Any) -> Recording:
    """Filter a recording, as `evcot filter` does; returns the events that pass.

    Example:
        clean = evcot.filter(recording, refractory_us=1_000, activity_us=5_000)

    Args:
        config: the filters and their settings; None: all filters are off.
        settings: fields of `FilterConfig`, which replace those of `config`.

    Raises:
        ConfigError: no such field, a value outside its range, or a hot pixel outside the sensor.
    """
    from .filters.run import apply  # with Numba, which scoring does not need

    return apply(recording, changed("filters", config or FilterConfig(), settings))[0]


def track(
    source: Recording | Path | str,
    /,
    engine: str = DEFAULT,
    preset: str | None = None,
    *,
    config: Path | str | None = None,
    settings: Any = None,
    filters: FilterConfig | None = None,
    classify: Path | str | None = None,
    **changes: Any,
) -> TrackLog:
    """Track the objects in a recording, as `evcot track` does.

    Example:
        log = evcot.track("drive.aedat4", "rct", "traffic", radius_px=12.0)
        births = log.of_kind(evcot.Kind.BORN)  # (k,) of dtype evcot.TRACK: t_us, x, y, width, ...

    Args:
        source: a recording in memory, or a file in any format that evcot reads, which is read block by block.
        engine: one of `ENGINES`.
        preset: one of `ENGINES[engine].presets`; None: the first, of cot, cot_chain and cot_array the one for the sensor.
        config: a TOML file that overrides the preset.
        settings: an object with all of the engine's settings, in place of preset and file; for a hardware module a
            `RunConfig`.
        filters: those in front of the tracker; None: the preset's.
        classify: weights that `evcot train` wrote; the log then has verdicts. Only with the tracker of the weights.
        changes: fields of the engine's settings, which replace those of the preset; for "cot_motion" its registers.

    Returns:
        The records of every track (births, moves, merges, losses), and the owner of each event.

    Raises:
        ConfigError: no such engine, preset or setting, a value outside its range, or weights that cannot be used.
        RecordingError: a file that cannot be read, or holds no events.
    """
    with _blocks(source) as (blocks, sensor):
        made = tracker(sensor, engine, preset, config=config, settings=settings, filters=filters, classify=classify, **changes)
        return signed_log_of(engine, made, blocks)


def lines(source: Recording | Path | str, /, config: HoughConfig | None = None) -> NDArray[np.void]:
    """Follow straight lines in a recording: their angle and distance from the middle of the sensor over time (docs/lines.md).

    Example:
        lines = evcot.lines("bar.aedat4")
        lines["angle_deg"][lines["line_id"] == 1]  # (k,) degrees, continuous

    Args:
        source: a recording in memory, or a file in any format that evcot reads, which is read block by block.
        config: the transform; None: the default for the sensor.

    Returns:
        (n,) of dtype `hough.follower.LINE`: t_us (microseconds), line_id, angle_deg (degrees), rho_px (pixels), turn_deg_s
        (degrees per second); one entry for each spike of a line, in time order.

    Raises:
        ConfigError: a sensor of more than 2048 pixels across or down, or a configuration for another sensor.
        RecordingError: a file that cannot be read, or holds no events.
    """
    from .hough.contract import HoughConfig
    from .hough.follower import LINE, LineFollower  # with Numba

    with _blocks(source) as (blocks, (width, height)):
        config = config or HoughConfig(width, height)
        if (config.width, config.height) != (width, height):
            raise ConfigError(f"hough sensor {config.width}x{config.height}: must be the recording's, {width}x{height}")
        follower = LineFollower(config)
        return np.concatenate([np.empty(0, LINE), *(follower.feed(block) for block in blocks)])


def tracker(
    sensor: Sensor,
    engine: str = DEFAULT,
    preset: str | None = None,
    *,
    config: Path | str | None = None,
    settings: Any = None,
    filters: FilterConfig | None = None,
    classify: Path | str | None = None,
    **changes: Any,
) -> Tracker:
    """A tracker for a stream of events, as `track` runs it over a recording.

    Example:
        tracker = evcot.tracker((346, 260))
        records, owner = tracker.feed(events)  # (m,) of dtype evcot.TRACK; (n,) int16

    Args:
        sensor: (width, height) in pixels.
        engine, preset, config, settings, filters, classify, changes: as of `track`.

    Raises:
        ConfigError: no such engine, preset or setting, or a value outside its range.
    """
    file = Path(config) if config is not None else None
    default, own = engine_settings(engine, sensor, preset, file)
    if settings is not None:
        if preset is not None or config is not None:
            raise ConfigError("settings: must not be given with preset or config")
        if not isinstance(settings, type(default)):
            kind, wanted = type(settings).__name__, type(default).__name__
            raise ConfigError(f"settings of type {kind}: must be {wanted} with engine {engine}")
        if isinstance(settings, RunConfig) and settings.hardware.module != engine:
            module = settings.hardware.module
            raise ConfigError(f"settings: are of {module}: must be given with engine {module}")
        default, own = settings, settings.filters if isinstance(settings, RunConfig) else FilterConfig()
    own = own if filters is None else filters
    own_settings = changed(engine, default, changes)
    if classify is None:
        return ENGINES[engine].start(own_settings, own, sensor)
    from .recognition.tracker import start_classifying
    from .recognition.weights import Weights

    return start_classifying(engine, own_settings, own, sensor, Weights.load(classify))


def plot(
    recording: Recording,
    logs: Mapping[str, TrackLog],
    path: Path | str,
    panels: Sequence[str] = ("tracks",),
    *,
    width_mm: float = 85.0,
    dpi: int = 300,
    force: bool = False,
) -> None:
    """Draw tracks over events as a figure, as `evcot plot` does.

    Example:
        evcot.plot(recording, {"rct": log}, "tracks.png", ("tracks", "xy"))

    Args:
        logs: name in the figure -> track log.
        path: of the figure; its suffix chooses the format.
        panels: names of `evcot plot --kind`.
        force: replace a file that exists.

    Raises:
        ConfigError: no such panel or format.
        OutputError: the file exists, or cannot be written.
    """
    from .pictures.plots import Log, Material, density
    from .pictures.plots import plot as draw

    counts, first_us, last_us = density([recording.events], (recording.width, recording.height))
    material = Material(counts, tuple(Log(name, log) for name, log in logs.items()), first_us, last_us, first_us)
    draw(material, Path(path), tuple(panels), width_mm=width_mm, dpi=dpi, force=force)


def render(
    recording: Recording,
    logs: Mapping[str, TrackLog],
    path: Path | str,
    *,
    speed: float = 1.0,
    fps: float = 30.0,
    force: bool = False,
) -> None:
    """Write a film of tracks over events, as `evcot render` does.

    Example:
        evcot.render(recording, {"rct": log}, "tracks.gif", speed=0.25)

    Args:
        logs: name in the film -> track log.
        path: of the film; its suffix chooses the format.
        speed: seconds of the recording per second of the film.
        fps: pictures per second of the film.
        force: replace a file that exists.

    Raises:
        ConfigError: no such format, a missing package, or a value outside its range.
        OutputError: the file exists, or cannot be written.
        RecordingError: a recording without events.
    """
    from .pictures.films import Look, side_of
    from .pictures.films import render as film

    times_us = recording.events.t_us
    if not len(times_us):
        raise RecordingError(f"{recording.name}: holds no events: a film needs one at least")
    sides = [side_of(place, name, log) for place, (name, log) in enumerate(logs.items())]
    window = int(times_us[0]), int(times_us[-1])
    sensor = recording.width, recording.height
    film([recording.events], sensor, sides, path, window, Look(speed, fps), force=force)


def simulate(scene: str, seed: int = 1, **settings: Any) -> Scene:
    """Simulate a scene, as `evcot simulate` does: its events, and the truth about its objects.

    Example:
        scene = evcot.simulate("discs", seed=3, duration_us=500_000)
        scene.recording.events.t_us  # (n,) int64, microseconds

    Args:
        scene: one of `SCENES`.
        seed: seeds all random numbers; the same seed gives the same events.
        settings: fields of the scene's settings or of its pixel model; `evcot simulate SCENE --list` shows them.

    Raises:
        ConfigError: no such scene or setting, or a value outside its range.
    """
    return simulate_scene(scene, seed, settings)


def evaluate(
    log: TrackLog | Path | str,
    truth: GroundTruth | Truth | Path | str,
    rule: Rule | Path | str | None = None,
    *,
    sensor: Sensor | None = None,
    clock: FrameClock | None = None,
    log_format: str | None = None,
    truth_format: str | None = None,
) -> Scores:
    """Score tracks against a ground truth, as `evcot evaluate` does.

    Example:
        scene = evcot.simulate("discs")
        evcot.evaluate(evcot.track(scene.recording), scene.truth).hota

    Args:
        log: a track log, the file of one, or a file of boxes of any tracker.
        truth: the truth of a scene, one that was read by `read_truth`, a CSV file, or a file of boxes.
        rule: how the truth is read and scored: a rule, the name of one in `metrics.RULES`, or a TOML file; None: the rule for
            scenes, or the one with the file's columns.
        sensor: (width, height) in pixels; None: the rule's.
        clock: the times of frames, for files of boxes that number frames.
        log_format, truth_format: names of box formats, of `tracks.formats.registry.FORMATS`; None: chosen by the files' names.

    Raises:
        TrackLogError: a log or boxes that cannot be used, or whose times lie apart from those of the truth.
        ConfigError: a rule that cannot be used, or no rule for a truth that was read by `read_truth`.
        RecordingError: a truth that cannot be read.

    Warns:
        RecordingWarning: hardly any track meets an object, as with the truth of another recording.
    """
    chosen = _rule(truth, rule, truth_format).on(sensor)
    name = str(truth) if isinstance(truth, Path | str) else "truth"
    if isinstance(truth, Truth):
        truth = ground_truth_of(truth, chosen)
    elif not isinstance(truth, GroundTruth):
        truth = read_truth(truth, chosen, clock=clock, format=truth_format)
    if isinstance(log, TrackLog):
        scores = score(log, truth, chosen)
    else:
        boxes = log_format is not None or is_boxes(log)
        opened = log_of_boxes(log, read_boxes(log, clock, log_format)) if boxes else open_log(log)
        with in_the_name_of(log):
            scores = score(opened, truth, chosen)
    warn_of_other_truth(scores, name)
    return scores


@contextmanager
def _blocks(source: Recording | Path | str) -> Iterator[tuple[Iterator[Events], Sensor]]:
    """The events of a recording, and its sensor."""
    if isinstance(source, Recording):
        yield iter([source.events]), (source.width, source.height)
        return
    from .recordings.files import open_recording  # with Numba

    with open_recording(source) as file:
        yield file.blocks(required=True), file.sensor


def _rule(truth: GroundTruth | Truth | Path | str, rule: Rule | Path | str | None, truth_format: str | None) -> Rule:
    if isinstance(rule, Rule):
        return rule
    if rule is not None:
        return load_rule(rule)
    if isinstance(truth, GroundTruth):
        raise ConfigError("rule: must be given with a truth that was read already")
    return load_rule("scene") if isinstance(truth, Truth) else rule_for(truth, truth_format)

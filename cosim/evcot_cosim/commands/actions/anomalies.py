# SPDX-License-Identifier: Apache-2.0
"""`evcot anomalies`: flag unusual trajectories, or learn which are normal."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import asdict, fields
from typing import Any

from evcot.anomalies import AnomalyConfig, FieldConfig, NormalMotion, Verdict, Zones, anomalies, learn, load_zones
from evcot.anomalies.alarm import check_table_path, rows, write_alarms
from evcot.anomalies.learn import smallest_sensor
from evcot.errors import ConfigError
from evcot.ranges import read_pair
from evcot.recordings.files import open_recording
from evcot.scenes.registry import adjusted
from evcot.tracks.log_files import Extent, RecordRuns, in_the_name_of, open_log

from ...standard_streams import as_file
from ...tables import counted, print_table
from ..options import sensor_from
from .files import check_logs
from .spinner import Counting

__all__ = ["run"]


def run(options: argparse.Namespace, _arguments: Sequence[str]) -> int:
    """Learn normal motion, or find what does not fit it; 0."""
    with Counting("reading", enabled=not options.json):
        sensor, logs = _logs(options)
    return _learn(options, logs, sensor) if options.learn else _watch(options, logs, sensor)


def _logs(options: argparse.Namespace) -> tuple[tuple[int, int] | None, list[RecordRuns]]:
    """The sensor, where somebody says it, and the logs."""
    sensor = sensor_from(options)
    logs: list[RecordRuns] = [open_log(as_file(path)) for path in options.logs]
    if options.recording is not None:
        sensor = _check_recording(options, logs, sensor)
    return sensor, logs


def _check_recording(
    options: argparse.Namespace, logs: Sequence[RecordRuns], sensor: tuple[int, int] | None
) -> tuple[int, int]:
    with open_recording(as_file(options.recording), sensor) as file:
        check_logs(zip(options.logs, logs, strict=True), str(options.recording), Extent.of(file.blocks(required=True)))
        return file.sensor


def _learn(options: argparse.Namespace, logs: Sequence[RecordRuns], sensor: tuple[int, int] | None) -> int:
    for option in ("normal", "zones", "picture"):
        if getattr(options, option) is not None:
            raise ConfigError(f"--{option}: must not be given with --learn")
    if options.output is None or options.output.suffix.lower() != ".npz":
        raise ConfigError("-o FILE.npz: must say where normal motion goes")
    overrides = _overrides(options)
    of_field = {key: overrides.pop(key) for key in [f.name for f in fields(FieldConfig)] if key in overrides}
    config = adjusted("anomalies", AnomalyConfig(), overrides)
    normal = learn(logs, sensor, adjusted("field", FieldConfig(), of_field), config)
    normal.save(options.output, force=options.force)
    width, height = normal.sensor
    report = {
        "normal": str(options.output), "tracks": normal.tracks, "width": width, "height": height,
        "cells": int((normal.smoothed().support >= config.min_support).sum()),
    }  # fmt: skip
    if options.json:
        print(json.dumps(report, indent=2))
    else:
        cells = f"{report['cells']} cells with enough tracks to judge by"
        print(f"{report['tracks']} tracks, {cells}, {width}x{height} pixels, in {options.output}")
    return 0


def _watch(options: argparse.Namespace, logs: Sequence[RecordRuns], sensor: tuple[int, int] | None) -> int:
    if len(logs) != 1:
        raise ConfigError(f"{len(logs)} logs: must be one, unless --learn is given")
    if options.output is not None:
        check_table_path(options.output)
    (log,) = logs
    config = adjusted("anomalies", AnomalyConfig(), _overrides(options))
    normal = NormalMotion.load(options.normal) if options.normal else None
    zones = load_zones(options.zones) if options.zones else Zones()
    known = (normal.sensor if normal else None) or zones.sensor
    if sensor is not None and known is not None and sensor != known:
        told = ["x".join(map(str, size)) for size in (sensor, known)]
        raise ConfigError(f"sensor {told[0]}: must be that of the normal motion and the zones, {told[1]}")
    with Counting("looking for anomalies", enabled=not options.json), in_the_name_of(options.logs[0]):
        verdict = anomalies(log, config, normal, zones)
    table = rows(verdict.alarms, [zone.name for zone in zones.zones], [line.name for line in zones.lines])
    if options.output is not None:
        write_alarms(options.output, table, force=options.force)
    if options.picture is not None:
        from evcot.anomalies.picture import draw_alarms

        size = sensor or known or smallest_sensor(logs)
        title = f"{options.logs[0].name}: {counted(len(table), 'alarm')} (kind, track, time)"
        draw_alarms(log, verdict, options.picture, title, size, normal, zones, force=options.force)
    _report(options, verdict, table, zones, config)
    return 0


def _report(
    options: argparse.Namespace,
    verdict: Verdict,
    table: list[dict[str, Any]],
    zones: Zones,
    config: AnomalyConfig,
) -> None:
    lines = [
        {"name": line.name, "to_right": int(right), "to_left": int(left)}
        for line, (right, left) in zip(zones.lines, verdict.counts, strict=True)
    ]
    if options.json:
        report = {"tracks": verdict.tracks, "alarms": table, "lines": lines, "settings": asdict(config)}
        print(json.dumps(report, indent=2, allow_nan=False))
        return
    if table:
        head = ("time s", "track", "kind", "where", "x", "y", "seen", "expected", "unit", "score", "after s")
        print_table([head, *map(_row, table)])
    for line in lines:
        print(f"{line['name']}: {line['to_right']} to the right, {line['to_left']} to the left")
    print(f"{counted(len(table), 'alarm')} on {counted(verdict.tracks, 'track')}")


def _row(alarm: dict[str, Any]) -> tuple[Any, ...]:
    after_s = (alarm["t_us"] - alarm["begin_us"]) * 1e-6
    return (
        f"{alarm['t_us'] * 1e-6:.3f}", alarm["track_id"], alarm["kind"], alarm["zone"] or "", f"{alarm['x']:.1f}",
        f"{alarm['y']:.1f}", f"{alarm['seen']:.4g}", f"{alarm['expected']:.4g}", alarm["unit"], f"{alarm['score']:.2f}",
        f"{after_s:.2f}",
    )  # fmt: skip


def _overrides(options: argparse.Namespace) -> dict[str, Any]:
    return dict(read_pair("--set", setting) for setting in options.set)

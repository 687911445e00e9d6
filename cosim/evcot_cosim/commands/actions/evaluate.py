# SPDX-License-Identifier: Apache-2.0
"""`evcot evaluate`: tracks against ground truth."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path

from evcot.api import evaluate
from evcot.errors import ConfigError, TrackLogError
from evcot.metrics.scores import ClassScores, Scores
from evcot.tracks import PARQUET
from evcot.tracks.log import TrackLog
from evcot.tracks.parquet import LogFile

from ...standard_streams import as_file
from ...tables import print_table
from ..options import RUN_LOGS, clock_from, sensor_from
from .files import done_each, log_of_run
from .spinner import Counting

__all__ = ["run"]

_HOTA_MEAN = "HOTA, mean of classes"


def run(options: argparse.Namespace, _arguments: Sequence[str]) -> int:
    """Score logs, or all of runs; 0, or 2 where one cannot be scored."""
    found: dict[str, Scores] = {}
    names = _names(options.logs)

    def score(given: Path) -> None:
        logs = _logs_of_run(options, given) if given.is_dir() else {"": as_file(given)}
        for name, log in logs.items():
            with Counting(f"scoring {log}", enabled=not options.json):
                found["/".join(filter(None, (names[given], name)))] = evaluate(
                    log, as_file(options.truth), options.rule, sensor=sensor_from(options), clock=clock_from(options),
                    log_format=options.log_format, truth_format=options.truth_format,
                )  # fmt: skip

    code = done_each(options, options.logs, score)[1]
    if options.json:
        figures = {name: scores.to_dict() for name, scores in found.items()}
        print(json.dumps(figures.get("", figures), indent=2, allow_nan=False))
    elif "" in found:
        print_table(_rows(found[""]))
    elif found:
        classified = any(scores.classes for scores in found.values())
        columns = [dict(_column(scores, classified=classified)) for scores in found.values()]
        print_table([("", *found), *((what, *(column[what] for column in columns)) for what in columns[0])])
    return code


def _names(paths: Sequence[Path]) -> dict[Path, str]:
    """What several logs and runs are called: by their own names, where these differ; a single one by none."""
    if len(paths) == 1:
        return {paths[0]: ""}
    names = [path.name if path.is_dir() else path.stem for path in paths]
    return {path: name if names.count(name) == 1 else str(path) for path, name in zip(paths, names, strict=True)}


def _logs_of_run(options: argparse.Namespace, folder: Path) -> dict[str, Path]:
    """The logs of a run by engine; ConfigError for a folder of none, TrackLogError for a log of other events than the run's."""
    from ...lockstep.run_file import RUN_FILE, read_run_file  # with Numba, which scoring does not need

    described = None
    if (folder / RUN_FILE).is_file():
        described = read_run_file(folder / RUN_FILE)
    if described is None:
        raise ConfigError(f"{folder}: is no folder of a run: must be a track log, boxes, or a folder of `evcot cosim`")
    if options.log_format is not None:
        raise ConfigError("--log-format: must not be given with the folder of a run, whose logs are its own")
    logs = {name: path for name in RUN_LOGS if (path := log_of_run(folder, name)).is_file()}
    for path in logs.values():
        of = LogFile(path).recording if path.suffix == PARQUET else TrackLog.load_npz(path).recording
        if of and described.digest and of != described.digest:
            raise TrackLogError(f"{path}: recording = {of!r}: must be the digest in {RUN_FILE}, {described.digest!r}")
    if not logs:
        raise ConfigError(f"{folder}: holds none of {', '.join(f'{name}.npz' for name in RUN_LOGS)}: run `evcot cosim` again")
    return logs


def _column(s: Scores, *, classified: bool) -> list[tuple[str, str]]:
    """The column of an engine in the table of a run: (what, value); `classified`: whether any engine has classes."""
    return [
        *((name, f"{getattr(s, name.lower()):.3f}") for name in ("HOTA", "DetA", "AssA", "LocA", "MOTA", "MOTP", "IDF1")),
        *((what, str(value)) for what, value in (
            ("found", s.tp), ("missed", s.fn), ("false", s.fp), ("switches", s.idsw), ("interruptions", s.frag),
            ("objects", s.truth_ids), ("mostly tracked", s.mt), ("mostly lost", s.ml), ("tracks", s.track_ids),
        )),
        ("position error, median", _with(s.position_error_px_median, "px")),
        ("velocity error, median", _with(s.velocity_error_median, "px/s")),
        ("stated velocity error, median", _with(s.stated_velocity_error_median, "px/s")),
        ("stated direction, median error", _with(s.stated_angle_error_deg_median, "degrees")),
        ("stated direction, over 45 degrees", _percent(s.stated_angle_over_45_deg_fraction)),
        ("stated velocity, relative error", _percent(s.stated_relative_error_median)),
        ("latency", _with(s.latency_ms, "ms")),
        *(_class_column(s.classes) if classified else ()),
    ]  # fmt: skip


def _class_column(classes: ClassScores | None) -> list[tuple[str, str]]:
    right, mean = (None, None) if classes is None else (classes.accuracy, classes.hota_mean)
    return [("right class", _percent(right)), (_HOTA_MEAN, _score(mean))]


def _rows(s: Scores) -> list[tuple[str, str]]:
    """The table: (what, value)."""
    return [
        ("HOTA", f"{s.hota:.3f}  DetA {s.deta:.3f} (recall {s.detre:.3f}, precision {s.detpr:.3f})"),
        ("", f"       AssA {s.assa:.3f} (recall {s.assre:.3f}, precision {s.asspr:.3f})"),
        ("", f"       LocA {s.loca:.3f}"),
        ("MOTA", f"{s.mota:.3f}  {s.tp} found, {s.fn} missed, {s.fp} false, {s.idsw} switches, {s.frag} interruptions"),
        ("MOTP", f"{s.motp:.3f}"),
        ("IDF1", f"{s.idf1:.3f}  recall {s.idr:.3f}, precision {s.idp:.3f}"),
        ("objects", f"{s.truth_ids}: {s.mt} mostly tracked, {s.ml} mostly lost"),
        ("tracks", f"{s.track_ids}"),
        ("instants", f"{s.frames}"),
        ("position error", f"{_with(s.position_error_px_median, 'px')} median, {_with(s.position_error_px_p90, 'px')} at 90 %"),
        ("velocity error", _with(s.velocity_error_median, "px/s median")),
        ("stated velocity", _with(s.stated_velocity_error_median, "px/s median")),
        ("direction", _against_displacement(s)),
        ("latency", _with(s.latency_ms, "ms")),
        *_class_rows(s.classes),
    ]


def _class_rows(classes: ClassScores | None) -> list[tuple[str, str]]:
    """Share of right classes, mean HOTA, and of each true class its HOTA and its tracks by the class found."""
    if classes is None:
        return []
    labels = [*classes.labels, "none"]
    rows = [("right class", _percent(classes.accuracy)), (_HOTA_MEAN, _score(classes.hota_mean))]
    each = zip(classes.labels, classes.confusion, classes.recall, classes.precision, classes.hota, strict=True)
    for label, found, recall, precision, hota in each:
        shown = ", ".join(f"{count} as {other}" for other, count in zip(labels, found, strict=True) if count) or "no track"
        shares = f"recall {_percent(recall)}, precision {_percent(precision)}"
        rows.append((f"class {label}", f"{shown}; {shares}; HOTA {_score(hota)}"))
    return rows


def _against_displacement(s: Scores) -> str:
    if s.stated_angle_error_deg_median is None:
        return "unknown"
    return (
        f"stated velocity {s.stated_angle_error_deg_median:.3g} degrees (median) off the displacement over 300 ms, "
        f"more than 45 in {_percent(s.stated_angle_over_45_deg_fraction)}; "
        f"{_percent(s.stated_relative_error_median)} relative error"
    )


def _score(value: float | None) -> str:
    return "unknown" if value is None else f"{value:.3f}"


def _with(value: float | None, unit: str) -> str:
    return "unknown" if value is None else f"{value:.3g} {unit}"


def _percent(fraction: float | None) -> str:
    return "unknown" if fraction is None else f"{100 * fraction:.3g} %"

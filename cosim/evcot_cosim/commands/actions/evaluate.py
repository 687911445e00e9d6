# SPDX-License-Identifier: Apache-2.0
"""`evcot evaluate`: tracks against ground truth."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence

from evcot.api import evaluate
from evcot.metrics.scores import Scores

from ..options import sensor_from
from .clock import clock_from
from .counting import Counting

__all__ = ["run"]


def run(options: argparse.Namespace, _arguments: Sequence[str]) -> int:
    """Score a log; 0."""
    with Counting(f"scoring {options.log}", enabled=not options.json):
        scores = evaluate(
            options.log, options.truth, options.rule, sensor=sensor_from(options), clock=clock_from(options),
            log_format=options.log_format, truth_format=options.truth_format,
        )  # fmt: skip
    if options.json:
        print(json.dumps(scores.to_dict(), indent=2, allow_nan=False))
        return 0
    rows = _rows(scores)
    width = max(len(name) for name, _ in rows)
    for name, value in rows:
        print(f"{name:{width}}  {value}")
    return 0


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
        ("as stated", _with(s.stated_velocity_error_median, "px/s median")),
        ("latency", _with(s.latency_ms, "ms")),
    ]


def _with(value: float | None, unit: str) -> str:
    return "unknown" if value is None else f"{value:.3g} {unit}"

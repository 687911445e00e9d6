# SPDX-License-Identifier: Apache-2.0
"""The columns of a run's row that are figures: what a sweep measures, and what its objectives may be."""

from __future__ import annotations

from dataclasses import fields

from evcot.metrics import Scores

__all__ = ["METRICS", "TIMES"]

SCORES: dict[str, str] = {field.name: "int64" if field.type == "int" else "double" for field in fields(Scores)}
"""Against a truth: docs/evaluation.md."""

_COUNTED = ("events", "records", "owned", "passed", "filtered", "tracks", "merged", "lost")
COUNTS: dict[str, str] = dict.fromkeys(_COUNTED, "int64")
"""Of a track log."""

LOCKSTEP: dict[str, str] = {
    "cycles": "int64",
    "cycles_per_event": "double",
    "latency_median_clocks": "int64",
    "latency_p99_clocks": "int64",
    "latency_max_clocks": "int64",
}
"""Of the hardware."""

COSTS: dict[str, str] = {"luts": "double", "ffs": "double", "block_rams": "double", "fmax_mhz": "double"}
"""Of the hardware on an FPGA: `cost`."""

METRICS: dict[str, str] = {**SCORES, **COUNTS, **LOCKSTEP, **COSTS}
"""Name -> type of the column. They depend on nothing but the task: every machine and every scheduler gives the same."""

TIMES: dict[str, str] = {"wall_s": "double", "cpu_s": "double", "build_s": "double", "memory_mb": "double"}
"""What a run took; differs from run to run."""

# SPDX-License-Identifier: Apache-2.0
"""One task, done in a worker: run it, score it, and return its row as plain values. Nothing is raised."""

from __future__ import annotations

import resource
import socket
import sys
import time
import traceback
import warnings
from datetime import UTC, datetime
from functools import cache, partial
from threading import Lock
from typing import Any, NamedTuple

import numpy as np

from evcot.errors import EvcotError, RecordingWarning
from evcot.events import Events
from evcot.hardware.config import CotConfig, MotionConfig
from evcot.hardware.golden import to_track_records
from evcot.hardware.modules import MODULES
from evcot.metrics import evaluate
from evcot.trackers.engines import ENGINES
from evcot.tracks.log import TRACK, TrackLog

from ..devices.base import Stalls
from ..devices.device import build_device
from ..fpga.devices import DEVICES
from ..fpga.figures import Figure, load
from ..lockstep.lockstep import Lockstep
from ..lockstep.mismatch import MismatchError
from ..lockstep.random_runs import Design, random_case, run_case
from ..lockstep.top_runs import random_top_run
from ..rtl.build import BuiltModel
from ..rtl.files import verilog_dir, versions
from .checkpoints import CheckpointedLog
from .fields import RTL
from .inputs import Stream, opened, truth_of
from .machine import code_of
from .task import FUZZ, Task, canonical, configuration

__all__ = ["DONE", "FAILED", "INVALID", "MISMATCH", "TaskResult", "execute", "row_of", "tracked"]


_FAMILY = DEVICES["ecp5-25"].synthesis


@cache
def _figures(module: str) -> tuple[Figure, ...]:
    """The figures of a module on an ECP5 by number of slots, each on the smallest that it was routed for if there is one.

    Empty in an installation without the repository's figures.
    """
    by_size: dict[int, Figure] = {}
    for row in load(verilog_dir().parent / "fpga" / "figures.json").values():
        if row.module == module and row.device in DEVICES and DEVICES[row.device].synthesis == _FAMILY:
            known = by_size.get(row.n or 1)
            if known is None or not known.fmax_mhz:
                by_size[row.n or 1] = row
    return tuple(by_size[size] for size in sorted(by_size))


def hardware_cost(module: str, slots: int) -> dict[str, float]:
    """LUTs, flip-flops, block RAMs and median Fmax of a module in its default widths, without filters.

    Interpolated between two measured numbers of slots; beyond them unknown.
    """
    rows = _figures(module)
    sizes = [row.n or 1 for row in rows]
    if not sizes or not sizes[0] <= slots <= sizes[-1]:
        return {}
    cost = {
        "luts": float(np.interp(slots, sizes, [row.luts for row in rows])),
        "ffs": float(np.interp(slots, sizes, [row.ffs for row in rows])),
        "block_rams": float(np.interp(slots, sizes, [row.block_rams for row in rows])),
    }
    routed = [(row.n or 1, row.median_mhz) for row in rows if row.median_mhz]
    if routed and routed[0][0] <= slots <= routed[-1][0]:
        cost["fmax_mhz"] = float(np.interp(slots, [n for n, _ in routed], [mhz for _, mhz in routed]))
    return cost


DONE, FAILED, INVALID, MISMATCH = "done", "failed", "invalid", "mismatch"
_ONE_AT_A_TIME = Lock()  # warnings are caught per process, and inputs are kept


class TaskResult(NamedTuple):
    """What a run leaves: the log's records, counts of owners by what became of events, and what the hardware measured.

    Attributes:
        log: its owners are empty unless they were asked for.
    """

    log: TrackLog
    counts: dict[str, int]
    measured: dict[str, Any]
    events: list[Events]


def execute(task: Task) -> dict[str, Any]:
    """The row of a task."""
    with _ONE_AT_A_TIME:
        row = row_of(task)
        began, cpu = time.perf_counter(), time.process_time()
        with warnings.catch_warnings(record=True) as warned:
            warnings.simplefilter("always", RecordingWarning)
            try:
                if task.code != (code := code_of(task.engine)):
                    row |= {
                        "status": FAILED,
                        "error": f"the program is {code}: must be {task.code}, the sweep's",
                    }
                else:
                    row |= {"status": DONE, **(_fuzzed(task) if task.engine == FUZZ else _measured(task))}
            except MismatchError as error:
                row |= {"status": MISMATCH, "error": str(error)}
            except EvcotError as error:
                row |= {"status": FAILED, "error": str(error)}
            except Exception as error:  # it goes into the row, and the sweep goes on
                place = traceback.extract_tb(error.__traceback__)[-1]
                text = " ".join(str(error).split())
                row |= {"status": FAILED, "error": f"{type(error).__name__}: {text} ({place.name}, line {place.lineno})"}
        row["warnings"] = "; ".join(dict.fromkeys(str(each.message) for each in warned))
        row["wall_s"] = row.get("wall_s", 0.0) + time.perf_counter() - began
        row["cpu_s"] = row.get("cpu_s", 0.0) + time.process_time() - cpu
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        row["memory_mb"] = peak / (1e6 if sys.platform == "darwin" else 1e3)
        return row


def row_of(task: Task) -> dict[str, Any]:
    """The columns of a row that are known before its run."""
    source = task.input
    about: dict[str, Any] = {}
    if source is not None:
        about = {
            "input": source.name, "family": source.family, "content": source.content, "scene_seed": source.scene_seed,
            "from_us": source.from_us, "to_us": source.to_us,
        }  # fmt: skip
    return {
        "key": task.key, "engine": task.engine, "hardware": task.hardware, "preset": task.preset, "seed": task.seed, **about,
        "settings": dict(task.settings), "task": canonical(task.to_dict()), "code": task.code, "design": task.design,
        "versions": canonical(versions()), "host": socket.gethostname(),
        "when": datetime.now(UTC).isoformat(timespec="milliseconds"), "error": "", "warnings": "",
    }  # fmt: skip


def _measured(task: Task) -> dict[str, Any]:
    assert task.input is not None
    with opened(task.input) as stream:
        found = tracked(task, stream)
        truth = truth_of(task.input, stream.sensor, stream.first_us)
    figures: dict[str, Any] = {**found.counts, **found.measured}
    if truth is not None:
        figures |= evaluate(found.log, *truth).to_dict()
    return figures


def tracked(task: Task, stream: Stream, *, whole: bool = False) -> TaskResult:
    """Run a task's engine over a stream; after a checkpoint of the same task, over what follows it.

    Memory is that of the records, unless `whole`: events and owners are kept, too, and there are no checkpoints.
    """
    settings, filters = configuration(task.engine, stream.sensor, task.preset, task.tables, task.hardware)
    with CheckpointedLog(task.key, whole) as kept:
        if task.engine == RTL:
            log, measured = _lockstep(task, settings.device_config(*stream.sensor), stream, kept)
        else:
            tracker = kept.engine or ENGINES[task.engine].start(settings, filters, stream.sensor)
            for block in kept.rest(stream.blocks):
                records, owner = tracker.feed(block)
                kept.add(records, owner, block)
                if not ENGINES[task.engine].plug_in:  # whose state cannot be read back safely
                    kept.keep(lambda: tracker)
            log = kept.log(task.engine, tracker.finish())
            measured = hardware_cost(task.engine, settings.hardware.shape.n_slots) if task.engine in MODULES else {}
        return TaskResult(log, kept.counts(), {**measured, **kept.spent}, kept.events)


def _lockstep(
    task: Task, config: CotConfig | MotionConfig, stream: Stream, kept: CheckpointedLog
) -> tuple[TrackLog, dict[str, Any]]:
    built = _built(config, savable=True)
    state, t0_us = kept.engine or (None, None)
    with Lockstep(config, stalls=Stalls.seeded(task.seed), seed=task.seed, model=built) as lockstep:
        if state is not None:
            lockstep.restore(state)
        for block in kept.rest(stream.blocks):
            first = lockstep.events
            t0_us = int(block.t_us[0]) if t0_us is None else t0_us  # of the part: tick 0
            decided = lockstep.feed(block).hardware
            kept.add(to_track_records(decided.records, config, block.t_us, first, t0_us), decided.owner, block)
            kept.keep(partial(_state, lockstep, t0_us))
        measured = {**_hardware(lockstep), "build_s": 0.0 if built.cached else built.build_s}
    return kept.log(config.module, np.empty(0, TRACK)), measured | hardware_cost(config.module, config.shape.n_slots)


def _state(lockstep: Lockstep, t0_us: int) -> tuple[dict[str, Any], int]:
    return lockstep.state(), t0_us


def _fuzzed(task: Task) -> dict[str, Any]:
    assert task.seed is not None
    design = Design.from_tables(task.tables)
    if design.top is not None:
        done = random_top_run(design, task.seed, task.events)
        return {**done._asdict(), "cycles_per_event": done.cycles / done.events}
    case = random_case(design, task.seed, task.events)
    built = _built(case.config)
    lockstep = run_case(case, built)
    own = {"events": lockstep.events, "records": lockstep.records, "build_s": 0.0 if built.cached else built.build_s}
    return {**own, **_hardware(lockstep)}


def _hardware(lockstep: Lockstep) -> dict[str, Any]:
    counts, cycles = lockstep.latency, lockstep.device.cycle
    so_far = np.cumsum(counts)
    quantiles = {"median": 0.5, "p99": 0.99, "max": 1.0}
    found = {f"latency_{name}_clocks": int(np.searchsorted(so_far, part * so_far[-1])) for name, part in quantiles.items()}
    latency = found if so_far[-1] else dict.fromkeys(found)
    return {"cycles": cycles, "cycles_per_event": cycles / max(lockstep.events, 1), **latency}


_models: dict[str, BuiltModel] = {}


def _built(config: CotConfig | MotionConfig, *, savable: bool = False) -> BuiltModel:
    """The compiled design: looked up once in a worker, built once on a machine."""
    asked = (int(config.filters.enable), savable)
    key = canonical([config.module, vars(config.shape), vars(config.filter_shape), asked])
    found = _models.get(key)
    if found is None:
        found = build_device(config, waves=False, savable=savable)
        _models[key] = found
        return found
    return BuiltModel(found.top, found.parameters, found.shared_object, found.key, True, 0.0)

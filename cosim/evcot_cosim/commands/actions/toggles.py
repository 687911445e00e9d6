# SPDX-License-Identifier: Apache-2.0
"""`evcot toggles`: simulate a part of a run again, and count the toggles of every bit."""

from __future__ import annotations

import argparse
import json
import tempfile
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import reduce
from operator import add
from pathlib import Path

from evcot.errors import ConfigError
from evcot.hardware.config import with_module
from evcot.trackers.config import RunConfig

from ...devices.device import build_device
from ...fpga.activity import ModuleToggles, by_module, design_of, nets_of, uncounted
from ...lockstep.lockstep import dump_window
from ...tables import print_table
from ...waves.toggles import count_toggles, write_saif
from ...waves.window import CLOCK, Window
from ..hardware import TOGGLES_MS
from ..options import window_from
from .job import Job, job_from
from .spinner import Counting

__all__ = ["run"]

_MOST_EVENTS = 200_000  # whose waveform, which lies on the disk while it is counted, takes a gigabyte or two


@dataclass(frozen=True)
class _Counted:
    module: str
    n_events: int
    n_clocks: int
    modules: dict[str, ModuleToggles]
    uncounted: dict[str, int]  # of each module, memories that are too large for a waveform

    @property
    def whole(self) -> ModuleToggles:
        return reduce(add, self.modules.values())


def run(options: argparse.Namespace, _arguments: Sequence[str]) -> int:
    """Print the table, and write SAIF if asked for; 0."""
    from_us, to_us = window_from(options, TOGGLES_MS)
    assert to_us is not None
    with Counting("simulating (the hardware is compiled once)", enabled=not (options.quiet or options.json)):
        job = job_from(options, until_us=to_us)
        window = Window.of_time(job.recording.events, from_us, to_us)
        if (n := window.last + 1 - window.first) > _MOST_EVENTS:
            given = f"--from {from_us / 1e3:g} --to {to_us / 1e3:g}"
            raise ConfigError(f"{given}: {n:,} events: must be at most {_MOST_EVENTS:,}")
        if options.beside == job.config.hardware.module:
            raise ConfigError(f"--beside {options.beside}: must be another module than --hardware")
        counted = [_count(job, job.config, window, options.saif, force=options.force)]
        if options.beside is not None:
            counted.append(_count(job, _beside(job.config, options.beside), window))
    job.filters.save_learned()
    if options.json:
        print(json.dumps([{**asdict(one), "whole": asdict(one.whole)} for one in counted], indent=1))
    elif not options.quiet:
        _print(counted)
    return 0


def _count(job: Job, run: RunConfig, window: Window, saif: Path | None = None, *, force: bool = False) -> _Counted:
    config = run.device_config(job.recording.width, job.recording.height)
    model = build_device(config)
    with tempfile.TemporaryDirectory() as folder:
        vcd = Path(folder) / "waves.vcd"
        dump_window(job.recording.events, config, vcd, window.first, window.last, stalls=job.stalls)
        activity = count_toggles(vcd)
    design = design_of(model.top, model.parameters)
    modules = by_module(design, activity)
    if saif is not None:
        write_saif(activity, saif, f"TOP.{model.top}", nets_of(design, activity), force=force)
    left_out = uncounted(design, activity)
    return _Counted(config.module, window.last + 1 - window.first, activity.duration // CLOCK, modules, left_out)


def _beside(config: RunConfig, module: str) -> RunConfig:
    """The same for another module."""
    try:
        return replace(config, hardware=with_module(config.hardware, module))
    except ConfigError as error:
        raise ConfigError(f"--beside {module}: {error}") from error


def _print(counted: Sequence[_Counted]) -> None:
    rows: list[Sequence[str]] = [
        ("hardware", "module", "instances", "registers, bits", "toggles an event", "wires, bits", "toggles an event")
    ]
    for one in counted:
        shown = [(name, toggles) for name, toggles in one.modules.items() if toggles.registers or toggles.wires]
        for name, toggles in [*shown, ("all", one.whole)]:
            instances = f"{toggles.instances:,}" if name != "all" else ""
            rows.append((
                one.module, name, instances,
                f"{toggles.registers:,}", f"{toggles.register_toggles / one.n_events:.1f}",
                f"{toggles.wires:,}", f"{toggles.wire_toggles / one.n_events:.1f}",
            ))  # fmt: skip
    print_table(rows)
    for one in counted:
        print(f"{one.module}: {one.n_events:,} events, {one.n_clocks / one.n_events:.2f} clocks an event")
        if one.uncounted:
            memories = ", ".join(f"{n} of {module}" for module, n in one.uncounted.items())
            print(f"{one.module}: not counted, since too large for a waveform: memories, {memories}")

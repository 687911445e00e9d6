# SPDX-License-Identifier: Apache-2.0
"""Baseline for the streaming drive: a bare C++ main on the same Verilated model.

RTL, parameters, flags of Verilator and of the compiler, events, and the work for each event are the same.
"""

from __future__ import annotations

import json
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from evcot.events import Events
from evcot.hardware.config import CotConfig
from evcot.hardware.contract import REGISTERS
from evcot.ticks import TickedEvents
from evcot_cosim.rtl.build import BuiltModel
from evcot_cosim.rtl.files import rtl_files, search_flags
from evcot_cosim.rtl.toolchain import find_toolchain
from measure import Timing

__all__ = ["BareMain", "Outcome", "register_writes", "running", "verilator_flags"]

_MAIN = Path(__file__).with_name("bare_main.cpp")


class Outcome(NamedTuple):
    """Summary of a pass, enough to check that it did the same as another drive."""

    records: int
    owner_sum: int


class BareMain:
    """The running process; it waits between passes.

    Attributes:
        outcome: of the last pass.
    """

    def __init__(self, process: subprocess.Popen[str]) -> None:
        self._process = process
        self.outcome = Outcome(0, 0)

    def run(self) -> Timing:
        """One pass over all events on a fresh model; only the drive is timed."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write("\n")
        self._process.stdin.flush()
        wall_s, cpu_s, *counts = self._process.stdout.readline().split()
        self.outcome = Outcome(*map(int, counts))
        return Timing(float(wall_s), float(cpu_s))


@contextmanager
def running(model: BuiltModel, config: CotConfig, events: Events, folder: Path) -> Iterator[BareMain]:
    """Build the main into `folder` with the flags that `model`, a cot_array, was built with, and start it on the events."""
    folder.mkdir(parents=True, exist_ok=True)
    executable = _build(model, folder)
    _write_input(folder / "events.bin", config, events)
    with subprocess.Popen(
        [executable, folder / "events.bin"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:  # leaving closes its input, which ends it
        yield BareMain(process)


def verilator_flags(model: BuiltModel) -> list[str]:
    """What the model was built with: all but extra sources and what the linker does for shared objects."""
    arguments: list[str] = _request(model)["args"]
    linker = {i for i in range(len(arguments)) if "-LDFLAGS" in arguments[max(i - 1, 0) : i + 1]}
    return [flag for i, flag in enumerate(arguments) if i not in linker and not flag.endswith(".cpp")]


def register_writes(config: CotConfig) -> NDArray[np.uint32]:
    """(n, 3) slot, address and value, in the order in which they are written."""
    names = sorted(REGISTERS, key="mode".__eq__)
    slots = enumerate(config.slots)
    return np.array([(i, REGISTERS[name].address, getattr(slot, name)) for i, slot in slots for name in names], np.uint32)


def _request(model: BuiltModel) -> dict[str, Any]:
    request: dict[str, Any] = json.loads(model.shared_object.with_name("request.json").read_text())
    return request


def _build(model: BuiltModel, folder: Path) -> Path:
    tools = find_toolchain()
    command = [
        str(tools.executable), "--cc", "--exe", "--build", "--trace", "-Wno-fatal", "-Mdir", str(folder),
        *verilator_flags(model), "-CFLAGS", _request(model)["cargs"].replace("-include evcot_runtime.h", ""),
        *search_flags(), str(rtl_files()[f"{model.top}.v"]), str(_MAIN),
    ]  # fmt: skip
    log = folder / "build.log"
    with log.open("w") as output:
        done = subprocess.run(command, env=dict(tools.environment), stdout=output, stderr=subprocess.STDOUT, check=False)
    if done.returncode:
        raise RuntimeError(f"the bare main does not build; log: {log}")
    return folder / f"V{model.top}"


def _write_input(path: Path, config: CotConfig, events: Events) -> None:
    writes = register_writes(config)
    ticked = TickedEvents.of(events, config.tick_us)
    with path.open("wb") as file:
        np.array([len(ticked), (1 << config.shape.tick_w) - 1, len(writes)], np.int64).tofile(file)
        for column in (writes, ticked.ticks, ticked.x, ticked.y, ticked.p):
            column.tofile(file)

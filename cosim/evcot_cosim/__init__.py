# SPDX-License-Identifier: Apache-2.0
"""Compiles the evcot RTL, drives it in lock-step with the golden model, and shows where hardware and software agree.

These names, and those of `evcot_cosim.waves`, are stable (docs/api.md); what is imported from deeper may change. They are
loaded when they are first used. Verilator and a C++ compiler must be installed.

Example:
    import evcot
    import evcot_cosim

    run = evcot_cosim.cosim("drive.aedat4")  # hardware and model equal, or MismatchError
    run.save("build/drive")

    recording = evcot.read("drive.aedat4")
    with evcot_cosim.Lockstep(run.config.device_config()) as lockstep:  # or run by run
        step = lockstep.feed(recording.events[:1000])
        step.hardware.records, step.hardware.owner
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from . import waves
    from .api import cosim
    from .devices.base import HardwareError, Stalls
    from .devices.device import Device, build_device
    from .lockstep.cosim import CosimRun
    from .lockstep.lockstep import Lockstep, Step, dump_window
    from .lockstep.mismatch import Mismatch, MismatchError
    from .lockstep.run_file import RunFile, Source, read_run_file
    from .report.artifacts import write_mismatch, write_run
    from .rtl.build import load
    from .vectors import Vectors

__all__ = [
    "CosimRun",
    "Device",
    "HardwareError",
    "Lockstep",
    "Mismatch",
    "MismatchError",
    "RunFile",
    "Source",
    "Stalls",
    "Step",
    "Vectors",
    "build_device",
    "cosim",
    "dump_window",
    "load",
    "read_run_file",
    "waves",
    "write_mismatch",
    "write_run",
]

_NAMES = {
    "": ("waves",),
    "api": ("cosim",),
    "devices.base": ("HardwareError", "Stalls"),
    "devices.device": ("Device", "build_device"),
    "lockstep.cosim": ("CosimRun",),
    "lockstep.lockstep": ("Lockstep", "Step", "dump_window"),
    "lockstep.mismatch": ("Mismatch", "MismatchError"),
    "lockstep.run_file": ("RunFile", "Source", "read_run_file"),
    "report.artifacts": ("write_mismatch", "write_run"),
    "rtl.build": ("load",),
    "vectors": ("Vectors",),
}


def __getattr__(name: str) -> Any:  # the command imports this: nothing else before it can end an interrupt in one line
    from evcot._lazy import lazily

    return lazily(__name__, _NAMES)[0](name)


def __dir__() -> list[str]:
    from evcot._lazy import lazily

    return lazily(__name__, _NAMES)[1]()

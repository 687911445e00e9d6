# SPDX-License-Identifier: Apache-2.0
"""The streaming drive against a cocotb test that drives the same hardware and collects the same streams.

Run as a program with a build folder, it is the child process that builds and runs the test with cocotb's runner.
"""

from __future__ import annotations

import importlib.util
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np

import streams
from bare import Outcome, register_writes, verilator_flags
from evcot.hardware.model import Decisions
from evcot.ticks import TickedEvents
from evcot_cosim.devices.device import Device, build_device
from evcot_cosim.rtl.files import rtl_files, search_flags
from evcot_cosim.rtl.toolchain import find_toolchain
from measure import Clock, Goal, Result, Skip, Timing, take_turns, timed

__all__ = ["measure"]

_GOAL = 100.0
_TEST_MODULE = "cocotb_test_module"


def measure(folder: Path, quick: bool) -> Iterator[Result]:
    """stream_vs_cocotb: both drive the same run of events through an array of the same parameters."""
    if importlib.util.find_spec("cocotb") is None:
        raise Skip("cocotb is not installed (pip install 'evcot[bench]')")
    config = streams.config().hardware
    model = build_device(config)
    n = 10_000 if quick else 50_000
    events = streams.joined(n)
    ticked = TickedEvents.of(events, config.tick_us)
    home = (folder / "cocotb").absolute()
    home.mkdir(parents=True, exist_ok=True)
    (home / "flags.json").write_text(json.dumps(verilator_flags(model)))
    np.savez(home / "input.npz", **vars(ticked), writes=register_writes(config))
    outcomes: set[Outcome] = set()

    def stream() -> Timing:
        device = Device(config, model=model)
        found: list[Decisions] = []
        timing = timed(lambda: found.append(device.stream(ticked)))
        outcomes.add(Outcome(len(found[0].records), int(found[0].owner.sum())))
        return timing

    def cocotb() -> Timing:
        found = _run_child(home)
        outcomes.add(Outcome(int(found["records"]), int(found["owner_sum"])))
        return Timing(found["wall_s"], found["cpu_s"])

    turns = take_turns({"stream": stream, "cocotb": cocotb}, 3 if quick else 5)
    if len(outcomes) != 1:
        raise RuntimeError(f"the drives disagree: {outcomes}")
    rates = {name: n / turns.seconds(name, Clock.CPU) / 1e6 for name in turns.timings}
    yield Result(
        "stream_vs_cocotb", rates["stream"], "M events/s", rates["cocotb"], "cocotb test",
        ratio=turns.speed_ratio("stream", "cocotb"), goal=Goal(_GOAL),
        how=f"{n:,} events, CPU time; wall ratio: {turns.speed_ratio('stream', 'cocotb', Clock.WALL):.0f}",
    )  # fmt: skip


def _run_child(home: Path) -> dict[str, float]:
    environment = dict(find_toolchain().environment) | {
        "PYTHONPATH": str(Path(__file__).parent),
        "EVCOT_BENCH_INPUT": str(home / "input.npz"),
        "EVCOT_BENCH_OUTPUT": str(home / "output.json"),
    }
    with (home / "log.txt").open("w") as log:
        command = [sys.executable, __file__, str(home)]
        done = subprocess.run(command, env=environment, stdout=log, stderr=subprocess.STDOUT, check=False)
    if done.returncode:
        raise RuntimeError(f"the cocotb test fails; log: {home / 'log.txt'}")
    outcome: dict[str, float] = json.loads((home / "output.json").read_text())
    return outcome


def _main(home: Path) -> None:
    from cocotb_tools.runner import get_runner

    runner = get_runner("verilator")
    runner.build(
        sources=[rtl_files()["cot_array.v"]],
        hdl_toplevel="cot_array",
        build_args=[*json.loads((home / "flags.json").read_text()), "-Wno-fatal", *search_flags()],
        build_dir=home,
        timescale=("1ns", "1ps"),
    )
    os.chdir(home)
    results = runner.test(hdl_toplevel="cot_array", test_module=_TEST_MODULE, build_dir=home, test_dir=home)
    if "<failure" in Path(results).read_text():
        sys.exit(1)


if __name__ == "__main__":
    _main(Path(sys.argv[1]))

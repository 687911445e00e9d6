# SPDX-License-Identifier: Apache-2.0
"""Run the benchmarks: a table on the terminal, and build/bench/bench.json."""

from __future__ import annotations

import argparse
import importlib
import json
import os
import platform
import sys
import time
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

import evcot
from evcot.outputs import written_aside
from evcot_cosim.rtl.toolchain import find_toolchain
from measure import Result, Skip

_BENCHMARKS = (
    "streaming",
    "cocotb_drive",
    "rates",
    "rct",
    "reading",
    "filters",
    "scenes",
    "latency",
    "starts",
    "memory",
    "long",
    "recordings",
    "clustering",
    "table2",
    "cot_quality",
    "anomalies",
    "lines",
    "recognition",
    "quality",
    "live",
    "sweep",
)
_FOLDER = Path("build") / "bench"


def main() -> int:
    """Run what was asked for; the exit code is 1 when a goal is missed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("benchmarks", nargs="*", metavar="NAME", help=f"which of {', '.join(_BENCHMARKS)} (default: all)")
    parser.add_argument("--quick", action="store_true", help="fewer events and rounds: coarse figures in two minutes")
    options = parser.parse_args()
    unknown = set(options.benchmarks) - set(_BENCHMARKS)
    if unknown:
        parser.error(f"{', '.join(sorted(unknown))}: must be one of {', '.join(_BENCHMARKS)}")

    results: list[Result] = []
    skipped: dict[str, str] = {}
    _print_row("name", "value", "unit", "reference", "ratio", "goal")
    for name in options.benchmarks or _BENCHMARKS:
        try:
            for result in importlib.import_module(name).measure(_FOLDER, options.quick):
                results.append(result)
                _print_result(result)
        except Skip as reason:
            skipped[name] = str(reason)
            print(f"{name}: skipped: {reason}")

    _write(
        _FOLDER / "bench.json",
        {
            "results": [result.to_dict() for result in results],
            "skipped": skipped,
            "quick": options.quick,
            "when": time.strftime("%Y-%m-%dT%H:%M:%S%z"),
            "method": "compared runs take turns; medians over the turns; CPU time of one thread unless `how` says otherwise",
            "versions": _versions(),
            "machine": _machine(),
        },
    )
    print(f"\n{_FOLDER / 'bench.json'}")
    return int(any(result.met is False for result in results))


def _print_result(result: Result) -> None:
    reference = "" if result.reference is None else f"{result.reference:.4g} ({result.against})"
    ratio = "" if result.ratio is None else f"{result.ratio:.3g}"
    goal = "" if result.goal is None else f"{result.goal} {'met' if result.met else 'MISSED'}"
    _print_row(result.name, f"{result.value:.4g}", result.unit, reference, ratio, goal)


def _print_row(*cells: str) -> None:
    print("  ".join(cell.ljust(width) for cell, width in zip(cells, (30, 8, 12, 24, 7, 0), strict=True)).rstrip(), flush=True)


def _write(path: Path, document: dict[str, Any]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    with written_aside(path, force=True) as file:
        file.write((json.dumps(document, indent=2) + "\n").encode())


def _versions() -> dict[str, str]:
    tools = find_toolchain()
    packages: Sequence[str] = ("numpy", "numba", "pyverilator-mm")
    return {
        "evcot": evcot.__version__,
        "python": platform.python_version(),
        "verilator": tools.version,
        "compiler": f"{tools.compiler_version}, {tools.optimisation}",
        **{package: version(package) for package in packages},
    }


def _machine() -> dict[str, Any]:
    return {"system": platform.platform(), "cores": os.cpu_count(), "cpu": _cpu_model(), "load": os.getloadavg()}


def _cpu_model() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor()
    return next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), platform.processor())


if __name__ == "__main__":
    sys.exit(main())

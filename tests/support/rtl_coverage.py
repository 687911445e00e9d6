# SPDX-License-Identifier: Apache-2.0
"""Which lines, branches and bits of the RTL the tests reach: a pytest plug-in of `make coverage`, and its report.

Verilator counts, in each simulation, how often each point of the RTL is reached. Counts of all simulations in a process are
added, whatever the parameters and the instance, and written to `$EVCOT_COVERAGE/rtl-WORKER.json`. Simulations of RTL that a
test has broken do not count, nor those of commands that a test starts.
"""

from __future__ import annotations

import ctypes
import functools
import json
import os
import re
from collections import Counter
from pathlib import Path
from typing import Any

import pytest

from evcot_cosim.rtl import build
from evcot_cosim.rtl.files import verilog_dir

__all__ = ["points_of", "report"]

FOLDER = Path(os.environ.get("EVCOT_COVERAGE") or "build/coverage")
RTL = verilog_dir()

_FLAGS = ("--coverage-line", "--coverage-toggle")
_CONTEXTS = """#include <vector>
#include "verilated_cov.h"
static std::vector<VerilatedContext*> contexts;
extern "C" int evcot_write_coverage(const char* path) {  // of one simulation, which then no longer counts; 0: there is none
    if (contexts.empty()) return 0;
    contexts.back()->coveragep()->write(path);
    contexts.back()->coveragep()->clear();
    contexts.pop_back();
    return 1;
}
"""
_KEEPS = "Verilated::threadContextp(context);"
_POINT = re.compile(
    r"C '\x01f\x02(?:[^\x01]*/)?(?P<file>[^\x01]*)\x01l\x02(?P<line>\d+)\x01n\x02(?P<column>\d+)\x01.*?page\x02v_(?P<kind>\w+)/"
    r"[^\x01]*\x01o\x02(?P<what>[^\x01]*).*' (?P<count>\d+)$"
)
_USED: set[Path] = set()
_FOUND: Counter[str] = Counter()


def _count_everything() -> None:
    """Have all models that are built from now on count. Modules that import `build` must do so later."""
    assert build._CONTEXT_CPP.count(_KEEPS) == 1
    build._VERILATOR_FLAGS += _FLAGS  # type: ignore[assignment]
    build._CONTEXT_CPP = _CONTEXTS + build._CONTEXT_CPP.replace(_KEEPS, f"contexts.push_back(context); {_KEEPS}")
    make = build.build

    @functools.wraps(make)
    def made(*args: Any, verilog: Path | None = None, **more: Any) -> build.BuiltModel:
        model = make(*args, verilog=verilog, **more)
        if (verilog or verilog_dir()) == RTL:
            _USED.add(model.shared_object)
        return model

    build.build = made


def points_of(text: str) -> Counter[str]:
    """Counts of the points in a file that Verilator wrote, by FILE:LINE:COLUMN:KIND:WHAT; those of all instances are added."""
    found: Counter[str] = Counter()
    for match in map(_POINT.match, text.splitlines()):
        if match is not None:
            *name, count = match.groups()
            found[":".join(name)] += int(count)
    return found


def pytest_configure(config: pytest.Config) -> None:
    """Begin to count, in each process that runs tests."""
    _count_everything()


def pytest_runtest_teardown(item: pytest.Item, nextitem: pytest.Item | None) -> None:
    """Add up what the simulations of a file's tests have counted; their counters take gigabytes."""
    if nextitem is not None and nextitem.path == item.path:
        return
    FOLDER.mkdir(parents=True, exist_ok=True)
    path = FOLDER / f"{_worker()}.dat"
    for shared_object in _USED:
        write = ctypes.CDLL(str(shared_object)).evcot_write_coverage
        while write(str(path).encode()):
            _FOUND.update(points_of(path.read_text()))
    path.unlink(missing_ok=True)


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Write what all simulations of this process have counted."""
    own = {file.name for file in RTL.rglob("*.v")}
    counts = {point: count for point, count in sorted(_FOUND.items()) if point.partition(":")[0] in own}
    if counts:
        (FOLDER / f"rtl-{_worker()}.json").write_text(json.dumps(counts))


def _worker() -> str:
    return os.environ.get("PYTEST_XDIST_WORKER", "main")


def report() -> None:
    """Print a row for each file, and write the points that no simulation reached to `rtl.txt`."""
    found: Counter[str] = Counter()
    for path in sorted(FOLDER.glob("rtl-*.json")):
        found.update(json.loads(path.read_text()))
    reached: dict[str, Counter[str]] = {}
    every: dict[str, Counter[str]] = {}
    missed = []
    for point, count in found.items():
        file, line, _, kind, what = point.split(":", 4)
        every.setdefault(file, Counter())[kind] += 1
        reached.setdefault(file, Counter())[kind] += count > 0
        if not count:
            missed.append((file, int(line), kind, what))
    kinds = ("line", "branch", "toggle")
    print(f"{'file':30} {' '.join(f'{kind:>14}' for kind in kinds)}")
    total_reached, total = sum(reached.values(), Counter()), sum(every.values(), Counter())
    for name, of, out_of in [*((file, reached[file], every[file]) for file in sorted(every)), ("all", total_reached, total)]:
        shares = (f"{of[kind]:>6}/{out_of[kind]:<6}" if out_of[kind] else " " * 13 for kind in kinds)
        print(f"{name:30} {'  '.join(shares)}")
    print(", ".join(f"{kind} {total_reached[kind] / total[kind]:.2%}" for kind in kinds if total[kind]))
    text = "".join(f"{file}:{line}: {kind} {what}\n" for file, line, kind, what in sorted(missed))
    (FOLDER / "rtl.txt").write_text(text)


if __name__ == "__main__":
    report()

# SPDX-License-Identifier: Apache-2.0
"""How many processes run the tests, and how they share what is prepared once; signals; garbage collection.

Interrupts reach the processes, and a broken pipe is an error.
"""

from __future__ import annotations

import contextlib
import gc
import importlib
import os
import re
import signal
import sys
from collections import Counter
from pathlib import Path

import pytest

import evcot  # before any test imports Numba, which then keeps its kernels where evcot says

if os.environ.get("EVCOT_COVERAGE"):
    pytest_plugins = ["support.rtl_coverage"]

TESTS = Path(__file__).parent
_LONG = {
    f"test_{name}.py"
    for name in ("array_steps", "board", "browser", "formal", "gates", "gtkwave", "initial_values", "vectors")
}  # fmt: skip

# Collecting makes two million objects that stay. To search them for garbage while they are made, again and again during the
# tests, and when a process ends would take 5 % of all time.
gc.disable()


def pytest_xdist_auto_num_workers() -> int:
    """One more than processors: tests that wait, for a process or a socket, would leave one idle."""
    return (os.cpu_count() or 1) + 1


def pytest_configure() -> None:
    # A run in the background ignores interrupts, and what tests start would inherit that.
    if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_sessionstart(session: pytest.Session) -> None:
    """Before all processes collect all tests in the same order, each imports others of them.

    What pytest and Python make of a file, which is half of the work, is then made by one process and found by the others.
    """
    worker = getattr(session.config, "workerinput", None)
    if worker is None or session.config.args != session.config.getini("testpaths"):
        return
    mine = sorted(TESTS.rglob("test_*.py"))[int(worker["workerid"].removeprefix("gw")) :: worker["workercount"]]
    sys.path.insert(0, str(TESTS.parent))
    for path in mine:
        # A file that cannot be imported, or is skipped, says so when it is collected.
        with contextlib.suppress(Exception, pytest.skip.Exception):
            importlib.import_module(".".join(path.relative_to(TESTS.parent).with_suffix("").parts))
    sys.path.remove(str(TESTS.parent))


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """With several processes, run long files first, then those with most tests: at the end no process works alone."""
    if "PYTEST_XDIST_WORKER" not in os.environ:
        return
    tests = Counter(item.path for item in items)
    items.sort(key=lambda item: (item.path.name not in _LONG, -tests[item.path], item.path))


def pytest_collection_finish() -> None:
    assert signal.getsignal(signal.SIGPIPE) == signal.SIG_IGN, (
        "an import has changed what a broken pipe does (vcdvcd does: evcot_cosim.waves.vcd.parse puts that back); "
        "a test whose peer closes a socket would end the whole run without a word"
    )
    gc.collect()
    gc.freeze()
    gc.set_threshold(20_000, 20, 50)
    gc.enable()


_MISSING_TOOL = re.compile(r"not installed|could not import|not found|needs (?!.*\.(aedat|npz|raw))|on PATH|no C compiler")


def pytest_sessionfinish(session: pytest.Session) -> None:
    """With EVCOT_REQUIRE_TOOLS (continuous integration), a test that was skipped for a missing tool fails the run."""
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    if not os.environ.get("EVCOT_REQUIRE_TOOLS") or reporter is None or hasattr(session.config, "workerinput"):
        return
    reasons = {report.longrepr[2] for report in reporter.stats.get("skipped", []) if isinstance(report.longrepr, tuple)}
    for reason in sorted(filter(_MISSING_TOOL.search, reasons)):
        reporter.write_line(f"\nEVCOT_REQUIRE_TOOLS: a test was skipped: {reason}", red=True)
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


@pytest.fixture(scope="session")
def kernels() -> None:
    """The kernels of the engines `adaptive` and `rct`, compiled by one process while others that ask for them wait.

    Several test files begin with them at the same time; without this, each of their processes compiles them.
    """
    import fcntl

    import numpy as np

    from evcot_cosim.rtl.build import cache_dir

    few = evcot.Events(np.arange(2, dtype=np.int64), *np.zeros((2, 2), np.uint16), np.zeros(2, np.uint8))
    cache_dir().mkdir(parents=True, exist_ok=True)
    with (cache_dir() / ".kernels.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        for engine in ("adaptive", "rct"):
            evcot.track(evcot.Recording(few, 32, 32, "two events"), engine)


def pytest_unconfigure() -> None:
    # What pyslang has made complains when the process ends and it was not freed.
    gc.unfreeze()

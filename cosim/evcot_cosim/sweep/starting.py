# SPDX-License-Identifier: Apache-2.0
"""How workers start: forked from one process that has imported what they need, once for all of them.

A worker that imports it all itself is ready after more than two seconds; a fork is ready after some hundredths of one. The
process from which they fork has no threads of this one, holds none of its files, and ends with it. This module imports little,
so that a command can begin that process before it imports the rest itself: then both do so at the same time.
"""

from __future__ import annotations

import multiprocessing
import signal
from collections.abc import Callable
from multiprocessing.context import BaseContext
from multiprocessing.process import BaseProcess
from typing import Any

__all__ = ["begin_starting", "started"]

_METHOD = "forkserver" if "forkserver" in multiprocessing.get_all_start_methods() else "spawn"
_IMPORTED = ["evcot_cosim.sweep.preload"]


def begin_starting() -> None:
    """Have the imports begin, where they have not; a worker started without this begins them."""
    if _METHOD != "forkserver":
        return
    from multiprocessing import forkserver, resource_tracker

    multiprocessing.get_context(_METHOD).set_forkserver_preload(_IMPORTED)
    resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})  # of a terminal: the caller ends its workers
    try:
        forkserver.ensure_running()
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def started(target: Callable[..., None], *arguments: Any) -> BaseProcess:
    """A process that calls `target`, started."""
    begin_starting()
    context: BaseContext = multiprocessing.get_context(_METHOD)
    process: BaseProcess = context.Process(target=target, args=arguments, daemon=True)  # type: ignore[attr-defined]
    process.start()
    return process

# SPDX-License-Identifier: Apache-2.0
"""Have Numba compile in a process of its own: the process that needs the kernels then loads them, and stays 170 MB smaller."""

from __future__ import annotations

import contextlib
import pickle
import subprocess
import sys
import threading
from collections.abc import Callable
from typing import Any

from numba.core import event

__all__ = ["compiled_aside"]

_CHILD = "import pickle, sys; function, arguments = pickle.load(sys.stdin.buffer); function(*arguments)"


def compiled_aside(function: Callable[..., Any], *arguments: Any) -> None:
    """Call a function that is called to have kernels compiled; where they are not in the cache, another process does it before.

    Args:
        function: of a module; what it does besides, it may do again.
        arguments: that can be pickled.
    """
    if _is_done(function, *arguments):
        return
    command = [sys.executable, "-P", "-c", _CHILD]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as child:
        assert child.stdin is not None
        with contextlib.suppress(BrokenPipeError), child.stdin as given:
            pickle.dump((function, arguments), given)
    function(*arguments)  # where the other process failed, this compiles, or fails and says why


def _is_done(function: Callable[..., Any], *arguments: Any) -> bool:
    """Call a function unless it would compile anything; returns whether it was called to its end."""
    with contextlib.suppress(_NotCached), event.install_listener("numba:compile", _Refusing()):
        function(*arguments)
        return True
    return False


class _NotCached(Exception):
    """A kernel has to be compiled."""


class _Refusing(event.Listener):
    """Stops what this thread is about to compile."""

    def __init__(self) -> None:
        self._thread = threading.get_ident()

    def on_start(self, event: Any) -> None:
        if threading.get_ident() == self._thread:
            raise _NotCached

    def on_end(self, event: Any) -> None:
        pass

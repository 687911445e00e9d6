# SPDX-License-Identifier: Apache-2.0
"""What has to be compiled is compiled by another process, once; then it is loaded."""

from __future__ import annotations

import importlib
import subprocess
from pathlib import Path
from typing import Any

import pytest

from evcot.compiling import compiled_aside

_KERNEL = """
from numba import njit
@njit(cache=True)
def twice(value):
    return value + value
def prepare(value):
    twice(value)
"""


def counts(kernel: Any) -> tuple[int, int]:
    """How often a kernel was found in the cache, and how often not."""
    return sum(kernel.stats.cache_hits.values()), sum(kernel.stats.cache_misses.values())


def watched(monkeypatch: pytest.MonkeyPatch) -> list[subprocess.Popen[bytes]]:
    """The processes that are begun from now on."""
    children: list[subprocess.Popen[bytes]] = []
    begin = subprocess.Popen

    def begun(*arguments: Any, **options: Any) -> subprocess.Popen[bytes]:
        children.append(begin(*arguments, **options))
        return children[-1]

    monkeypatch.setattr(subprocess, "Popen", begun)
    return children


def test_a_process_of_its_own_fills_the_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "evcot_kernel_aside.py").write_text(_KERNEL)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    children = watched(monkeypatch)
    module = importlib.import_module("evcot_kernel_aside")
    compiled_aside(module.prepare, 3)
    assert [child.returncode for child in children] == [0]
    assert counts(module.twice) == (1, 1), "missing at first, then loaded"
    again = importlib.reload(module)
    compiled_aside(again.prepare, 4)
    assert len(children) == 1
    assert again.twice(4) == 8


def test_without_another_process_it_is_compiled_here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "evcot_kernel_here.py").write_text(_KERNEL)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr("evcot.compiling._CHILD", "raise SystemExit(1)")
    module = importlib.import_module("evcot_kernel_here")
    compiled_aside(module.prepare, 3)
    assert counts(module.twice) == (0, 2), "missing at first, then compiled"
    assert module.twice(3) == 6

# SPDX-License-Identifier: Apache-2.0
"""What the command line leaves out of Numba, in a process of its own."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

KERNEL = "from evcot._numba_private import njit; assert njit(lambda x: x + {0})(1) == 1 + {0}"
UNUSED = {"importlib.metadata", "colorama", "scipy", "yaml", "cffi", "numba.core.entrypoints"}
CACHED = "from evcot.bits import lowest; lowest(6)"
TYPES_TO_COMPILE = {"numba.np.arraymath", "scipy.linalg"}


def loaded_after(*lines: str) -> set[str]:
    """The modules that a process has loaded after these lines."""
    code = "\n".join([*lines, "import sys; print(*(name for name in sys.modules if sys.modules[name] is not None))"])
    return set(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split())


def test_a_command_runs_compiled_kernels_without_packages_that_it_does_not_use() -> None:
    loaded_after(CACHED)
    loaded = loaded_after("import evcot_cosim.cli", CACHED)
    assert "numba" in loaded
    assert not loaded & (UNUSED | TYPES_TO_COMPILE)


def test_a_kernel_that_is_compiled_after_one_from_the_cache_has_what_a_compilation_needs() -> None:
    assert loaded_after(CACHED, KERNEL.format(1)) >= TYPES_TO_COMPILE


def test_a_kernel_of_another_package_is_loaded_as_numba_does_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "evcot_of_a_user.py").write_text("import numba\nkernel = numba.njit(cache=True)(lambda x: x + 1)\n")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=os.pathsep)
    lines = "import evcot._numba_private, evcot_of_a_user", "assert evcot_of_a_user.kernel(1) == 2"
    loaded_after(*lines)
    assert loaded_after(*lines) >= TYPES_TO_COMPILE


def test_extensions_of_numba_are_looked_for_once_plug_ins_have_been() -> None:
    """The first kernel comes from the cache; the second may be a plug-in's."""
    plug_ins = "from importlib.metadata import entry_points"
    extensions = "import sys; assert sys.modules['numba.core.entrypoints']._already_initialized"
    loaded_after("import evcot_cosim.cli", CACHED, plug_ins, KERNEL.format(2), extensions)


def test_a_library_has_numba_as_it_is() -> None:
    assert "numba.core.entrypoints" in loaded_after(KERNEL.format(1))

# SPDX-License-Identifier: Apache-2.0
"""Kernels: compiled in another process, kept, forgotten when stale; what the command line leaves out of Numba."""

from __future__ import annotations

import importlib
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from evcot._stale_kernels import forget_stale_kernels
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


SOURCES = ("__init__.py", "events.py", "rct/kernel.py", "rct/merge.py", "filters/chain.py")


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A package with a kernel beside each source, and known as it is."""
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    for name in SOURCES:
        source = tmp_path / name
        (source.parent / "__pycache__").mkdir(parents=True, exist_ok=True)
        source.write_text("x = 1\n")
    forget_stale_kernels(tmp_path)
    for name in SOURCES:
        source = tmp_path / name
        for suffix in ("nbi", "1.nbc"):
            (source.parent / "__pycache__" / f"{source.stem}.f-1.py311.{suffix}").write_text("compiled")
    return tmp_path


def kernels(package: Path) -> set[str]:
    """The folders that have kernels."""
    return {path.parent.parent.relative_to(package).as_posix() for path in package.rglob("*.nb[ci]")}


@pytest.mark.parametrize(
    ("changed", "left"), [("rct/merge.py", {".", "filters"}), ("filters/chain.py", {".", "rct"}), ("events.py", set())]
)
def test_a_change_drops_the_kernels_beside_and_below(package: Path, changed: str, left: set[str]) -> None:
    (package / changed).write_text("x = 22\n")
    assert forget_stale_kernels(package)
    assert kernels(package) == left
    assert forget_stale_kernels(package) == []


def test_a_source_that_comes_or_goes_is_a_change_and_nothing_else(package: Path) -> None:
    assert forget_stale_kernels(package) == []
    assert kernels(package) == {".", "rct", "filters"}
    (package / "rct" / "size.py").write_text("y = 1\n")
    assert forget_stale_kernels(package) == ["rct"]
    (package / "rct" / "size.py").unlink()
    assert forget_stale_kernels(package) == ["rct"]


@pytest.mark.parametrize("content", ["", "[1]", "no json"])
def test_where_nothing_is_known_all_are_forgotten(package: Path, content: str) -> None:
    (package / "__pycache__" / "kernels.json").write_text(content)
    forget_stale_kernels(package)
    assert kernels(package) == set()


def test_a_kernel_follows_a_function_in_another_file(tmp_path: Path) -> None:
    """With Numba itself: without this, the old sum would come out."""
    package = tmp_path / "evcot_like"
    package.mkdir()
    (package / "__init__.py").write_text(
        "from pathlib import Path\nfrom evcot._stale_kernels import forget_stale_kernels\n"
        "forget_stale_kernels(Path(__file__).parent)\n"
    )
    (package / "inner.py").write_text("from numba import njit\n\n@njit(cache=True)\ndef inner(x):\n    return x + 1\n")
    (package / "outer.py").write_text(
        "from numba import njit\nfrom .inner import inner\n\n@njit(cache=True)\ndef outer(x):\n    return 10 * inner(x)\n"
    )
    environment = {name: value for name, value in os.environ.items() if name != "NUMBA_CACHE_DIR"}
    run = [sys.executable, "-c", "from evcot_like.outer import outer; print(outer(1))"]
    assert subprocess.run(run, cwd=tmp_path, capture_output=True, text=True, check=True, env=environment).stdout == "20\n"
    (package / "inner.py").write_text("from numba import njit\n\n@njit(cache=True)\ndef inner(x):\n    return x + 22\n")
    assert subprocess.run(run, cwd=tmp_path, capture_output=True, text=True, check=True, env=environment).stdout == "230\n"


KERNELS = """
from numba import njit
from pathlib import Path
import evcot
@njit(cache=True)
def twice(x):
    return 2 * x
print(twice(21), sum(twice.stats.cache_hits.values()), twice.stats.cache_path)
"""


@pytest.mark.parametrize("own", [False, True], ids=["EVCOT_CACHE", "NUMBA_CACHE_DIR of the user's"])
def test_kernels_are_kept_in_the_cache_of_all_that_is_compiled(tmp_path: Path, own: bool) -> None:
    (tmp_path / "kernels.py").write_text(KERNELS)
    cache, numba = tmp_path / "cache", tmp_path / "numba"
    environment = {name: value for name, value in os.environ.items() if name != "NUMBA_CACHE_DIR"}
    environment |= {"EVCOT_CACHE": str(cache)} | ({"NUMBA_CACHE_DIR": str(numba)} if own else {})
    # Numba reads its configuration when it is imported: evcot must come first.
    script = "import sys, evcot; sys.path.insert(0, '.'); import kernels"
    said = [
        subprocess.run(
            [sys.executable, "-c", script], cwd=tmp_path, env=environment, capture_output=True, text=True, check=True,
        ).stdout.split()
        for _ in range(2)
    ]  # fmt: skip
    assert [words[:2] for words in said] == [["42", "0"], ["42", "1"]]
    assert Path(said[0][2]).is_relative_to(numba if own else cache / "numba")


def test_kernels_in_the_cache_are_forgotten_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from numba.core.caching import UserProvidedCacheLocator

    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "numba"))
    source = tmp_path / "package" / "rct" / "kernel.py"
    source.parent.mkdir(parents=True)
    source.write_text("x = 1\n")
    forget_stale_kernels(tmp_path / "package")
    kernel = tmp_path / "numba" / UserProvidedCacheLocator.get_suitable_cache_subpath(str(source)) / "kernel.f-1.py311.nbi"
    kernel.parent.mkdir(exist_ok=True)
    kernel.write_text("compiled")
    assert forget_stale_kernels(tmp_path / "package") == []
    source.write_text("x = 22\n")
    assert forget_stale_kernels(tmp_path / "package") == ["rct"]
    assert not kernel.exists()


@pytest.mark.parametrize(("imports", "cache"), [("evcot", "file"), ("numba, evcot", ".")])
def test_a_cache_that_cannot_be_written_or_was_chosen_before_is_left_alone(tmp_path: Path, imports: str, cache: str) -> None:
    """Numba that was imported first would not see another: stale kernels would be looked for where there are none."""
    (tmp_path / "file").write_text("")
    environment = {name: value for name, value in os.environ.items() if name != "NUMBA_CACHE_DIR"}
    script = f"import os, {imports}; print(os.environ.get('NUMBA_CACHE_DIR'))"
    run = subprocess.run(
        [sys.executable, "-c", script], env=environment | {"EVCOT_CACHE": str(tmp_path / cache)},
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert run.stdout.strip() == "None"


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

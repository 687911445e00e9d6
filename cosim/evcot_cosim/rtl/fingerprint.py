# SPDX-License-Identifier: Apache-2.0
"""Fingerprints of what a run's result depends on: sources of evcot and of the RTL, versions of libraries."""

from __future__ import annotations

import platform
from collections.abc import Sequence
from functools import cache
from hashlib import blake2b
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path

import evcot

from .files import rtl_files

__all__ = ["code_fingerprint", "design_fingerprint", "versions"]

_RESULTS_DEPEND_ON = ("numpy", "numba", "scipy")
_PACKAGES = ("devices", "lockstep", "rtl")  # of evcot_cosim, besides all of evcot


def versions() -> dict[str, str]:
    """Versions of what a result could depend on."""
    packages = {name: version(name) for name in _RESULTS_DEPEND_ON}
    return {"evcot": evcot.__version__, "python": platform.python_version(), **packages}


@cache
def code_fingerprint(further: Sequence[Path] = ()) -> str:
    """A digest of evcot's sources and `versions`: 16 hexadecimal digits.

    Args:
        further: source files on which the result depends, too.
    """
    summary = blake2b(repr(sorted(versions().items())).encode(), digest_size=8)
    spec = find_spec("evcot")
    assert spec is not None
    assert spec.submodule_search_locations is not None
    package = Path(spec.submodule_search_locations[0])
    for folder in (package, *(Path(__file__).parents[1] / name for name in _PACKAGES)):
        for path in sorted((*folder.rglob("*.py"), *folder.rglob("*.cpp.j2"), *folder.rglob("*.toml"))):
            summary.update(str(path.relative_to(folder)).encode())
            summary.update(path.read_bytes())
    for path in further:
        summary.update(path.read_bytes())
    return summary.hexdigest()


@cache
def design_fingerprint() -> str:
    """A digest of the RTL's sources: 16 hexadecimal digits."""
    summary = blake2b(digest_size=8)
    for name, path in sorted(rtl_files().items()):
        summary.update(name.encode())
        summary.update(path.read_bytes())
    return summary.hexdigest()

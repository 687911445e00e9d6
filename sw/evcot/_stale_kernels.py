# SPDX-License-Identifier: Apache-2.0
"""Where Numba keeps compiled kernels, and which of them may be stale.

Numba caches compiled code in `__pycache__`, or below $NUMBA_CACHE_DIR, and recompiles when the file of a function changes. It
does not detect changes in other files, of functions or constants that were compiled into the kernel. Here any changed source
file invalidates the kernels of its own folder and of the folders below: kernels use only code in their folder or above it.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import sys
from pathlib import Path

__all__ = ["forget_stale_kernels", "keep_kernels_in_cache"]

_KNOWN = "kernels.json"

Stamps = dict[str, list[int]]  # source, as seen from the package -> time of its last change, ns; bytes


def keep_kernels_in_cache() -> None:
    """Have Numba keep its kernels below $EVCOT_CACHE, where evcot keeps all that it compiles.

    Without EVCOT_CACHE, with a NUMBA_CACHE_DIR of the user's, or where nothing can be written there, Numba chooses; as it does
    if it has been imported before, since it reads its environment then.
    """
    chosen = os.environ.get("EVCOT_CACHE")
    if not chosen or os.environ.get("NUMBA_CACHE_DIR") or "numba" in sys.modules:
        return
    folder = Path(chosen).absolute() / "numba"
    with contextlib.suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
        if os.access(folder, os.W_OK | os.X_OK):
            os.environ["NUMBA_CACHE_DIR"] = str(folder)


def forget_stale_kernels(package: Path) -> list[str]:
    """Delete the kernels of a package that may be stale, and return the folders concerned. About 2 ms.

    Does nothing if the package is not writable: Numba then caches elsewhere, and such a package does not change.
    """
    known = _kernels_of(package, "") / _KNOWN
    now, before = _stamps(package), _read(known)
    if now == before:
        return []
    changed = {os.path.dirname(name) for name in now.keys() | before.keys() if now.get(name) != before.get(name)}
    folders = sorted({os.path.dirname(name) for name in now})
    stale = [folder for folder in folders if any(_holds(above, folder) for above in changed)]
    with contextlib.suppress(OSError):
        for folder in stale:
            for kernel in _kernels_of(package, folder).glob("*.nb[ci]"):
                kernel.unlink(missing_ok=True)
        aside = known.with_suffix(f".{os.getpid()}")
        known.parent.mkdir(parents=True, exist_ok=True)
        aside.write_text(json.dumps(now), encoding="utf-8")
        aside.replace(known)
    return stale


def _kernels_of(package: Path, folder: str) -> Path:
    """The folder of the kernels of a folder's sources, as Numba's locators name it."""
    sources = os.path.abspath(package / folder)
    if not (chosen := os.environ.get("NUMBA_CACHE_DIR")):
        return Path(sources) / "__pycache__"
    return Path(chosen) / f"{os.path.basename(sources)}_{hashlib.sha1(sources.encode()).hexdigest()}"


def _stamps(package: Path) -> Stamps:
    sources = ((path.relative_to(package).as_posix(), path.stat()) for path in package.rglob("*.py"))
    return {name: [stat.st_mtime_ns, stat.st_size] for name, stat in sources}


def _read(known: Path) -> Stamps:
    """The stored stamps; empty if they cannot be read."""
    try:
        stamps = json.loads(known.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return stamps if isinstance(stamps, dict) else {}


def _holds(above: str, folder: str) -> bool:
    """Whether one folder is, or contains, the other; the package's own is the empty string."""
    return above in ("", folder) or folder.startswith(f"{above}/")

# SPDX-License-Identifier: Apache-2.0
"""Description of a worker: versions, a fingerprint of the program, and the contents of recordings as it sees them."""

from __future__ import annotations

import os
import platform
import socket
from collections.abc import Mapping, Sequence
from functools import cache
from hashlib import blake2b
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import evcot
from evcot.errors import ConfigError

from ..rtl.files import rtl_files
from .places import local

__all__ = ["Machine", "check_same", "code_fingerprint", "content_of", "design_fingerprint", "probe", "versions"]

Machine = Mapping[str, Any]
"""What `probe` says of a worker: host, versions, code, and contents: path -> digest, empty where it cannot be read."""

_RESULTS_DEPEND_ON = ("numpy", "numba", "scipy")
_ROOMS = ("devices", "lockstep", "rtl")  # of this package, by which a result could change; and of this room:
_MODULES = ("checkpoints", "configure", "cost", "execute", "fields", "inputs", "places", "task")
_BLOCK = 1 << 22


def versions() -> dict[str, str]:
    """Of what a result could depend on."""
    packages = {name: version(name) for name in _RESULTS_DEPEND_ON}
    return {"evcot": evcot.__version__, "python": platform.python_version(), **packages}


@cache
def code_fingerprint() -> str:
    """A digest of evcot's sources and of the versions of what it computes with: 16 hexadecimal digits."""
    summary = blake2b(repr(sorted(versions().items())).encode(), digest_size=8)
    room = Path(__file__).parents[1]
    spec = find_spec("evcot")
    assert spec is not None
    assert spec.submodule_search_locations is not None
    package = Path(spec.submodule_search_locations[0])
    for folder in (package, *(room / name for name in _ROOMS)):
        for path in sorted((*folder.rglob("*.py"), *folder.rglob("*.cpp.j2"), *folder.rglob("*.toml"))):
            summary.update(str(path.relative_to(folder)).encode())
            summary.update(path.read_bytes())
    for name in _MODULES:
        summary.update(Path(__file__).with_name(f"{name}.py").read_bytes())
    return summary.hexdigest()


@cache
def design_fingerprint() -> str:
    """A digest of the RTL's sources: 16 hexadecimal digits."""
    summary = blake2b(digest_size=8)
    for name, path in sorted(rtl_files().items()):
        summary.update(name.encode())
        summary.update(path.read_bytes())
    return summary.hexdigest()


def content_of(path: Path | str) -> str:
    """Digest of a file's bytes, or of all files in a folder; read once as long as size and time of change stay.

    Raises:
        OSError: it cannot be read.
    """
    path = local(str(path))
    if path.is_dir():
        inner = sorted(each for each in path.rglob("*") if each.is_file())
        text = "".join(f"{each.relative_to(path)}:{content_of(each)}\n" for each in inner)
        return blake2b(text.encode(), digest_size=8).hexdigest()
    state = path.stat()
    return _content(str(path.absolute()), state.st_size, state.st_mtime_ns)


@cache
def _content(path: str, _size: int, _changed_ns: int) -> str:
    summary = blake2b(digest_size=8)
    with open(path, "rb") as file:
        while block := file.read(_BLOCK):
            summary.update(block)
    return summary.hexdigest()


def probe(paths: Sequence[str]) -> dict[str, Any]:
    """What this process is, and what it sees under these paths."""
    contents = {}
    for path in paths:
        try:
            contents[path] = content_of(path)
        except OSError:
            contents[path] = ""
    found = {"host": socket.gethostname(), "pid": os.getpid(), "versions": versions(), "code": code_fingerprint()}
    return {**found, "design": design_fingerprint(), "contents": contents}


def check_same(own: Machine, workers: Mapping[str, Machine]) -> None:
    """Raise ConfigError for a worker with other versions, another program, or other recordings than this process."""
    for name, worker in sorted(workers.items()):
        where = f"worker {name} on {worker['host']}"
        for package, wanted in own["versions"].items():
            found = worker["versions"].get(package, "none")
            if found != wanted:
                raise ConfigError(f"{where}: has {package} {found}: must be {wanted}, as here")
        for what, title in (("code", "sources of evcot"), ("design", "RTL")):
            if worker[what] != own[what]:
                raise ConfigError(f"{where}: {title} differ ({worker[what]}): must be those here ({own[what]})")
        for path, content in own["contents"].items():
            found = worker["contents"].get(path, "")
            if found != content:
                fault = "differs from the one here" if found else "is missing"
                raise ConfigError(f"{path}: {fault} on {where}: must be the same file on every worker")

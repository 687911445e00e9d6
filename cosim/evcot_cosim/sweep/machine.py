# SPDX-License-Identifier: Apache-2.0
"""Description of a worker: versions, a fingerprint of the program, and the contents of recordings as it sees them."""

from __future__ import annotations

import os
import socket
from collections.abc import Mapping, Sequence
from functools import cache
from hashlib import blake2b
from pathlib import Path
from typing import Any

from evcot.errors import ConfigError
from evcot.trackers.engines import ENGINES

from ..rtl import files
from ..rtl.files import design_fingerprint, versions
from .places import local

__all__ = ["Machine", "check_same", "code_fingerprint", "code_of", "content_of", "probe"]

Machine = Mapping[str, Any]
"""What `probe` says of a worker: host, versions, code, and contents: path -> digest, empty where it cannot be read."""

# Modules of this folder by which a result could change.
_MODULES = ("checkpoints", "execute", "fields", "inputs", "places", "task")
_BLOCK = 1 << 22


@cache
def code_fingerprint() -> str:
    """A digest of all of evcot's sources that a run's result depends on, see `rtl.files.code_fingerprint`."""
    return files.code_fingerprint(tuple(Path(__file__).with_name(f"{name}.py") for name in _MODULES))


@cache
def code_of(engine: str) -> str:
    """As `code_fingerprint`; of an engine of another package with the package's sources."""
    sources = ENGINES[engine].sources if engine in ENGINES else []
    if not sources:
        return code_fingerprint()
    summary = blake2b(code_fingerprint().encode(), digest_size=8)
    for path in sources:
        summary.update(path.name.encode())
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

# SPDX-License-Identifier: Apache-2.0
"""Where recordings and truths lie: a path, or a URL of fsspec, whose file every machine copies into its cache once."""

from __future__ import annotations

import re
import shutil
import tempfile
from collections.abc import Sequence
from hashlib import blake2b
from pathlib import Path
from typing import Any

from evcot.errors import ConfigError

from ..rtl.build import cache_dir

__all__ = ["exists", "files_in", "is_url", "local", "placed", "stem_of"]

_URL = re.compile(r"[A-Za-z][A-Za-z0-9+.\-]+(::|://)")


def is_url(name: str) -> bool:
    """Whether a name is a URL, and no path."""
    return _URL.match(name) is not None


def placed(folder: Path, name: str) -> str:
    """A path relative to a folder; a URL stays what it is."""
    return name if is_url(name) else str(folder / name)


def local(name: str) -> Path:
    """The file on this machine: a path itself; of a URL the copy in the cache, made where it is not there or has changed.

    Raises:
        OSError: it cannot be read.
        ConfigError: fsspec, or what it needs for this URL, is not installed.
    """
    if not is_url(name):
        return Path(name)
    files, path = _opened(name)
    state = blake2b(f"{name}\n{files.ukey(path)}".encode(), digest_size=16).hexdigest()
    folder = cache_dir() / "recordings" / state
    copy = folder / name.rstrip("/").rpartition("/")[2]
    if copy.is_file():
        return copy
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile(dir=folder, delete=False) as aside:
        try:
            with files.open(path, "rb") as source:
                shutil.copyfileobj(source, aside, 1 << 22)
        except BaseException:
            Path(aside.name).unlink()
            raise
    Path(aside.name).replace(copy)
    return copy


def exists(name: str) -> bool:
    """Whether there is a file."""
    if not is_url(name):
        return Path(name).is_file()
    files, path = _opened(name)
    return bool(files.isfile(path))


def files_in(name: str) -> Sequence[str] | None:
    """The files in a folder, by name; None for what is no folder.

    Raises:
        OSError: there is nothing.
    """
    if not is_url(name):
        folder = Path(name)
        if not folder.exists():
            raise FileNotFoundError(2, "No such file or directory")
        return None if folder.is_file() else [str(each) for each in sorted(folder.iterdir()) if each.is_file()]
    files, path = _opened(name)
    if not files.exists(path):
        raise FileNotFoundError(2, "No such file or directory")
    if files.isfile(path):
        return None
    found = files.ls(path, detail=True)
    return sorted(files.unstrip_protocol(each["name"]) for each in found if each["type"] == "file")


def stem_of(name: str) -> str:
    """The name without its suffix: of a path or URL, all before the last dot of its last part."""
    folder, slash, last = name.rpartition("/")
    return folder + slash + (Path(last).stem if last else last)


def _opened(url: str) -> tuple[Any, str]:
    try:
        import fsspec

        files, path = fsspec.core.url_to_fs(url)
    except (ImportError, ValueError) as error:
        text = " ".join(str(error).split())[:160]
        raise ConfigError(f"{url}: cannot be opened: {text} (pip install fsspec, and what it needs for this URL)") from error
    return files, path

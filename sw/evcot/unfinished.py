# SPDX-License-Identifier: Apache-2.0
"""Long work that continues where it was when its process was killed: a folder beside its output, with a checkpoint.

The folder `.NAME.unfinished` holds files that only grow, and `checkpoint`, the state of everything else at some moment,
with how long the files were. It is removed when the work is done, and when it fails; it stays when the process ends in
between, and when a file cannot be written: on a full disk, or where the user's files are in the way. What other settings or
other inputs left there is not used.

The file `lock` in it says that evcot made it. A folder without this file, or a link, is the user's and is refused.
"""

from __future__ import annotations

import errno
import io
import os
import pickle
import secrets
import shutil
import stat
import tempfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from enum import EnumType
from hashlib import blake2b
from pathlib import Path
from typing import Any

from .errors import OutputError, reason_of
from .outputs import spool_folder

__all__ = ["CHECKPOINT_EVENTS", "Unfinished", "folder_of", "unfinished"]

CHECKPOINT_EVENTS = 1 << 24  # between two checkpoints, by default

_STATE, _LOCK = "checkpoint", "lock"
_HEAD = b"evcot checkpoint 1\n"
_MARK = b"evcot: unfinished work, removed when it is done\n"  # content of the lock
_DIGEST_BYTES = 16
_FULL = (errno.ENOSPC, errno.EDQUOT)
_OURS = ("evcot", "evcot_cosim")  # packages whose classes a checkpoint may hold
_OTHERS = {  # and what else: how NumPy and Python store values
    ("builtins", "set"), ("builtins", "frozenset"), ("builtins", "slice"), ("builtins", "iter"),
    ("collections", "deque"), ("collections", "Counter"), ("collections", "OrderedDict"),
    ("numpy", "dtype"), ("numpy", "ndarray"), ("numpy._core.multiarray", "_reconstruct"),
    ("numpy._core.multiarray", "scalar"), ("numpy._core.numeric", "_frombuffer"), ("numpy.core.multiarray", "_reconstruct"),
    ("numpy.core.multiarray", "scalar"), ("numpy.core.numeric", "_frombuffer"),
}  # fmt: skip


class Unfinished:
    """The folder of one piece of work, made by `unfinished`.

    Attributes:
        folder: for the files of the work.
        state: what was saved last; None at the beginning.
        held: closed when the work ends, whichever way, before the folder is removed.
    """

    def __init__(self, folder: Path, key: Callable[[], str]) -> None:
        self.folder = folder
        self._key = key
        self.state: dict[str, Any] | None = None
        self.held = ExitStack()

    def save(self, state: dict[str, Any]) -> None:
        """Keep a state, in place of the last one; the files that it speaks of must have been flushed before.

        Args:
            state: objects of evcot and of NumPy, and plain values.

        Raises:
            OutputError: it cannot be written; the last one is kept.
        """
        content = self._key().encode() + b"\n" + pickle.dumps(state, protocol=5)
        place, aside = self.folder / _STATE, self.folder / f"{_STATE}.new"
        try:
            with aside.open("wb") as file:
                file.write(_HEAD + blake2b(content, digest_size=_DIGEST_BYTES).digest() + content)
                file.flush()
                os.fsync(file.fileno())
            os.replace(aside, place)
        except OSError as error:
            raise OutputError(f"{place}: cannot be written: {reason_of(error, aside)}") from error
        self.state = state

    def load(self) -> None:
        """Set `state` to what was saved by the same work, or None."""
        try:
            stored = (self.folder / _STATE).read_bytes()
        except FileNotFoundError:
            return
        begin = len(_HEAD) + _DIGEST_BYTES
        content = stored[begin:]
        key = self._key().encode() + b"\n"
        whole = stored[:begin] == _HEAD + blake2b(content, digest_size=_DIGEST_BYTES).digest()
        if whole and content.startswith(key):
            self.state = _Unpickler(io.BytesIO(content[len(key) :])).load()


class _Unpickler(pickle.Unpickler):
    """Makes classes of evcot, and values of NumPy and Python, and calls nothing else."""

    def find_class(self, module: str, name: str) -> Any:
        if (module, name) == ("builtins", "getattr"):
            return _attribute
        found = super().find_class(module, name) if module.split(".")[0] in _OURS or (module, name) in _OTHERS else None
        if found is None or (module.split(".")[0] in _OURS and not (isinstance(found, type) and found.__module__ == module)):
            raise pickle.UnpicklingError(f"{module}.{name}: must be a class of evcot or a value of NumPy")
        return found


def _attribute(owner: object, name: str) -> Any:
    """A method of one of evcot's objects, or a member of one of its enumerations: Python stores both by name."""
    if isinstance(owner, EnumType) and owner.__module__.split(".")[0] in _OURS and name in owner.__members__:
        return owner.__members__[name]
    if name.startswith("__") or type(owner).__module__.split(".")[0] not in _OURS:
        raise pickle.UnpicklingError(f"{name}: must be a method of an object of evcot, or a member of an enumeration")
    return getattr(owner, name)


def folder_of(path: Path) -> Path:
    """The folder of the unfinished work that will write `path`."""
    target = Path(os.path.realpath(path))
    return target.with_name(f".{target.name}.unfinished")


@contextmanager
def unfinished(path: Path, key: Callable[[], str]) -> Iterator[Unfinished]:
    """The folder of the work that will write `path`; with the last state, if the same work was ended before it was done.

    Args:
        key: a text that changes with everything on which the result depends; it is called only when it is needed.

    Raises:
        OutputError: another process is at the same work, the folder cannot be written, or a file of the work cannot: then,
            after a checkpoint, the folder stays.
    """
    folder = folder_of(path)
    try:
        special = spool_folder(path) != folder.parent  # a pipe or a device: nothing to continue
        parents = [parent for parent in folder.parents if not parent.exists()]
        if not special:
            folder.parent.mkdir(parents=True, exist_ok=True)
            _make(folder)
    except OSError as error:
        raise OutputError(f"{path}: cannot be written: {reason_of(error, path)}") from error
    if special:
        with tempfile.TemporaryDirectory() as temporary:
            work = Unfinished(Path(temporary), key)
            with work.held:
                yield work
        return
    with _locked(folder, path):
        work = Unfinished(folder, key)
        work.load()
        try:
            with work.held:
                yield work
        except OSError as error:
            if work.state is None:
                _remove(folder, parents)
                raise
            remedy = "free some space" if _is_full(error) else "remove the cause"
            rule = f"{remedy} and give the same command again: it goes on from its last checkpoint"
            raise OutputError(f"{_said(error)}; {rule} (kept in {folder})") from error
        except Exception:
            _remove(folder, parents)
            raise
        except BaseException:
            if work.state is None:
                _remove(folder, parents)
            raise
        shutil.rmtree(folder, ignore_errors=True)


def _make(folder: Path) -> None:
    """Make the folder with its lock, at once, unless there is one that evcot made.

    Raises:
        OutputError: there is something else of that name.
    """
    if not os.path.lexists(folder):
        aside = folder.with_name(f"{folder.name}.{secrets.token_hex(4)}")
        aside.mkdir()
        try:
            with (aside / _LOCK).open("xb") as lock:
                lock.write(_MARK)
            os.rename(aside, folder)
            return
        except OSError:
            shutil.rmtree(aside, ignore_errors=True)
            if not os.path.lexists(folder):
                raise
    mark = folder / _LOCK
    is_folder = stat.S_ISDIR(folder.lstat().st_mode)
    if not is_folder or mark.is_symlink() or not mark.is_file() or mark.read_bytes() != _MARK:
        raise OutputError(f"{folder}: exists, and evcot did not make it: must be moved away, or another output named")


def _is_full(error: BaseException | None) -> bool:
    """Whether an error, or one that it was made of, is that of a full disk."""
    while error is not None:
        if isinstance(error, OSError) and error.errno in _FULL:
            return True
        error = error.__cause__ or error.__context__
    return False


def _said(error: OSError) -> str:
    """An error in one line; of one that is Python's own, with its file."""
    if isinstance(error, OutputError):
        return str(error)
    named = error.filename or "a file"
    return f"{named}: cannot be written: {reason_of(error, named)}"


@contextmanager
def _locked(folder: Path, path: Path) -> Iterator[None]:
    """Keep other processes out of the folder; on Windows, which has no such locks, nobody is kept out."""
    try:
        import fcntl
    except ImportError:
        yield
        return
    try:
        lock = (folder / _LOCK).open("r+b")
    except OSError as error:
        raise OutputError(f"{path}: cannot be written: {reason_of(error, path)}") from error
    with lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            raise OutputError(f"{path}: is being written by another process: must be another file") from error
        yield


def _remove(folder: Path, parents: list[Path]) -> None:
    shutil.rmtree(folder, ignore_errors=True)
    for parent in parents:
        try:
            parent.rmdir()
        except OSError:
            return

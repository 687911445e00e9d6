# SPDX-License-Identifier: Apache-2.0
"""The policy for all output files: no file of the user is ever destroyed.

- A file appears under its name only when it is complete. An existing file is refused, unless `force` allows replacing it.
- Links are followed: the target is checked and written. Pipes, character devices and open descriptors are written through.
- A folder is replaced only by the command that made it, and only the files in it that this command wrote: run.toml names the
  command and lists the files with their digests. Files that the user added or changed are never touched, and a list with
  anything but plain names of files in the folder is none.
- An output is never an input of the same call, nor another output of it: files are compared by inode, not by name.
"""

from __future__ import annotations

import os
import re
import secrets
import shutil
import stat
import sys
import tempfile
import weakref
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from hashlib import blake2b
from pathlib import Path
from typing import Any, BinaryIO

from .errors import ConfigError, OutputError, reason_of
from .toml_file import toml_tables

__all__ = [
    "RUN_FILE",
    "Claims",
    "check_file",
    "check_folder",
    "folder_written_aside",
    "is_own_file",
    "is_plain_name",
    "new_file",
    "note_input",
    "own_files",
    "path_written_aside",
    "reading",
    "remade",
    "spool_folder",
    "suffix_of",
    "written_aside",
]

RUN_FILE = "run.toml"  # in every folder that evcot makes: the inputs, and the files that evcot wrote there
_LIST = "\n[made]  # the command that owns this folder, and the files that it wrote: only these are ever replaced\n"
_MOVED_LAST = ("summary.json", RUN_FILE)  # without them a folder does not look complete
_NEVER_READ = ("report.html", "picture.png")  # files of a run's folder that are not an input of any command
_BLOCK = 1 << 20
_RUN_FILE_BYTES = 1 << 24  # of run.toml: what is larger, evcot did not write
_PARTIAL = re.compile(r"\..*\.[0-9a-f]{8}\.partial")  # left behind by a killed process
_DESCRIPTOR = re.compile(r"/dev/std(out|err)|/(?:dev|proc/self)/fd/([0-9]+)")

_Inode = tuple[int, int]
_being_read: Counter[_Inode] = Counter()
_call: ContextVar[Claims | None] = ContextVar("call", default=None)


# ---- single files


@contextmanager
def written_aside(path: Path, *, force: bool = False) -> Iterator[BinaryIO]:
    """Open a temporary file next to `path` that replaces it when the block ends without an error.

    If the block is interrupted in any way, `path` keeps its content and the temporary file is removed.

    Args:
        force: replace an existing file.

    Raises:
        OutputError: the file exists, is an input, or cannot be written.
    """
    with path_written_aside(path, force=force) as aside, aside.open("xb") as file:
        yield file


@contextmanager
def path_written_aside(path: Path, *, force: bool = False) -> Iterator[Path]:
    """As `written_aside`, for libraries that open files themselves: yields the path to write to."""
    with _in_one_line(path):
        check_file(path, force=force)
        if _is_special(path):
            with tempfile.TemporaryDirectory() as folder:
                aside = Path(folder) / path.name
                yield aside
                with aside.open("rb") as source, _through(path) as file:
                    shutil.copyfileobj(source, file)
            return
        target = _resolved(path)
        aside = _beside(target)
        try:
            yield aside
            _place(aside, target, path, force)
        finally:
            aside.unlink(missing_ok=True)


def new_file(path: Path, *, force: bool = False, buffering: int = -1) -> BinaryIO:
    """Open a file that has its final name from the start, so that its content can be read even if the process is killed.

    Raises:
        OutputError: as for `written_aside`.
    """
    with _in_one_line(path):
        check_file(path, force=force)
        if _is_special(path):
            return _through(path)
        target = _resolved(path)
        aside = _beside(target)
        file = open(aside, "xb", buffering=buffering)  # noqa: SIM115
        try:
            _place(aside, target, path, force)
        except BaseException:
            file.close()
            raise
        finally:
            aside.unlink(missing_ok=True)
        return file


def check_file(path: Path, title: str = "", *, force: bool = False) -> None:
    """Raise OutputError if `path` may not be written as a file; `title` names the option in the message."""
    name = f"{title} {path}".strip()
    with _in_one_line(name):
        found = _status(path)
        if found is not None and _inode(found) in _inputs():
            raise OutputError(f"{name}: is an input of the same call: must be another file")
        if _is_special(path):
            return
        if found is not None:
            if stat.S_ISDIR(found.st_mode):
                raise OutputError(f"{name}: is a folder: must be a file")
            if not stat.S_ISREG(found.st_mode):
                raise OutputError(f"{name}: is a block device or a socket: must be a file")
            if not force:
                raise OutputError(f"{name}: {_EXISTS}")
        _check_writable(name, _resolved(path).parent)


def suffix_of(path: Path, suffixes: Sequence[str], title: str = "") -> str:
    """The suffix of an output, in small letters; of a pipe or a device without one, the first of `suffixes`.

    Raises:
        OutputError: it is none of `suffixes`; `title` names the option in the message.
    """
    suffix = (path.suffix or _resolved(path).suffix).lower()  # a link may have another name
    if not suffix and _is_special(path):
        return suffixes[0]
    if suffix not in suffixes:
        name = f"{title} {path}".strip()
        rule = f"must be {suffixes[0]}" if len(suffixes) == 1 else f"must be one of {', '.join(suffixes)}"
        raise OutputError(f"{name}: suffix {path.suffix!r}: {rule}")
    return suffix


_EXISTS = "exists: must be another file, or --force must be given to replace it (in Python: force=True)"


def spool_folder(path: Path) -> Path:
    """The folder for temporary files from which `path` will be made: on the same disk."""
    return Path(tempfile.gettempdir()) if _is_special(path) else _resolved(path).parent


def _place(aside: Path, target: Path, path: Path, force: bool) -> None:
    """Rename a file to its final name; without `force`, do not replace even a file created in the meantime."""
    if force:
        os.replace(aside, target)
        return
    try:
        os.link(aside, target)
    except FileExistsError as error:
        raise OutputError(f"{path}: {_EXISTS}") from error
    except OSError:  # a file system without hard links
        if os.path.lexists(target):
            raise OutputError(f"{path}: {_EXISTS}") from None
        os.rename(aside, target)


def _is_special(path: Path) -> bool:
    """Whether the path is written through: a pipe, a character device, or an open descriptor."""
    found = _status(path)
    return bool(found and (stat.S_ISCHR(found.st_mode) or stat.S_ISFIFO(found.st_mode) or _descriptor(path) is not None))


def _descriptor(path: Path) -> int | None:
    named = _DESCRIPTOR.fullmatch(os.path.abspath(path))
    return None if named is None else int(named[2]) if named[2] else 1 + (named[1] == "err")


def _through(path: Path) -> BinaryIO:
    descriptor = _descriptor(path)
    if descriptor is None:
        return open(path, "wb")
    for stream in (sys.stdout, sys.stderr):
        stream.flush()
    return open(os.dup(descriptor), "wb")


def _beside(target: Path) -> Path:
    return target.with_name(f".{target.name}.{secrets.token_hex(4)}.partial")


def _resolved(path: Path) -> Path:
    """The path with all links resolved, even if the last one is dangling."""
    return Path(os.path.realpath(path))


def _status(path: Path) -> os.stat_result | None:
    """Status of the target of a path, None if it does not exist."""
    try:
        return os.stat(path)
    except FileNotFoundError:
        return None


def _inode(found: os.stat_result) -> _Inode:
    return found.st_dev, found.st_ino


def _check_writable(name: str, folder: Path) -> None:
    if not folder.is_dir():
        reason = "Not a directory" if folder.exists() else "No such file or directory"
        raise OutputError(f"{name}: cannot be written: {reason}")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise OutputError(f"{name}: cannot be written: Permission denied")


@contextmanager
def _in_one_line(name: Path | str) -> Iterator[None]:
    try:
        yield
    except OutputError:
        raise
    except OSError as error:
        raise OutputError(f"{name}: cannot be written: {reason_of(error, name)}") from error


# ---- folders


@contextmanager
def folder_written_aside(folder: Path, command: str) -> Iterator[Path]:
    """Make a temporary folder next to `folder`, whose files are moved there if the block ends without an error.

    Only files in `folder` that this command wrote are replaced. run.toml is removed first and written last, so that a folder
    whose replacement was interrupted does not look complete.

    Args:
        command: that makes the folder, such as "cosim"; no other command replaces files in it later.

    Raises:
        OutputError: another command made it, it contains files that evcot did not write, or cannot be written.
    """
    with _in_one_line(folder):
        check_folder(folder, command)
        target = _resolved(folder)
        parents = [parent for parent in target.parents if not parent.exists()]
        aside = _workplace(target)
        try:
            aside.mkdir(parents=True)
            yield aside
            names = sorted(path.name for path in aside.iterdir())
            _sign(aside, command)
            if target.exists():
                check_folder(folder, command, names)
                _move_in(aside, target, names)
            else:
                aside.rename(target)
        except OutputError as error:  # of a file in it: by the name that it was to have
            raise OutputError(str(error).replace(str(aside), str(folder))) from error
        finally:
            shutil.rmtree(aside, ignore_errors=True)
            if not target.exists():
                _remove_empty(parents)


def check_folder(folder: Path, command: str, names: Collection[str] = (), title: str = "") -> None:
    """Raise OutputError if a command may not write these files into a folder; `title` names the option in the message."""
    name = f"{title} {folder}".strip()
    with _in_one_line(name):
        target = _resolved(folder)
        if not os.path.lexists(target):
            _check_writable(name, next(parent for parent in target.parents if parent.exists()))
            return
        if not target.is_dir():
            raise OutputError(f"{name}: is not a folder: must be a new or an empty one")
        _check_writable(name, target)
        present = {file for file in os.listdir(target) if not _PARTIAL.fullmatch(file)}
        own = own_files(target)
        if present and own is None:
            raise OutputError(f"{name}: holds files, and evcot did not make it: must be a new or an empty folder")
        if own is not None and (maker := _made(target)[0]) != command:
            raise OutputError(f"{name}: was made by evcot {maker}: must be another folder for evcot {command}")
        for file in sorted(present & {*names, *(own or ())}):
            if not is_own_file(target / file):
                raise OutputError(
                    f"{name}: holds {file}, which evcot did not write or which has changed since: must be moved away, "
                    "or another folder must be named"
                )
            if _inode(os.stat(target / file)) in _inputs():
                raise OutputError(f"{name}: holds {file}, an input of the same call: must be another folder")


def own_files(folder: Path) -> frozenset[str] | None:
    """The names of the files that evcot wrote into a folder, None if evcot did not make the folder.

    A run.toml copied from elsewhere is not accepted: at least one other file must match its list.
    """
    listed = _made(folder)[1]
    if listed is None or not any(name != RUN_FILE and is_own_file(folder / name) for name in listed):
        return None
    return frozenset(listed)


def is_own_file(path: Path) -> bool:
    """Whether a file is unchanged since evcot wrote it into a folder that evcot made."""
    wanted = (_made(path.parent)[1] or {}).get(path.name)
    return wanted is not None and _is_regular(path) and _digest(path) == wanted


def remade(path: Path) -> None:
    """Update the list of files in run.toml after a file in a folder made by evcot was rewritten; elsewhere, do nothing.

    Raises:
        OutputError: the list cannot be written.
    """
    command, listed = _made(path.parent)
    if listed is not None and is_own_file(path.with_name(RUN_FILE)):
        run = path.with_name(RUN_FILE)
        text = run.read_text(encoding="utf-8").partition(_LIST)[0]
        aside = _beside(run)
        with _in_one_line(run):
            try:  # run.toml may be an input of the call: only its list is changed
                aside.write_bytes((text + _listing(command, listed | {path.name: _digest(path)})).encode())
                os.replace(aside, run)
            finally:
                aside.unlink(missing_ok=True)


def _made(folder: Path) -> tuple[str, dict[str, str] | None]:
    """The command that made a folder, and its files with their digests, by run.toml; None if there is no such list.

    Text in a file is no path: a list with anything but names of files in the folder itself is none.
    """
    run = folder / RUN_FILE
    if not _is_regular(run) or run.stat().st_size > _RUN_FILE_BYTES:
        return "", None
    try:
        _, mark, made = run.read_text(encoding="utf-8").partition(_LIST)
        found = toml_tables(mark + made)
    except (OSError, UnicodeDecodeError, ConfigError):
        return "", None
    files, command = found.get("files"), found.get("made", {}).get("command")
    if not isinstance(files, dict) or not isinstance(command, str):
        return "", None
    plain = all(isinstance(digest, str) and is_plain_name(name) for name, digest in files.items())
    return (command, files) if plain else ("", None)


def is_plain_name(name: str) -> bool:
    """Whether a text is the name of a file in a folder, and not a path that leads elsewhere."""
    return name not in ("", ".", "..") and not any(letter in name for letter in "/\\\0\n")


def _sign(folder: Path, command: str) -> None:
    """Write the command and the list of a folder's files to its run.toml."""
    run = folder / RUN_FILE
    if run.is_file():
        listed = {path.name: _digest(path) for path in sorted(folder.iterdir())}
        with run.open("ab") as file:
            file.write(_listing(command, listed).encode())


def _listing(command: str, digests: dict[str, str]) -> str:
    files = "".join(f'"{name}" = "{digest}"\n' for name, digest in digests.items())
    return f'{_LIST}command = "{command}"\n\n[files]\n{files}'


def _digest(path: Path) -> str:
    """Digest of a file, 16 hexadecimal digits; for run.toml, of the part before its list."""
    summary = blake2b(digest_size=8)
    if path.name == RUN_FILE:
        summary.update(path.read_bytes().partition(_LIST.encode())[0])
        return summary.hexdigest()
    with path.open("rb") as file:
        while block := file.read(_BLOCK):
            summary.update(block)
    return summary.hexdigest()


def _is_regular(path: Path) -> bool:
    return path.is_file() and not path.is_symlink()


def _workplace(target: Path) -> Path:
    """A new folder on the same disk as `target`: next to it if possible, else in it."""
    beside = _beside(target)
    if not target.exists() or (os.access(target.parent, os.W_OK) and not os.path.ismount(target)):
        return beside
    return target / beside.name


def _move_in(aside: Path, target: Path, names: Collection[str]) -> None:
    unchanged = [name for name in own_files(target) or () if is_own_file(target / name)]
    for name in sorted(unchanged, key=RUN_FILE.__ne__):
        (target / name).unlink(missing_ok=True)
    for name in sorted(names, key=lambda name: (name in _MOVED_LAST, name == RUN_FILE)):
        _place(aside / name, target / name, target / name, force=False)


def _remove_empty(folders: Collection[Path]) -> None:
    """Innermost first."""
    for folder in folders:
        try:
            folder.rmdir()
        except OSError:
            return


# ---- inputs and outputs of one call


def reading(owner: object, path: Path) -> Callable[[], Any]:
    """Protect `path`, or all files in it, from being overwritten until the returned function is called or `owner` is gone."""
    inodes = _inodes(path)
    _being_read.update(inodes)
    return weakref.finalize(owner, _being_read.subtract, inodes)


def note_input(path: Path | str) -> None:
    """Declare that a file is about to be read: within `Claims`, it must not be an output of the call.

    Raises:
        OutputError: it is an output.
    """
    call = _call.get()
    if call is not None:
        call.read(Path(path))


class Claims:
    """The inputs and outputs of one call. Each new file is checked against all previous ones, so the order does not matter.

    Within its `with` block, all readers register their files (`note_input`), which are then protected from being overwritten.
    """

    def __init__(self) -> None:
        self.inputs: dict[_Inode, Path] = {}
        self._read: list[Path] = []
        self._files: dict[str, Path] = {}
        self._folders: dict[str, Path] = {}

    def __enter__(self) -> Claims:
        self._token = _call.set(self)
        return self

    def __exit__(self, *_: object) -> None:
        _call.reset(self._token)

    def read(self, path: Path) -> None:
        """Claim an input: a file, or a folder with all its files; a missing one is left for the reader to report."""
        self._read.append(_resolved(path))
        self.inputs |= dict.fromkeys(_inodes(path), path)
        for title, file in self._files.items():
            self._check_input(title, file)
        for title, folder in self._folders.items():
            self._check_no_input_in(title, folder)

    def write(self, title: str, path: Path, *, force: bool = False) -> None:
        """Claim a file to write, for the option `title`.

        Raises:
            OutputError: as for `check_file`, or it is also another output.
        """
        self._check_input(title, path)
        self._check_other(title, path, self._files)
        for folder in self._folders.values():
            self._check_outside(title, path, folder)
        check_file(path, title, force=force)
        self._files[title] = path

    def write_folder(self, title: str, folder: Path, command: str, names: Collection[str] = ()) -> None:
        """Claim a folder for a command to write `names` into, for the option `title`.

        Raises:
            OutputError: as for `check_folder`, or it contains an input or another output.
        """
        self._check_no_input_in(title, folder)
        self._check_other(title, folder, self._folders)
        check_folder(folder, command, names, title)
        self._folders[title] = folder
        for option, path in self._files.items():
            self._check_outside(option, path, folder)

    def _check_input(self, title: str, path: Path) -> None:
        with _in_one_line(f"{title} {path}"):
            found = _status(path)
        if found is not None and _inode(found) in self.inputs:
            read = self.inputs[_inode(found)]
            raise OutputError(f"{title} {path}: is {read}, an input of the same call: must be another file")

    def _check_no_input_in(self, title: str, folder: Path) -> None:
        target = _resolved(folder)
        for path in self._read:
            if path.is_relative_to(target) and path.exists():
                raise OutputError(f"{title} {folder}: holds {path.name}, an input of the same call: must be another folder")

    def _check_other(self, title: str, path: Path, others: dict[str, Path]) -> None:
        for option, other in others.items():
            if option != title and _resolved(other) == _resolved(path) and not _is_special(path):
                raise OutputError(f"{title} {path}: is also {option}: must be another file")

    def _check_outside(self, title: str, path: Path, folder: Path) -> None:
        if _resolved(path).is_relative_to(_resolved(folder)) and not _is_special(path):
            raise OutputError(f"{title} {path}: is in {folder}, which is written too: must be elsewhere")


def _inputs() -> Collection[_Inode]:
    """All files that are currently protected from being overwritten."""
    call = _call.get()
    return {inode for inode, readers in _being_read.items() if readers > 0} | (set() if call is None else call.inputs.keys())


def _inodes(path: Path) -> list[_Inode]:
    """Inodes of a file, or of all files in a folder; without devices and pipes, which may be both input and output."""
    found = _status_or_none(path)
    if found is not None and stat.S_ISDIR(found.st_mode):
        unread = {path / name for name in _NEVER_READ} if any((path / name).is_file() for name in _MOVED_LAST) else set()
        files = {Path(folder) / name for folder, _, names in os.walk(path) for name in names} - unread
        return [_inode(each) for file in files if (each := _status_or_none(file)) and stat.S_ISREG(each.st_mode)]
    return [_inode(found)] if found is not None and stat.S_ISREG(found.st_mode) else []


def _status_or_none(path: Path) -> os.stat_result | None:
    try:
        return os.stat(path)
    except OSError:
        return None

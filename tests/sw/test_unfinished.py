# SPDX-License-Identifier: Apache-2.0
"""Unfinished work stays when its process ends, belongs to one key, and holds nothing that runs."""

from __future__ import annotations

import errno
import fractions
import os
import pickle
from collections import deque
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from evcot.errors import OutputError, RecordingError
from evcot.events import Events
from evcot.unfinished import Unfinished, unfinished
from support.refusals import refused


class Ended(BaseException):
    pass


def left(path: Path, key: str = "key", **state: object) -> None:
    ends(path, lambda work: work.save(state), Ended(), key)


def ends(path: Path, does: Callable[[Unfinished], object], error: BaseException, key: str = "key") -> None:
    """Work that ends with an error."""

    def end(work: Unfinished) -> None:
        does(work)
        raise error

    with pytest.raises(type(error)), unfinished(path, lambda: key) as work:
        end(work)


def found(path: Path, key: str = "key") -> dict[str, object] | None:
    with unfinished(path, lambda: key) as work:
        return work.state


def full_disk(errno_of: int) -> OutputError:
    error = OutputError("x.parquet: cannot be written: No space left on device")
    error.__cause__ = OSError(errno_of, os.strerror(errno_of))
    return error


def test_a_state_comes_back_once_and_for_its_own_work_alone(tmp_path: Path) -> None:
    path = tmp_path / "log"
    left(path, count=7, values=np.arange(3), queue=deque([1]), events=Events.empty())
    state = found(path)
    assert state is not None
    assert state["count"] == 7
    assert np.array_equal(np.asarray(state["values"]), np.arange(3))
    assert found(path) is None, "it was done"
    left(path, count=7)
    assert found(path, "another") is None
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("content", [None, "lock"])
def test_a_folder_of_the_user_is_refused_and_kept(tmp_path: Path, content: str | None) -> None:
    folder = tmp_path / ".log.unfinished"
    folder.mkdir()
    if content:
        (folder / content).write_text("mine")
    with pytest.raises(OutputError, match=r"\.log\.unfinished: exists, and evcot did not make it: must be moved away"):
        found(tmp_path / "log")
    assert [path.read_text() for path in folder.iterdir()] == ([] if content is None else ["mine"])


def test_a_link_in_its_place_is_not_followed(tmp_path: Path) -> None:
    left(tmp_path / "log", count=7)
    (tmp_path / ".log.unfinished").rename(tmp_path / "mine")
    (tmp_path / ".log.unfinished").symlink_to("mine")
    with pytest.raises(OutputError, match="exists, and evcot did not make it"):
        found(tmp_path / "log")
    assert sorted(path.name for path in (tmp_path / "mine").iterdir()) == ["checkpoint", "lock"]


def test_nothing_is_left_of_work_that_fails_or_has_no_checkpoint(tmp_path: Path) -> None:
    def writes(work: Unfinished) -> None:
        (work.folder / "data").write_bytes(b"1")

    for error in (ValueError(), Ended(), full_disk(errno.ENOSPC)):
        ends(tmp_path / "new" / "log", writes, error)
        assert list(tmp_path.iterdir()) == []
    for error in (ValueError(), RecordingError("x.raw: is damaged")):
        ends(tmp_path / "log", lambda work: work.save({"count": 1}), error)
        assert list(tmp_path.iterdir()) == []


_FULL = "x.parquet: cannot be written: No space left on device"


@pytest.mark.parametrize(
    ("error", "says", "do"),
    [
        (full_disk(errno.ENOSPC), _FULL, "free some space"),
        (full_disk(errno.EDQUOT), _FULL, "free some space"),
        (OSError(errno.ENOSPC, "No space left on device", "x.parquet"), _FULL, "free some space"),
        (OutputError("run: holds mine.txt, which evcot did not write"), "run: holds mine.txt, which evcot did not write", ""),
        (OSError(errno.EFBIG, "File too large", "x.owner"), "x.owner: cannot be written: File too large", ""),
        (OSError("0 written"), "a file: cannot be written: 0 written", ""),
        (OSError(), "a file: cannot be written: OSError", ""),
    ],
)
def test_a_file_that_cannot_be_written_leaves_the_checkpoint(error: OSError, says: str, do: str, tmp_path: Path) -> None:
    told = (
        f"{says}; {do or 'remove the cause'} and give the same command again: it goes on from its last checkpoint "
        f"(kept in {tmp_path / '.log.unfinished'})"
    )
    with refused(OutputError, told), unfinished(tmp_path / "log", lambda: "key") as work:
        work.save({"count": 7})
        raise error
    assert found(tmp_path / "log") == {"count": 7}


def test_a_checkpoint_that_cannot_be_written_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(_: int) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    left(tmp_path / "log", count=7)
    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OutputError) as said, unfinished(tmp_path / "log", lambda: "key") as work:
        work.save({"count": 8})
    place = tmp_path / ".log.unfinished"
    assert str(said.value).startswith(f"{place}/checkpoint: cannot be written: No space left on device; free some space")
    assert found(tmp_path / "log") == {"count": 7}


def test_a_damaged_checkpoint_is_not_used_nor_one_of_another_process(tmp_path: Path) -> None:
    left(tmp_path / "log", count=7)
    file = tmp_path / ".log.unfinished" / "checkpoint"
    stored = bytearray(file.read_bytes())
    stored[-2] ^= 1
    file.write_bytes(stored)
    assert found(tmp_path / "log") is None
    taken = pytest.raises(OutputError, match="is being written by another process")
    with unfinished(tmp_path / "log", lambda: "key"), taken, unfinished(tmp_path / "log", lambda: "key"):
        pass


class Runs:
    """What a forged checkpoint could hold."""

    def __init__(self, call: object, *arguments: object) -> None:
        self.made_of = call, arguments

    def __reduce__(self) -> tuple[object, tuple[object, ...]]:
        return self.made_of


@pytest.mark.parametrize(
    "forged",
    [
        Runs(os.mkdir, "made"),
        Runs(getattr, Events, "empty"),
        Runs(getattr, Events.empty(), "__init__"),
        fractions.Fraction(1, 2),
    ],
    ids=["function", "method of a class", "private method", "other class"],
)
def test_a_checkpoint_runs_nothing(forged: object, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    left(tmp_path / "log", forged=forged)
    with pytest.raises(pickle.UnpicklingError, match="must be a"), unfinished(tmp_path / "log", lambda: "key"):
        pass
    assert not Path("made").exists()


def test_a_pipe_has_no_folder_beside_it(tmp_path: Path) -> None:
    with unfinished(Path("/dev/null"), lambda: "key") as work:
        assert isinstance(work, Unfinished)
        assert work.folder.parent != Path("/dev")
        work.save({"count": 1})
    assert not work.folder.exists()

# SPDX-License-Identifier: Apache-2.0
"""A message about a file has the system's reason, and names the file that the system refused."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest

from evcot.errors import reason_of
from evcot.outputs import folder_written_aside, written_aside

_FULL = os.strerror(errno.ENOSPC)


@pytest.mark.parametrize(
    ("error", "reason"),
    [
        (OSError(errno.ENOSPC, _FULL), _FULL),
        (OSError(errno.ENOSPC, _FULL, "log.npz"), _FULL),
        (OSError(errno.ENOSPC, _FULL, b"log.npz"), _FULL),
        (OSError(errno.ENOSPC, _FULL, ".log.npz.0123abcd.partial"), _FULL),
        (OSError(errno.ENOSPC, _FULL, "./log.npz"), _FULL),
        (OSError(errno.ENOSPC, _FULL, os.path.abspath("log.npz")), _FULL),
        (OSError(errno.ENOENT, "No such file or directory", "main.js"), "main.js: No such file or directory"),
        (OSError(errno.ENOENT, "No such file", ".run.0123abcd.partial/a.html"), "run/a.html: No such file"),
        (OSError(errno.ENOENT, "No such file", 7), "No such file"),
        (OSError("1 requested\nand 0 written"), "1 requested and 0 written"),
        (TimeoutError(), "TimeoutError"),
        (OSError(), "OSError"),
    ],
)
def test_reason_is_never_empty_and_names_another_file(error: OSError, reason: str) -> None:
    assert reason_of(error, Path("log.npz")) == reason


def test_option_before_the_file_changes_nothing() -> None:
    assert reason_of(OSError(errno.ENOSPC, _FULL, "log.npz"), "-o log.npz") == _FULL


@pytest.mark.parametrize("writes", [written_aside, lambda path: folder_written_aside(path, "cosim")])
def test_output_is_not_blamed_for_a_file_that_was_read(writes: object, tmp_path: Path) -> None:
    assert callable(writes)
    absent = tmp_path / "absent.css"
    with (
        pytest.raises(OSError, match=rf"^{tmp_path}/out: cannot be written: {absent}: No such file or directory$"),
        writes(tmp_path / "out"),
    ):
        absent.read_text()
    assert list(tmp_path.iterdir()) == []


def test_error_without_a_text_has_a_reason(tmp_path: Path) -> None:
    with pytest.raises(OSError, match=r"out: cannot be written: OSError$"), written_aside(tmp_path / "out"):
        raise OSError

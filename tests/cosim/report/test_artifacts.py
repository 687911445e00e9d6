# SPDX-License-Identifier: Apache-2.0
"""A run's folder is written completely or not at all; its contents are tested through the command line (test_cli.py)."""

from __future__ import annotations

from pathlib import Path

import pytest

from evcot.errors import OutputError
from evcot.outputs import RUN_FILE, folder_written_aside


def test_a_folder_appears_whole_or_not_at_all(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    with folder_written_aside(folder, "cosim") as aside:
        (aside / RUN_FILE).touch()
        (aside / "a").write_text("old")
        assert not folder.exists()
    with pytest.raises(ZeroDivisionError), folder_written_aside(folder, "cosim") as aside:
        (aside / "a").write_text(str(1 // 0))
    assert [path.name for path in tmp_path.iterdir()] == ["run"]
    assert (folder / "a").read_text() == "old"
    with folder_written_aside(folder, "cosim") as aside:
        (aside / RUN_FILE).touch()
        (aside / "b").write_text("new")
    assert sorted(path.name for path in folder.iterdir()) == ["b", RUN_FILE]
    with pytest.raises(OutputError, match="cannot be written"), folder_written_aside(folder / "b" / "c", "cosim"):
        pass

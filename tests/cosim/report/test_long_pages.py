# SPDX-License-Identifier: Apache-2.0
"""The folder of a run, and the pages of a long one."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from evcot.errors import OutputError
from evcot.outputs import RUN_FILE, folder_written_aside

# Two pages, and the names of the functions of this process that Numba compiled for them.
_PAGES = """
import sys
from pathlib import Path
import numpy as np
from numba.core import event
from evcot.events import Events
from evcot.tracks.log import TRACK
from evcot_cosim.report import part_pages

class Compiled(event.Listener):
    def on_start(self, event): pass
    def on_end(self, event):  # of a compilation that was refused, too
        if event.data["dispatcher"].signatures: print(event.data["dispatcher"].py_func.__name__)
event.register("numba:compile", Compiled())

part_pages.PART_EVENTS = 100
count = 150
columns = (np.zeros(count, kind) for kind in (np.uint16, np.uint16, np.uint8))
blocks = iter([Events(np.arange(count, dtype=np.int64), *columns)])
recording = part_pages.LongRecording("made", (64, 64), blocks, count, 0, count - 1)
log = part_pages.LongLog("cot_array", iter([(np.empty(0, TRACK), np.full(count, -1, np.int16))]))
part_pages.write_parts(recording, {"hardware": log}, Path(sys.argv[1]), {})
"""


def test_kernels_of_the_pages_are_compiled_by_another_process(tmp_path: Path) -> None:
    kernels = tmp_path / "kernels"
    kernels.mkdir()
    done = subprocess.run(
        [sys.executable, "-c", _PAGES, str(tmp_path)], env=os.environ | {"NUMBA_CACHE_DIR": str(kernels)},
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert sorted(path.name for path in tmp_path.glob("part-*.html")) == ["part-00000.html", "part-00001.html"]
    assert done.stdout.split() == []
    assert list(kernels.rglob("*.nbc")) != []


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

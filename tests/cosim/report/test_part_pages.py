# SPDX-License-Identifier: Apache-2.0
"""Pages of the parts of a long recording: their memory does not grow, and compiling takes none of it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

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

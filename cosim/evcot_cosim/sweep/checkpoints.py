# SPDX-License-Identifier: Apache-2.0
"""The results of one run of a sweep, block by block. A long run makes checkpoints, from which it continues after a kill."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evcot.errors import OutputError
from evcot.events import Events
from evcot.tracks.column import PackedColumn
from evcot.tracks.log import TRACK, Kind, TrackLog
from evcot.tracks.tally import Tally
from evcot.unfinished import CHECKPOINT_EVENTS, Unfinished, folder_of, unfinished

from ..rtl.build import cache_dir

__all__ = ["CheckpointedLog"]


class CheckpointedLog:
    """Records and counts of owners, as a context: it holds the folder of the checkpoints, in the cache of this machine.

    There are none where the cache cannot be written, and while another process is at the same run.

    Args:
        key: of the run; with a checkpoint of the same key it continues.
        whole: keep events and owners, too, and make no checkpoints.

    Attributes:
        engine: what the engine was at the last checkpoint; None at the beginning.
        spent: `wall_s` and `cpu_s` that earlier processes took up to the last checkpoint; empty without.
        events: blocks, with `whole`.
    """

    def __init__(self, key: str, whole: bool) -> None:
        self.engine: Any = None
        self.spent: dict[str, float] = {}
        self.events: list[Events] = []
        self._owners: list[NDArray[np.int16]] = []
        self._records: list[NDArray[np.void]] = []  # since the last checkpoint
        self._stored: PackedColumn | None = None  # those before
        self._tally = Tally()
        self._at = 0  # events, at the last checkpoint
        self._key, self._whole = key, whole
        self._work: Unfinished | None = None
        self._held = ExitStack()
        self._began = time.perf_counter(), time.process_time()

    def __enter__(self) -> CheckpointedLog:
        path = cache_dir() / "sweep" / self._key
        if not self._whole and folder_of(path).exists():
            self._open()
        state = None if self._work is None else self._work.state
        if state is not None:
            self.engine, self.spent, self._tally = state["engine"], state["spent"], state["tally"]
            self._at = self._tally.events
            self._stored = self._column(state["records"])
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._held.__exit__(kind, error, trace)

    def rest(self, blocks: Iterator[Events]) -> Iterator[Events]:
        """The blocks after the last checkpoint. The key of a run holds the contents of its recording: they are the same."""
        before = self._at
        for block in blocks:
            if before > 0:
                before -= len(block)
            else:
                yield block

    def add(self, records: NDArray[np.void], owner: NDArray[np.int16], block: Events) -> None:
        """What became of a block."""
        if len(records):
            self._records.append(records)
        self._tally.add(records, owner)
        if self._whole:
            self._owners.append(owner)
            self.events.append(block)

    def keep(self, engine: Callable[[], Any]) -> None:
        """Make a checkpoint where one is due.

        Args:
            engine: gives what the engine is after the last block.
        """
        if self._whole or self._tally.events - self._at < CHECKPOINT_EVENTS:
            return
        self._at = self._tally.events
        if self._work is None:
            self._open()
        if self._work is None:
            return
        self._stored = self._stored or self._column(0)
        for records in self._records:
            self._stored.append(records)
        self._records = []
        self._stored.flush()
        wall_s, cpu_s = time.perf_counter() - self._began[0], time.process_time() - self._began[1]
        spent = {"wall_s": self.spent.get("wall_s", 0.0) + wall_s, "cpu_s": self.spent.get("cpu_s", 0.0) + cpu_s}
        self._work.save({"engine": engine(), "spent": spent, "tally": self._tally, "records": len(self._stored)})

    def log(self, engine: str, last: NDArray[np.void]) -> TrackLog:
        """The whole log, with the last records, when all events are done; its owners are empty unless they were kept."""
        self._tally.add(last, np.empty(0, np.int16))
        stored = [] if self._stored is None else [self._stored[:]]
        records = np.concatenate([np.empty(0, TRACK), *stored, *self._records, last])
        return TrackLog(engine, records, np.concatenate([np.empty(0, np.int16), *self._owners]))

    def counts(self) -> dict[str, int]:
        """Figures of a row: of events, and of the records of the whole log."""
        tally, kinds = self._tally, self._tally.kinds
        return {
            "events": tally.events, "owned": tally.owned, "passed": tally.passed, "filtered": tally.filtered,
            "records": sum(kinds.values()), "tracks": kinds[Kind.BORN], "merged": kinds[Kind.MERGED], "lost": kinds[Kind.LOST],
        }  # fmt: skip

    def _open(self) -> None:
        try:
            self._work = self._held.enter_context(unfinished(cache_dir() / "sweep" / self._key, lambda: self._key))
        except OutputError:
            self._work = None

    def _column(self, length: int) -> PackedColumn:
        assert self._work is not None
        column = PackedColumn(self._work.folder / "records", TRACK, length)
        self._work.held.callback(column.close)
        return column

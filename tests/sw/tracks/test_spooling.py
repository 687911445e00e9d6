# SPDX-License-Identifier: Apache-2.0
"""A recording of any length is tracked in bounded memory, and goes on where its process was killed, bit for bit."""

from __future__ import annotations

import os
import tracemalloc
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from evcot.errors import ConfigError, OutputError, RecordingError, TrackLogError
from evcot.events import Events, Recording
from evcot.filters.config import FilterConfig
from evcot.scenes.registry import simulate_scene
from evcot.trackers.engines import ENGINES
from evcot.trackers.settings import engine_settings
from evcot.tracks.column import PackedColumn
from evcot.tracks.log import Kind, TrackLog
from evcot.tracks.record import TRACK
from evcot.tracks.spooling import Tracked, track_into
from evcot.tracks.tally import Tally
from evcot.tracks.tracking import Tracker, signed_log_of
from evcot.unfinished import Unfinished, unfinished
from support.full_disk import full_disk

BLOCK = 1_501
FILTERS = {"bare": FilterConfig(), "filtered": FilterConfig(refractory_us=500, activity_us=5_000)}


@pytest.fixture(scope="module")
def recording() -> Recording:
    return simulate_scene("discs", 5, {"duration_us": 150_000}).recording


def blocks(events: Events, size: int = BLOCK) -> Iterator[Events]:
    return (events[begin : begin + size] for begin in range(0, len(events), size))


def started(engine: str, recording: Recording, filters: FilterConfig) -> Tracker:
    sensor = recording.width, recording.height
    return ENGINES[engine].start(engine_settings(engine, sensor, None, None)[0], filters, sensor)


def same(done: Tracked, wanted: TrackLog) -> bool:
    log = done.log
    assert log is not None
    arrays = np.array_equal(log.records[0:], wanted.records) and np.array_equal(log.owner[0:], wanted.owner)
    return arrays and (log.engine, log.recording) == (wanted.engine, wanted.recording)


class Killed(BaseException):
    """The process ends here."""


@pytest.mark.parametrize("filters", FILTERS.values(), ids=FILTERS)
@pytest.mark.parametrize("engine", ENGINES)
def test_a_killed_run_of_every_engine_is_continued_bit_for_bit(
    engine: str, filters: FilterConfig, recording: Recording, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if engine == "cot" and filters.enabled:
        with pytest.raises(ConfigError, match="a single `cot` has no filters in front"):
            started(engine, recording, filters)
        return
    events = recording.events
    assert len(events) > 8 * BLOCK
    whole = signed_log_of(engine, started(engine, recording, filters), blocks(events))
    save = Unfinished.save
    saves = []

    def save_and_end(work: Unfinished, state: dict[str, object]) -> None:
        save(work, state)
        saves.append(state)
        if len(saves) == 2:
            with (work.folder / "log.owner").open("ab") as file:
                file.write(b"written after the checkpoint")
            raise Killed

    monkeypatch.setattr(Unfinished, "save", save_and_end)

    def begin() -> Tracker:
        return started(engine, recording, filters)

    end_in(tmp_path / "log", lambda work: track_into(work, engine, begin, blocks(events), 2 * BLOCK))
    resumed: list[int] = []
    with unfinished(tmp_path / "log", lambda: "key") as work:
        again = blocks(events, 1_703)
        done = track_into(work, engine, lambda: pytest.fail("begins again"), again, 2 * BLOCK, resumed.append)
        assert resumed == [4 * BLOCK]
        assert same(done, whole)
        assert done.tally.events == len(events)
    assert list(tmp_path.iterdir()) == []


def end_in(path: Path, work: Callable[[Unfinished], object]) -> None:
    """Do work that is killed."""
    with pytest.raises(Killed), unfinished(path, lambda: "key") as found:
        work(found)


def test_other_events_before_the_checkpoint_are_refused(recording: Recording, tmp_path: Path) -> None:
    events = recording.events

    def begin() -> Tracker:
        return started("rct", recording, FilterConfig())

    for shift, rule in ((1, "must be as before"), (0, "events fewer")):
        end_in(tmp_path / "log", lambda work: track_into(work, "rct", begin, _ending(events, 3 * BLOCK), BLOCK))
        other = Events(events.t_us + shift, events.x, events.y, events.p)[: len(events) if shift else BLOCK]
        with pytest.raises(RecordingError, match=rule), unfinished(tmp_path / "log", lambda: "key") as work:
            track_into(work, "rct", begin, blocks(other), BLOCK)
        assert list(tmp_path.iterdir()) == []


def _ending(events: Events, after: int) -> Iterator[Events]:
    yield from blocks(events[:after])
    raise Killed


def test_the_tally_counts_what_the_whole_log_has(recording: Recording) -> None:
    log = signed_log_of("rct", started("rct", recording, FilterConfig(polarity="on")), blocks(recording.events))
    tally = Tally()
    for begin in range(0, len(log.records), 37):
        tally.add(log.records[begin : begin + 37], log.owner[:0])
    tally.add(log.records[:0], log.owner)
    assert tally.kinds == {kind: len(log.of_kind(kind)) for kind in Kind}
    assert (tally.events, tally.owned) == (len(log.owner), int((log.owner >= 0).sum()))
    assert (tally.passed, tally.filtered) == (int((log.owner == -1).sum()), int((log.owner == -2).sum()))
    lengths = [np.ptp(log.records["t_us"][log.records["track_id"] == track]) for track in np.unique(log.records["track_id"])]
    assert tally.longest_us == max(lengths)


def test_memory_does_not_grow_with_the_recording(recording: Recording, tmp_path: Path) -> None:
    span_us = recording.duration_us + 1_000

    def peak(times: int) -> int:
        def repeated() -> Iterator[Events]:
            for i in range(times):
                for block in blocks(recording.events):
                    yield Events(block.t_us + i * span_us, block.x, block.y, block.p)

        with unfinished(tmp_path / "log", lambda: "key") as work:
            tracemalloc.start()
            done = track_into(work, "rct", lambda: started("rct", recording, FilterConfig()), repeated(), 10 * BLOCK)
            found = tracemalloc.get_traced_memory()[1]
            tracemalloc.stop()
        assert done.log is not None
        assert done.tally.events == times * len(recording.events)
        return found

    peak(1)
    short, long = peak(2), peak(12)
    assert long < 1.1 * short + 100_000  # the owners of the ten times more events alone are more than that
    assert 10 * 2 * len(recording.events) > 0.1 * short + 100_000


OWNER = np.dtype(np.int16)
N = 2_000_000


def owners(n: int = N) -> np.ndarray:
    return np.random.default_rng(3).integers(-2, 8, n).astype(OWNER)


def filled(path: Path, values: np.ndarray, step: int = 77_777) -> PackedColumn:
    column = PackedColumn(path, values.dtype)
    for begin in range(0, len(values), step):
        column.append(values[begin : begin + step])
    return column


def test_every_part_is_what_was_appended(tmp_path: Path) -> None:
    values = owners()
    with closing(filled(tmp_path / "o", values)) as column:
        assert len(column) == N
        for begin, end in ((0, 0), (0, 1), (0, N), (524_287, 524_289), (700_000, 1_900_000), (N - 1, N), (N, N + 5)):
            assert np.array_equal(column[begin:end], values[begin:end])
        column.append(values[:3])
        assert np.array_equal(column[N - 1 :], [values[-1], *values[:3]])
    assert (tmp_path / "o").stat().st_size < values.nbytes / 2


def test_records_keep_every_bit(tmp_path: Path) -> None:
    values = np.frombuffer(np.random.default_rng(4).bytes(TRACK.itemsize * 30_000), TRACK)
    with closing(filled(tmp_path / "r", values, 1_000)) as column:
        assert column[0:].tobytes() == values.tobytes()


def test_it_is_cut_back_to_what_it_had_when_it_was_flushed(tmp_path: Path) -> None:
    values = owners()
    column = filled(tmp_path / "o", values[:900_000])
    column.flush()
    column.append(values[:800_000])
    column.close()
    with closing(PackedColumn(tmp_path / "o", OWNER, 900_000)) as again:
        again.append(values[900_000:])
        assert np.array_equal(again[0:], values)


@pytest.mark.parametrize("left", [0, 7, -1])
def test_a_file_that_is_shorter_than_its_checkpoint_is_refused(left: int, tmp_path: Path) -> None:
    column = filled(tmp_path / "o", owners())
    column.flush()
    column.close()
    os.truncate(tmp_path / "o", left if left >= 0 else (tmp_path / "o").stat().st_size - 1)
    with pytest.raises(TrackLogError, match=rf"o: holds \d+ values: must hold {N}, as at its checkpoint"):
        PackedColumn(tmp_path / "o", OWNER, N)


def test_file_too_large_is_said_again_at_the_end(tmp_path: Path) -> None:
    """The system refuses what is buffered a second time when the file is closed, and then does not name the file."""
    column = PackedColumn(tmp_path / "o", OWNER)
    column.append(owners(1_000))
    with full_disk(100):
        for ends in (column.flush, column.close):
            with pytest.raises(OutputError, match=r"/o: cannot be written: File too large$"):
                ends()


def test_several_threads_read(tmp_path: Path) -> None:
    values = owners()
    with closing(filled(tmp_path / "o", values)) as column, ThreadPoolExecutor(4) as pool:
        parts = pool.map(lambda begin: column[begin : begin + 999], range(0, N, 999))
        assert np.array_equal(np.concatenate(list(parts)), values)

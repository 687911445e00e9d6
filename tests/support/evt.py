# SPDX-License-Identifier: Apache-2.0
"""Support for tests of the EVT decoders: words as AXI4-Stream beats, the software decoder's result, and an exact comparison."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from evcot.events import Events
from evcot.recordings.formats.prophesee_header import HEADER_BYTES, parse_header
from evcot.recordings.formats.words import Layout, WordArray

from .stream_device import Bundle, StreamDevice

__all__ = [
    "COUNTERS",
    "STREAMS",
    "Decoded",
    "axis_beats",
    "compare_with_software",
    "corrupted",
    "decode",
    "decode_in_hardware",
    "event_rows",
    "evt2_words",
    "evt_device",
    "payload",
    "random_events",
]

COUNTERS = ("n_events", "n_untimed", "n_outside", "n_reserved", "n_cut")

_INPUT = Bundle("s_axis_t", ("data", "keep", "last"))
_OUTPUT = Bundle("m_", ("t", "x", "y", "p"))
STREAMS = (_INPUT.prefix, _OUTPUT.prefix)


class Decoded(NamedTuple):
    """The events on the sensor as rows (t, x, y, p), (n, 4) uint64, and the counters of `COUNTERS`."""

    events: NDArray[np.uint64]
    counters: Mapping[str, int]


def payload(path: Path, dtype: type[np.unsignedinteger[Any]]) -> WordArray:
    """The words of a Prophesee RAW file, without its header."""
    content = path.read_bytes()
    return np.frombuffer(content[parse_header(content[:HEADER_BYTES]).length :], np.dtype(dtype).newbyteorder("<")).astype(
        dtype
    )


def decode(layout: Layout, words: WordArray, width: int, height: int, time_w: int = 48) -> Decoded:
    """Decode the words in software, for a sensor of this size and times of `time_w` bits."""
    state, parts = layout.start, [Events.empty()]
    while len(words):
        room = Events.allocated(len(words) + layout.most_events)
        used, count, state = layout.fill(words, state, room.t_us, room.x, room.y, room.p)
        parts.append(room[:count])
        words = words[used:]
    events = Events.joined(parts)
    inside = (events.x < width) & (events.y < height)
    kept = events.where(inside)
    counters = (len(kept), state.untimed, len(events) - len(kept), state.strange, 0)
    return Decoded(event_rows(kept, time_w), dict(zip(COUNTERS, counters, strict=True)))


def event_rows(events: Events, time_w: int = 48) -> NDArray[np.uint64]:
    """Events as rows (t, x, y, p), (n, 4), with times truncated to `time_w` bits."""
    columns = (column.astype(np.uint64) for column in (events.t_us, events.x, events.y, events.p))
    return np.stack(list(columns), axis=1) & np.array([(1 << time_w) - 1, *[(1 << 64) - 1] * 3], np.uint64)


def axis_beats(words: WordArray, data_w: int, rng: np.random.Generator | None = None) -> NDArray[np.uint64]:
    """Words as beats (data, keep, last), (n, 3), lowest lane first; keep is 0 for lanes of the last beat without a word.

    Args:
        rng: also leaves other lanes empty, a whole word at a time, and ends packets at random beats. None: all beats are full.
    """
    word_bytes, beat_bytes = words.dtype.itemsize, data_w // 8
    lanes, beats_per_word = max(1, beat_bytes // word_bytes), max(1, word_bytes // beat_bytes)
    place = np.arange(len(words))
    if rng is not None:
        place += np.cumsum(rng.geometric(0.75, len(words)) - 1)
    n_lanes = -(-(int(place[-1]) + 1) // lanes) * lanes if len(words) else 0
    given = np.zeros(n_lanes, np.bool_)
    given[place] = True
    lane_words = (np.zeros(n_lanes) if rng is None else rng.integers(0, 1 << 16, n_lanes)).astype(words.dtype.newbyteorder("<"))
    lane_words[place] = words
    data = lane_words.view(f"<u{beat_bytes}").astype(np.uint64)
    keep = np.packbits(np.repeat(given, word_bytes).reshape(-1, beat_bytes), axis=1, bitorder="little")[:, 0]
    last = np.arange(1, len(data) + 1) % beats_per_word == 0
    last[:-1] &= False if rng is None else rng.random(len(data) - 1) < 0.1
    return np.stack([data, keep, last], axis=1).astype(np.uint64)


def corrupted(words: WordArray, rng: np.random.Generator, chance: float) -> WordArray:
    """A copy of the words: a fraction `chance` has one bit flipped, and as many each are noise, missing or repeated."""
    bits = 8 * words.dtype.itemsize
    damaged = words.copy()
    flipped = np.flatnonzero(rng.random(len(words)) < chance)
    damaged[flipped] ^= np.left_shift(words.dtype.type(1), rng.integers(0, bits, len(flipped)).astype(words.dtype))
    noisy = np.flatnonzero(rng.random(len(words)) < chance)
    damaged[noisy] = rng.integers(0, np.iinfo(words.dtype).max, len(noisy), words.dtype, endpoint=True)
    return np.repeat(damaged, rng.choice(3, len(words), p=[chance, 1 - 2 * chance, chance]))


def random_events(rng: np.random.Generator, n: int, width: int, height: int, longest_gap_us: int) -> Events:
    """About n events that exercise vectors: runs to the right in one row at one time, single events, gaps of any length."""
    begins = rng.random(n) < 0.2
    begins[:1] = True
    run = np.cumsum(begins) - 1
    count = int(run[-1]) + 1
    step = np.where(begins, 0, rng.choice([1, 1, 1, 2, 5, 31], n))
    walked = np.cumsum(step)
    x = rng.integers(0, width, count)[run] + walked - walked[np.flatnonzero(begins)][run]
    gap_us = rng.choice([0, 1, 3, 100], count)
    long = rng.random(count) < 0.01
    gap_us[long] = 2 ** rng.uniform(0, np.log2(longest_gap_us), int(long.sum()))
    t_us = np.cumsum(gap_us)[run]
    y, p = rng.integers(0, height, count)[run], rng.integers(0, 2, count)[run]
    return Events(t_us, x.astype(np.uint16), y.astype(np.uint16), p.astype(np.uint8)).where(x < width)


def evt2_words(events: Events, vectors: bool) -> WordArray:
    """Events as words of EVT 2.0, or 2.1 with adjacent events in one vector; a time word precedes each new high part."""
    t_us, x, y, p = (column.astype(np.int64) for column in (events.t_us, events.x, events.y, events.p))
    begins = np.ones(len(x), np.bool_)
    begins[1:] = (np.diff(np.stack([t_us, x >> 5, y, p])) != 0).any(axis=0) | (np.diff(x) <= 0) | (not vectors)
    first = np.flatnonzero(begins)
    left = x[first] & ~31 if vectors else x[first]
    heads = p[first] << 28 | (t_us[first] & 63) << 22 | left << 11 | y[first]
    mark = t_us[first] >> 6
    marked = np.flatnonzero(np.diff(mark, prepend=-1))
    heads = np.insert(heads, marked, 8 << 28 | mark[marked] & ((1 << 28) - 1))
    if not vectors:
        return heads.astype(np.uint32)
    masks = np.insert(np.bitwise_or.reduceat(1 << (x & 31), first), marked, 0)
    return heads.astype(np.uint64) << np.uint64(32) | masks.astype(np.uint64)


def evt_device(top: str, width: int, height: int, **parameters: int) -> StreamDevice:
    """The decoder `top` for a sensor of this size."""
    return StreamDevice(
        top, {"WIDTH": width, "HEIGHT": height, **parameters}, inputs=[_INPUT], outputs=[_OUTPUT], has_idle=True
    )  # fmt: skip


def compare_with_software(
    device: StreamDevice, layout: Layout, words: WordArray, beats: NDArray[np.uint64] | None = None
) -> tuple[Decoded, int]:
    """Reset the hardware, stream the words through it and decode them in software, and compare the results.

    Args:
        beats: the hardware's input beats for the same words (default: `axis_beats` of them).

    Returns:
        what both decoded, and the number of clocks the hardware took.

    Raises:
        AssertionError: they differ; the message names the first differing event, or the counters.
    """
    parameters = device.model.parameters
    data_w = int(device.sim.io.s_axis_tdata.signal.width)
    expected = decode(layout, words, parameters["WIDTH"], parameters["HEIGHT"], int(device.sim.io.m_t.signal.width))
    device.reset()
    run = device.run({_INPUT.prefix: axis_beats(words, data_w) if beats is None else beats})
    events = run.words[_OUTPUT.prefix]
    common = min(len(events), len(expected.events))
    differs = (events[:common] != expected.events[:common]).any(axis=1)
    if differs.any() or len(events) != len(expected.events):
        i = int(differs.argmax()) if differs.any() else common
        raise AssertionError(
            f"{device.top}: event {i} of {len(expected.events)}: hardware gives "
            f"{events[i : i + 1].tolist()} of {len(events)}, software {expected.events[i : i + 1].tolist()}"
        )
    counters = {name: int(device.sim.io[name]) for name in COUNTERS}
    assert counters == expected.counters, f"{device.top}: hardware counts {counters}, software {expected.counters}"
    return expected, run.clocks


def decode_in_hardware(device: StreamDevice, words: WordArray) -> tuple[list[list[int]], dict[str, int]]:
    """Decode words in hardware, from reset: the decoded events [t, x, y, p], and the counters that are not 0."""
    device.reset()
    run = device.run({_INPUT.prefix: axis_beats(words, int(device.sim.io.s_axis_tdata.signal.width))})
    counters = {name: int(device.sim.io[name]) for name in COUNTERS}
    return run.words[_OUTPUT.prefix].tolist(), {name: count for name, count in counters.items() if count}

# SPDX-License-Identifier: Apache-2.0
"""What tests of the EVT decoders share: words as AXI4-Stream beats, the software decoder's answer, and an exact comparison."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from evcot.events import Events
from evcot.formats.prophesee_header import HEADER_BYTES, parse_header
from evcot.formats.words import Layout, WordArray

from .stream_device import Bundle, StreamDevice

__all__ = ["COUNTERS", "Decoded", "axis_beats", "corrupted", "decode", "evt_device", "exact", "payload"]

COUNTERS = ("n_events", "n_untimed", "n_outside", "n_reserved", "n_cut")

_INPUT = Bundle("s_axis_t", ("data", "keep", "last"))
_OUTPUT = Bundle("m_", ("t", "x", "y", "p"))


class Decoded(NamedTuple):
    """The events on the sensor as rows (t, x, y, p), (n, 4) uint64, and the counters of `COUNTERS`."""

    events: NDArray[np.uint64]
    counters: Mapping[str, int]


def payload(path: Path, dtype: type[np.unsignedinteger[Any]]) -> WordArray:
    """The words of a Prophesee RAW file, without its header."""
    content = path.read_bytes()
    return np.frombuffer(content[parse_header(content[:HEADER_BYTES]).length :], np.dtype(dtype).newbyteorder("<")).astype(dtype)


def decode(layout: Layout, words: WordArray, width: int, height: int, time_w: int = 48) -> Decoded:
    """What the software decoder makes of the words, on a sensor of this size and with times of so many bits."""
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
    rows = np.stack([kept.t_us & ((1 << time_w) - 1), kept.x, kept.y, kept.p], axis=1).astype(np.uint64)
    return Decoded(rows, dict(zip(COUNTERS, counters, strict=True)))


def axis_beats(words: WordArray, data_w: int, rng: np.random.Generator | None = None) -> NDArray[np.uint64]:
    """Words as beats (data, keep, last), (n, 3): the lowest lane first, the last beat filled up with lanes that keep leaves out.

    Args:
        rng: leaves out lanes at random, whole words at a time, that hold noise instead. None: all beats are full.
    """
    word_bytes, beat_bytes = words.dtype.itemsize, data_w // 8
    lanes = max(1, beat_bytes // word_bytes)
    given = np.ones(len(words), np.bool_)
    if rng is not None and lanes > 1:
        given = rng.random(len(words) + len(words) // 3) < 0.75
        given[np.flatnonzero(given)[len(words) :]] = False
        words = np.concatenate([words, words[:0]])[: int(given.sum())]
    given = np.concatenate([given, np.zeros(-len(given) % lanes, np.bool_)])
    placed = np.zeros(len(given), words.dtype) if rng is None else rng.integers(0, 1 << 16, len(given)).astype(words.dtype)
    placed[given] = words
    data = placed.astype(words.dtype.newbyteorder("<")).view(f"<u{beat_bytes}").astype(np.uint64)
    keep = np.packbits(np.repeat(given, word_bytes).reshape(-1, beat_bytes), axis=1, bitorder="little")[:, 0]
    last = np.zeros(len(data), np.uint64)
    last[-1:] = 1
    return np.stack([data, keep.astype(np.uint64), last], axis=1)


def corrupted(words: WordArray, rng: np.random.Generator, chance: float) -> WordArray:
    """A copy with a random bit turned in this part of the words, and as many words replaced by noise, left out or doubled."""
    bits = 8 * words.dtype.itemsize
    damaged = words.copy()
    turned = np.flatnonzero(rng.random(len(words)) < chance)
    damaged[turned] ^= np.left_shift(np.ones(1, words.dtype), rng.integers(0, bits, len(turned)).astype(words.dtype))
    noisy = np.flatnonzero(rng.random(len(words)) < chance)
    damaged[noisy] = rng.integers(0, 1 << bits, len(noisy), words.dtype) if bits < 64 else rng.integers(0, 1 << 63, len(noisy)) * 2
    times = rng.choice([0, 1, 2], len(words), p=[chance / 2, 1 - chance, chance / 2])
    return np.repeat(damaged, times)


def evt_device(top: str, width: int, height: int, **parameters: int) -> StreamDevice:
    """The decoder `top` for a sensor of this size."""
    return StreamDevice(
        top, {"WIDTH": width, "HEIGHT": height, **parameters}, inputs=[_INPUT], outputs=[_OUTPUT], has_idle=True
    )  # fmt: skip


def exact(device: StreamDevice, layout: Layout, words: WordArray, beats: NDArray[np.uint64] | None = None) -> tuple[Decoded, int]:
    """Resets the hardware, streams the words through it and through the software decoder alike.

    Args:
        beats: the same words as the hardware gets them, where that is not `axis_beats`.

    Returns:
        what both decoded, and how many clocks the hardware took.

    Raises:
        AssertionError: they differ; the message names the first event, or the counter.
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

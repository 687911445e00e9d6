# SPDX-License-Identifier: Apache-2.0
"""Words of the streams: packed as documented, and event numbers unwrapped."""

from __future__ import annotations

import numpy as np
import pytest

from evcot.errors import RecordingError
from evcot.hardware.streams import pack_events, unpack, whole_numbers


def test_an_event_stands_in_its_word_as_documented() -> None:
    words = pack_events(np.array([5]), np.array([3]), np.array([2]), np.array([1]))
    assert words.tolist() == [1 << 62 | 2 << 47 | 3 << 32 | 5]
    assert unpack("event", words).tolist() == [(5, 3, 2, 1)]


def test_of_a_time_the_low_bits_go_in() -> None:
    words = pack_events(np.array([(1 << 32) + 7, -1]), *np.zeros((3, 2), np.int64))
    assert unpack("event", words)["t"].tolist() == [7, (1 << 32) - 1]


def test_events_survive_packing() -> None:
    rng = np.random.default_rng(1)
    columns = [rng.integers(0, 1 << bits, 1_000) for bits in (32, 15, 15, 1)]
    found = unpack("event", pack_events(*columns))
    for name, column in zip("txyp", columns, strict=True):
        assert np.array_equal(found[name], column)


@pytest.mark.parametrize(("field", "value", "top"), [("x", 1 << 15, 32767), ("y", -1, 32767), ("p", 2, 1)])
def test_refuses_what_a_field_cannot_hold(field: str, value: int, top: int) -> None:
    columns = {name: np.zeros(3, np.int64) for name in "txyp"}
    columns[field][2] = value
    with pytest.raises(RecordingError, match=f"event 2: {field} = {value}: must be from 0 to {top}"):
        pack_events(*columns.values())


def test_numbers_become_whole_even_when_slightly_out_of_order() -> None:
    whole = np.array([14, 13, 15, 16, 18, 17, 24, 31, 32, 39])
    assert whole_numbers(whole % 16, 4, 14).tolist() == whole.tolist()
    assert whole_numbers(np.array([3, 5]), 4).tolist() == [3, 5]
    assert whole_numbers(np.empty(0, np.int64), 4).tolist() == []

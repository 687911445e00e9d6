# SPDX-License-Identifier: Apache-2.0
"""The contract's numbers, and the layouts of streams."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
import pytest

from evcot.errors import ConfigError, RecordingError
from evcot.hardware.config import SlotConfig
from evcot.hardware.contract import RECORD, REGISTERS, SHAPE_RANGES, Shape
from evcot.hardware.streams import pack_events, unpack, whole_numbers
from evcot.tracks.log import Kind

# The rest of a shape whose one field is at its lowest or highest.
ROOMY = {"tc_w": 1, "nev_w": 1, "tick_w": 1}


def test_every_field_of_a_shape_has_a_range() -> None:
    assert [field.name for field in fields(Shape)] == list(SHAPE_RANGES)


@pytest.mark.parametrize("name", SHAPE_RANGES)
def test_a_shape_takes_the_limits_and_nothing_beyond(name: str) -> None:
    low, high, meaning = SHAPE_RANGES[name]
    rest = {key: value for key, value in ROOMY.items() if key != name}
    for value in (low, high):
        assert getattr(Shape(**rest | {name: value}), name) == value
    for value in (low - 1, high + 1):
        with pytest.raises(ConfigError) as caught:
            Shape(**rest | {name: value})
        assert str(caught.value) == f"shape.{name} = {value}: must be an integer from {low} to {high} ({meaning})"


def test_a_shape_takes_integers_only() -> None:
    with pytest.raises(ConfigError, match=r"shape\.frac = 4\.0: must be an integer"):
        Shape(frac=4.0)  # type: ignore[arg-type]


def test_time_must_outlast_a_window_and_a_tick() -> None:
    assert Shape(time_w=34).time_w == 34
    with pytest.raises(ConfigError, match=r"shape\.time_w = 33: must be at least tc_w \+ nev_w = 34"):
        Shape(time_w=33)
    with pytest.raises(ConfigError, match=r"shape\.time_w = 8: must be at least tick_w = 9"):
        Shape(time_w=8, tc_w=4, nev_w=4, tick_w=9)


@pytest.mark.parametrize(("n", "slot_w"), [(1, 1), (2, 1), (3, 2), (4, 2), (5, 3), (8, 3), (9, 4), (64, 6)])
def test_slot_numbers_are_as_wide_as_they_must_be(n: int, slot_w: int) -> None:
    assert Shape(n_slots=n).slot_w == slot_w


def test_widths_that_follow_from_others() -> None:
    assert (Shape(radix_w=5).r_w, Shape(radix_w=5).rel_w) == (6, 7)  # R up to 62, an address up to 124


def test_every_register_has_an_address_of_its_own_and_a_field_in_the_configuration() -> None:
    addresses = [register.address for register in REGISTERS.values()]
    assert len(set(addresses)) == len(addresses)
    assert [field.name for field in fields(SlotConfig)] == list(REGISTERS)


def test_register_limits_follow_the_shape() -> None:
    shape = Shape(x_w=7, y_w=6, radix_w=5, nev_w=9, tc_w=12)
    assert {name: register.limits(shape) for name, register in REGISTERS.items()} == {
        "mode": (0, 2),
        "init_cm_x": (0, 127),
        "init_cm_y": (0, 63),
        **dict.fromkeys(("init_radix", "radix_th", "radix_step", "radix_min", "radix_max"), (0, 31)),
        "hist_avg": (0, 8),
        "max_ticks": (1, 4095),
        **dict.fromkeys(("clust_nev", "nev_min", "nev_max"), (1, 511)),
        "nev_th": (0, 4095),
        "detect_ticks": (1, 4095),
    }
    assert REGISTERS["mode"].bits(shape) == 2


def test_a_record_has_no_hidden_gaps_and_room_for_every_width() -> None:
    assert RECORD.itemsize == sum(RECORD[name].itemsize for name in RECORD.names or ()) == 48
    widest = {"seq": "seq_w", "time": "time_w", "track_id": "id_w", "other_id": "id_w", "support": "sup_w", "n_ev": "nev_w"}
    for field, width in widest.items():
        assert SHAPE_RANGES[width][1] <= 8 * RECORD[field].itemsize
    assert SHAPE_RANGES["x_w"][1] + SHAPE_RANGES["frac"][1] <= 8 * RECORD["cm_x"].itemsize
    assert np.iinfo(RECORD["slot"]).max >= SHAPE_RANGES["n_slots"][1]
    assert [kind.name for kind in Kind] == ["BORN", "MOVED", "MERGED", "LOST"]


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

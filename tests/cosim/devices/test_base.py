# SPDX-License-Identifier: Apache-2.0
"""The base of the drives: structures that C++ and Python share, endings that carry their fault, stall patterns."""

from __future__ import annotations

import ctypes

import numpy as np
import pytest

from evcot.errors import ConfigError
from evcot_cosim.devices.base import Ending, HardwareError, Stalls, pattern_fields, pointer, structure


class Some(Ending):
    """Two ways to end well, and one fault."""

    DONE = ""
    AGAIN = ""
    LOST = "lost event"


def test_endings_are_numbered_in_order_and_carry_what_a_fault_means() -> None:
    assert [(ending.name, ending.value, ending.fault) for ending in Some] == [
        ("DONE", 0, ""), ("AGAIN", 1, ""), ("LOST", 2, "lost event"),
    ]  # fmt: skip
    assert Some(2) is Some.LOST


def test_a_structure_has_its_fields_in_order_and_in_words_of_64_bits() -> None:
    shared = structure({"n": "int64_t", "x": "const uint16_t*", "seed": "uint64_t"})
    assert shared._fields_ == [("n", ctypes.c_int64), ("x", ctypes.c_void_p), ("seed", ctypes.c_uint64)]
    assert ctypes.sizeof(shared) == 24


def test_a_pattern_is_a_pointer_and_a_length() -> None:
    assert pattern_fields("in", "out") == {
        "in_pattern": "const uint8_t*", "in_length": "int64_t", "out_pattern": "const uint8_t*", "out_length": "int64_t",
    }  # fmt: skip


def test_pointer_is_the_address_of_the_data() -> None:
    array = np.arange(4, dtype=np.int64)
    assert pointer(array[2:]) == array.ctypes.data + 16
    assert pointer(None) is None


def test_a_pattern_that_never_goes_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"^stalls\.own: never goes: a pattern must hold at least one 1$"):
        Stalls(own=np.zeros(3, np.uint8))


def test_an_error_of_the_hardware_names_the_event() -> None:
    error = HardwareError("cot lost event 7", 7)
    assert (str(error), error.seq) == ("cot lost event 7", 7)
    assert isinstance(error, RuntimeError)

# SPDX-License-Identifier: Apache-2.0
"""Rows of port values, played to a flip-flop."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from evcot_cosim.devices.clocked import Top, rtl, simulation

ROW = np.dtype([("rst", "u1"), ("d", "u1")])
OUT = np.dtype([("q", "u1")])
FLIP_FLOP = Top("dff", (("RESET_TO_COMPLEMENT", 0),), ROW, OUT)
VALUES = np.array([1, 1, 0, 1, 0, 0, 1])


def rows(values: np.ndarray, rst: int = 0) -> np.ndarray:  # type: ignore[type-arg]
    given = np.zeros(len(values), ROW)
    given["rst"], given["d"] = rst, values
    return given


def test_outputs_are_those_before_the_edge_and_a_simulation_goes_on() -> None:
    rtl(FLIP_FLOP, rows(VALUES[:1], rst=1))
    parts = [rtl(FLIP_FLOP, rows(part))["q"] for part in (VALUES[:3], VALUES[3:3], VALUES[3:])]
    assert np.concatenate(parts).tolist() == [0, *VALUES[:-1]]


def test_a_port_that_is_not_valid_is_read_as_zero() -> None:
    never = replace(FLIP_FLOP, valid_with=(("q", "q"),))  # valid only while it is 0
    assert not rtl(never, rows(VALUES))["q"].any()


def test_one_simulation_does_not_touch_another() -> None:
    other = simulation.__wrapped__(FLIP_FLOP)
    rtl(FLIP_FLOP, rows(np.array([0, 0])))
    rtl(FLIP_FLOP, rows(np.array([1])), other)
    assert rtl(FLIP_FLOP, rows(np.array([0])))["q"].tolist() == [0]
    assert rtl(FLIP_FLOP, rows(np.array([0])), other)["q"].tolist() == [1]

# SPDX-License-Identifier: Apache-2.0
"""The model of the flip-flop."""

from __future__ import annotations

from evcot.hardware.dff import Dff


def test_the_output_is_the_input_one_clock_later() -> None:
    dff = Dff()
    assert dff.q is False
    assert [dff.step(d) for d in (True, True, False, True)] == [True, True, False, True]


def test_a_plain_reset_is_zero_whatever_the_input() -> None:
    dff = Dff()
    assert [dff.step(d, rst=True) for d in (True, False)] == [False, False]
    assert dff.step(True) is True


def test_the_published_reset_follows_the_complement_of_the_input() -> None:
    dff = Dff(reset_to_complement=True)
    assert [dff.step(d, rst=True) for d in (True, False, False, True)] == [False, True, True, False]
    assert dff.step(True) is True

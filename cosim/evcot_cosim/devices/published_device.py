# SPDX-License-Identifier: Apache-2.0
"""The published tracker and its cascade in hardware, clock by clock: plays stories to both hardware and model.

A story is a list of events, with clocks counted from the end of initialisation; both must match at every clock.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from evcot.hardware.published.model import (
    CASCADE_INPUT,
    CASCADE_OUTPUT,
    SELECT,
    SELECT_NONE,
    TRACKER_INPUT,
    TRACKER_OUTPUT,
    Handshakes,
    Played,
    PublishedCascade,
    PublishedConfig,
)

from .clocked import Ports, Top, rtl

__all__ = [
    "CASCADE",
    "LIBRARY",
    "TRACKER",
    "Event",
    "at",
    "equal",
    "play",
    "quiet",
    "reset_cascade",
]

Event = tuple[int, int, int]  # clock, high, low


# Ports that are valid only while their request is low. The library's line has a word at all times.
_VALID_WITH = tuple((f"m_{port}_{line}", f"m_{port}_req_n") for port in ("pass", "event", "centre") for line in ("high", "low"))

TRACKER = Top("cot_published", (), TRACKER_INPUT, TRACKER_OUTPUT, _VALID_WITH)
CASCADE = Top(
    "cot_published_chain", (("LIBRARY_LINE", 0),), CASCADE_INPUT, CASCADE_OUTPUT, (("m_word", "m_req_n"), *_VALID_WITH)
)
LIBRARY = Top("cot_published_chain", (("LIBRARY_LINE", 1),), CASCADE_INPUT, CASCADE_OUTPUT, _VALID_WITH)


def quiet(top: Top, n: int) -> Ports:
    """Inputs for n clocks without a request or an acknowledge."""
    rows = np.zeros(n, top.given)
    for name in rows.dtype.names or ():
        if name.endswith("_n"):
            rows[name] = 1
    return rows


def equal(found: Ports, expected: Ports, inputs: Ports, seed: object = None) -> None:
    """Raise AssertionError with the first clock at which two traces differ."""
    if len(differing := np.flatnonzero(found != expected)):
        at = differing[0]
        raise AssertionError(f"seed {seed}, clock {at}, {inputs[at]}: hardware {found[at]}, model {expected[at]}")


def reset_cascade(top: Top, configs: Sequence[PublishedConfig]) -> None:
    """Reset the hardware and write its registers, as the model's constructor does."""
    rows = quiet(top, 1)
    rows["rst"] = 1
    writes = [write for i, config in enumerate(configs) for write in config.writes(i)]
    writes += [(SELECT, SELECT_NONE)] if configs else []
    written = quiet(top, len(writes) + 1)
    written["cfg_valid"][:-1] = 1
    for row, (address, data) in zip(written, writes, strict=False):
        row["cfg_addr"], row["cfg_data"] = address, data
    rtl(top, np.concatenate([rows, written] if writes else [rows]))


def play(events: Iterable[Event], *configs: PublishedConfig, top: Top = CASCADE, **patterns: list[int]) -> Played:
    """Play a story to a new cascade in hardware and model, which must match at every clock; returns the model's trace."""
    model = PublishedCascade(configs, library_line=top is LIBRARY)
    reset_cascade(top, configs)
    ready = model.clock
    clock, high, low = np.array(list(events), np.int64).reshape(-1, 3).T
    handshakes = Handshakes(**{name: np.array(pattern) for name, pattern in patterns.items()})
    played = model.play(ready + clock, high, low, handshakes, trace=True)
    equal(rtl(top, played.inputs), played.outputs, played.inputs)
    return played._replace(
        acknowledged=played.acknowledged - ready, word_clock=played.word_clock - ready, pass_clock=played.pass_clock - ready
    )


def at(clocks: Iterable[int], high: int = 100, low: int = 100) -> list[Event]:
    """Events at one pixel at these clocks."""
    return [(clock, high, low) for clock in clocks]

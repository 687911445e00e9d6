# SPDX-License-Identifier: Apache-2.0
"""Support for tests of modules with token ports: events encoded as tokens, as the streaming drives do, and decoded again."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .stream_device import Bundle

__all__ = ["TOKENS_IN", "TOKENS_OUT", "TokenEvents", "decode_tokens"]

_FIELDS = ("tick", "event", "skip", "x", "y", "p")
TOKENS_IN = Bundle("s_", _FIELDS)
TOKENS_OUT = Bundle("m_", _FIELDS)


class TokenEvents(NamedTuple):
    """A decoded stream of tokens: the time of each event, the events, and the total duration.

    Attributes:
        at: (n,) int64, ticks from the start to each event.
        events: (n, 5) uint64, rows (event, skip, x, y, p).
        ticks: duration of the whole stream.
    """

    at: NDArray[np.int64]
    events: NDArray[np.uint64]
    ticks: int


def decode_tokens(tokens: NDArray[np.uint64]) -> TokenEvents:
    """Decode (n, 6) tokens (tick, event, skip, x, y, p)."""
    now = np.cumsum(tokens[:, 0].astype(np.int64))
    is_event = (tokens[:, 1] | tokens[:, 2]) == 1
    return TokenEvents(now[is_event], tokens[is_event, 1:], int(now[-1]) if len(now) else 0)

# SPDX-License-Identifier: Apache-2.0
"""Limit on gaps between events for hardware: ticks without events cost clocks, and none of them may be left out.

A token holds up to 2^TICK_W - 1 ticks, and a longer wait is driven as several tokens of one clock each. The results depend on
every tick, and records carry the tick count, so a wait cannot be shortened without changing them: a wait of more than
`SILENT_CLOCKS_MAX` clocks is refused before anything is driven.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from evcot.errors import RecordingError
from evcot.hardware.config import HardwareConfig

__all__ = ["SILENT_CLOCKS_MAX", "check_silence", "check_waits"]

SILENT_CLOCKS_MAX = 1 << 24  # seconds of simulation; 203 days of silence where a tick is a microsecond and TICK_W is 20


def _longest(times: NDArray[np.int64], before: int) -> tuple[int, int, int]:
    """The longest gap before one of at least one time: the index of the time after it, the time before it, its length."""
    steps = np.diff(times)
    at = int(steps.argmax()) + 1 if len(steps) else 0
    if not at or int(times[0]) - before >= int(steps[at - 1]):
        at, last = 0, before
    else:
        last = int(times[at - 1])
    return at, last, int(times[at]) - last


def check_silence(t_us: NDArray[np.int64], config: HardwareConfig, first_index: int = 0, before_us: int | None = None) -> None:
    """Raise RecordingError where a run of a recording's events, in time order, has a gap too long for hardware.

    Args:
        t_us: (n,) their times.
        config: gives the length of a tick and the number of ticks per token.
        first_index: number of the first event.
        before_us: time of the event before the first, if there is one.
    """
    if not len(t_us):
        return
    at, last_us, gap_us = _longest(t_us, int(t_us[0]) if before_us is None else before_us)
    clocks = gap_us // config.tick_us // ((1 << config.shape.tick_w) - 1)
    if clocks > SILENT_CLOCKS_MAX:
        raise RecordingError(
            f"event {first_index + at}: t = {t_us[at]} us follows t = {last_us} us: a gap of {gap_us / 1e6:g} s costs {clocks} "
            f"clocks: must be at most {SILENT_CLOCKS_MAX}; take a part without it (--from, --to), or a longer tick_us"
        )


def check_waits(ticks: NDArray[np.int64], now: int, tick_max: int, first_index: int = 0) -> None:
    """The same of ticks since reset, of which `now` have passed, where a token holds up to `tick_max`; none may run back."""
    if not len(ticks):
        return
    if int(ticks[0]) < now or bool((ticks[1:] < ticks[:-1]).any()):
        at = 0 if int(ticks[0]) < now else int(np.argmax(ticks[1:] < ticks[:-1])) + 1
        last = int(ticks[at - 1]) if at else now
        raise RecordingError(f"event {first_index + at}: tick {ticks[at]} follows tick {last}: time must not run back")
    at, last, gap = _longest(ticks, now)
    if gap // tick_max > SILENT_CLOCKS_MAX:
        raise RecordingError(
            f"event {first_index + at}: tick {ticks[at]} follows tick {last}: {gap // tick_max} clocks of silence: "
            f"must be at most {SILENT_CLOCKS_MAX}"
        )

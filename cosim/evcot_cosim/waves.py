# SPDX-License-Identifier: Apache-2.0
"""Waveforms of a run: a window of events simulated again, as a VCD and a view that opens it in GTKWave."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from evcot.config import CotConfig
from evcot.errors import ConfigError
from evcot.events import Events

from .device import Stalls, Top
from .gtkwave import write_view
from .lockstep import dump_window

__all__ = ["Window", "write_waves"]


@dataclass(frozen=True)
class Window:
    """Events `first` to `last`, both shown."""

    first: int
    last: int

    @classmethod
    def around(cls, event: int, n_events: int, reach: int) -> Window:
        """`reach` events before and after one, as far as the recording goes."""
        return cls(max(0, event - reach), min(n_events - 1, event + reach))

    @classmethod
    def of_time(cls, events: Events, from_us: int, to_us: int) -> Window:
        """The events with from_us <= t - t[0] < to_us.

        Raises:
            ConfigError: there are none.
        """
        t_us = events.t_us - events.t_us[0]
        first, end = (int(i) for i in np.searchsorted(t_us, (from_us, to_us)))
        if first >= end:
            raise ConfigError(f"waveform from {from_us} us to {to_us} us: no event there, the last is at {int(t_us[-1])} us")
        return cls(first, end - 1)


def write_waves(
    events: Events,
    config: CotConfig,
    folder: Path,
    window: Window,
    *,
    top: Top = "cot_array",
    stalls: Stalls | None = None,
    name: str = "waves",
) -> tuple[Path, Path]:
    """Simulate up to the window's end again and write `<name>.vcd` and its GTKWave view `<name>.gtkw` into a folder.

    Raises:
        OutputError: a file cannot be written.
    """
    vcd = folder / f"{name}.vcd"
    dump_window(events, config, vcd, window.first, window.last, top=top, stalls=stalls)
    view = folder / f"{name}.gtkw"
    write_view(vcd, view)
    return vcd, view

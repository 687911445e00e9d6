# SPDX-License-Identifier: Apache-2.0
"""Waveforms of a run: a window of events, simulated again, as VCD and FST with a GTKWave view."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from evcot.errors import ConfigError
from evcot.events import Events
from evcot.hardware.config import CotConfig, MotionConfig

from ..devices.base import Stalls
from ..lockstep.lockstep import Clocks, dump_window
from ..lockstep.moments import Moment
from ..rtl.build import BuiltModel
from .fst import fst_writer, write_fst
from .gtkwave import Marker, write_view
from .views import VIEWS

__all__ = ["CLOCK", "Window", "wave_names", "write_waves"]

CLOCK, _EDGE = 10, 5  # steps of a VCD's time: a clock, and where its edge rises
_SHOWN_CLOCKS = 40  # before and after a moment, when the view opens


@dataclass(frozen=True)
class Window:
    """Events `first` to `last`, inclusive."""

    first: int
    last: int

    @classmethod
    def around(cls, event: int, n_events: int, reach: int) -> Window:
        """A window of `reach` events before and after an event, clipped to the recording."""
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


def wave_names(name: str = "waves") -> list[str]:
    """Names of the files that `write_waves` may write."""
    codes = {row.codes.name for groups in VIEWS.values() for group in groups for row in group.rows if row.codes}
    return [*(f"{name}.{suffix}" for suffix in ("vcd", "gtkw", "fst")), *(f"{name}-{code}.txt" for code in sorted(codes))]


def write_waves(
    events: Events,
    config: CotConfig | MotionConfig,
    folder: Path,
    window: Window,
    *,
    stalls: Stalls | None = None,
    model: BuiltModel | None = None,
    name: str = "waves",
    moment: Moment | None = None,
    force: bool = False,
) -> tuple[Path, Path]:
    """Simulate again up to the window's end and write `<name>.vcd`, its GTKWave view `<name>.gtkw` and, with pylibfst,
    `<name>.fst` into a folder. Markers in the view: when `moment`'s event is accepted, and when its record is sent.
    `model`: as of `dump_window`.

    Raises:
        OutputError: a file exists (without `force`), or cannot be written.
    """
    vcd = folder / f"{name}.vcd"
    clocks = dump_window(events, config, vcd, window.first, window.last, stalls=stalls, model=model, force=force)
    view = folder / f"{name}.gtkw"
    write_view(vcd, view, _markers(moment, clocks) if moment else (), reach=_SHOWN_CLOCKS * CLOCK, force=force)
    if fst_writer() is not None:
        write_fst(vcd, vcd.with_suffix(".fst"), force=force)
    return vcd, view


def _markers(moment: Moment, clocks: Clocks) -> list[Marker]:
    """Markers at the clocks at which the event of a moment was accepted and its record sent."""
    markers = []
    if moment.event_index < len(clocks.accepted):
        title = "event" if moment.kind is not None else moment.name
        markers.append(Marker(int(clocks.accepted[moment.event_index]) * CLOCK + _EDGE, title))
    if moment.kind is not None:
        records = clocks.records
        found = np.flatnonzero((records["kind"] == moment.kind) & (records["track_id"] == moment.track_id))
        at = found[records["seq"][found] >= moment.event_index]
        if len(at):
            markers.append(Marker(int(clocks.recorded[at[0]]) * CLOCK + _EDGE, moment.name))
    return markers

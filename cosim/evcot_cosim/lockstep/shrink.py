# SPDX-License-Identifier: Apache-2.0
"""A case in which hardware and model differ, with as few events as possible, written as a test with its waveform."""

from __future__ import annotations

from dataclasses import fields
from enum import IntEnum
from pathlib import Path
from typing import Any

import numpy as np

from evcot.errors import RecordingError
from evcot.events import Events
from evcot.outputs import written_aside

from ..devices.base import Stalls
from ..rtl.build import BuiltModel
from .lockstep import dump_window
from .mismatch import Mismatch, MismatchError
from .random_runs import Case, run_case

__all__ = ["difference_in", "shrunk", "write_test"]

_TRIES = 300  # runs of a case


def difference_in(case: Case, model: BuiltModel | None = None) -> Mismatch | None:
    """The first difference of a run; None if there is none, or if the case cannot run."""
    try:
        run_case(case, model)
    except MismatchError as error:
        return error.mismatch
    except RecordingError:
        pass
    return None


def shrunk(case: Case, model: BuiltModel | None = None) -> tuple[Case, Mismatch]:
    """Leave out the events after the difference, then ever smaller blocks of those before, as long as there is one.

    Raises:
        ValueError: hardware and model agree on the case.
    """
    found, tries = difference_in(case, model), 0
    if found is None:
        raise ValueError("hardware and model agree")

    def with_events(events: Events) -> bool:
        nonlocal case, found, tries
        tries += 1
        smaller = case._replace(events=events)
        different = difference_in(smaller, model) if len(events) else None
        if different is None:
            return False
        case, found = smaller, different
        return True

    with_events(case.events[: found.event_index + 1].kept())
    size = len(case.events) // 2
    while size and tries < _TRIES:
        begin = 0
        while begin < len(case.events) and tries < _TRIES:
            keep = np.ones(len(case.events), np.bool_)
            keep[begin : begin + size] = False
            if not with_events(case.events.where(keep)):
                begin += size
        size //= 2
    return case, found


def write_test(case: Case, mismatch: Mismatch, folder: Path, name: str, model: BuiltModel | None = None) -> None:
    """Write `test_NAME.py`, which fails as long as hardware and model differ, and `NAME.vcd`, all clocks of the case.

    Args:
        folder: exists and has neither of them.
        model: a model with all signals, to avoid the look-up.

    Raises:
        OutputError: a file exists, or cannot be written.
    """
    with written_aside(folder / f"test_{name}.py") as file:
        file.write(_source(case, mismatch, name).encode())
    stalls, vcd = Stalls.seeded(case.stalls), folder / f"{name}.vcd"
    dump_window(case.events, case.config, vcd, 0, len(case.events) - 1, stalls=stalls, model=model)


def _source(case: Case, mismatch: Mismatch, name: str) -> str:
    columns = "\n".join(
        f"    {column}=np.array({getattr(case.events, column).tolist()}, np.{getattr(case.events, column).dtype}),"
        for column in ("t_us", "x", "y", "p")
    )
    config = _plain(case.config)
    return f'''"""{mismatch}

Made by evcot from a random run; {name}.vcd has the clocks.
"""

import numpy as np

from evcot.events import Events
from evcot.filters.contract import FilterShape
from evcot.filters.registers import FilterRegisters
from evcot.hardware.config import CotConfig, MotionConfig, SlotConfig
from evcot.hardware.contract import Shape
from evcot.hardware.motion.contract import MotionRegisters
from evcot_cosim.lockstep.random_runs import Case, run_case

CONFIG = {config}

EVENTS = Events(
{columns}
)


def test_hardware_and_model_agree() -> None:
    assert run_case(Case(CONFIG, EVENTS, stalls={case.stalls})).events == len(EVENTS)
'''


def _plain(value: Any) -> str:
    """Python text of a configuration: its dataclasses with all fields."""
    if isinstance(value, tuple):
        return f"({''.join(f'{_plain(each)}, ' for each in value)})"
    if isinstance(value, IntEnum):
        return repr(int(value))
    if not hasattr(value, "__dataclass_fields__"):
        return repr(value)
    own = (f"{each.name}={_plain(getattr(value, each.name))}" for each in fields(value) if each.init)
    return f"{type(value).__name__}({', '.join(own)})"

# SPDX-License-Identifier: Apache-2.0
"""How long a file is."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from evcot.errors import RecordingError
from evcot.events import Recording
from evcot.recordings.files import open_recording, write_recording
from evcot_cosim.commands.actions.length import Length

from ..live.stories import SENSOR, random_events, wait_until


@pytest.mark.parametrize("window", [(0, None), (1_000, 30_000), (30_000, None)])
def test_it_is_that_of_the_window(tmp_path: Path, window: tuple[int, int | None]) -> None:
    some = random_events(4_000, 1)
    write_recording(Recording(some, *SENSOR), tmp_path / "a.npz")
    after_us = some.t_us - some.t_us[0]
    inside = after_us[(after_us >= window[0]) & (after_us < (window[1] or np.inf))]
    found: list[tuple[int, float]] = []
    with Length(lambda: open_recording(tmp_path / "a.npz"), window, lambda *told: found.append(told)):
        wait_until(lambda: bool(found))
    assert found == [(len(inside), (inside[-1] - window[0]) / 1e6)]


def test_a_file_that_cannot_be_read_has_none() -> None:
    def opened() -> None:
        raise RecordingError("here: something")

    found: list[tuple[int, float]] = []
    length = Length(opened, (0, None), lambda *told: found.append(told))  # type: ignore[arg-type]
    with length:
        length._thread.join(10)
    assert found == []

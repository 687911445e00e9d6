# SPDX-License-Identifier: Apache-2.0
"""`evcot track` and `evcot cosim` are one tracker: the same records and owners, byte for byte, on every recording."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import evcot
import evcot_cosim
from evcot.recordings.files import read_recording
from evcot.scenes.registry import SCENES, simulate_scene

DATA = Path(__file__).parents[4] / "shared" / "data"
RECORDINGS = ["traffic_outbound.aedat4", "hand_dvs128.aedat4", "pendulum_dvs128.aedat"]


def check(recording: evcot.Recording) -> None:
    run = evcot_cosim.cosim(recording)
    log = evcot.track(recording)
    for hardware in (run.hardware, run.model):
        assert hardware.records.tobytes() == log.records.tobytes()
        assert hardware.owner.tobytes() == log.owner.tobytes()
    assert len(log.records)
    assert np.any(log.owner >= 0)


@pytest.mark.parametrize("scene", SCENES)
def test_on_a_scene(scene: str) -> None:
    check(simulate_scene(scene, 4711, {"duration_us": 600_000}).recording)


@pytest.mark.parametrize("name", RECORDINGS)
def test_on_a_recording(name: str) -> None:
    if not (DATA / name).is_file():
        pytest.skip(f"{name} is not here")
    check(read_recording(DATA / name))

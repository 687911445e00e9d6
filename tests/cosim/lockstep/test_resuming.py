# SPDX-License-Identifier: Apache-2.0
"""A lock-step run that continues from a saved state does what an unbroken one does: every decision, record and clock."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest

from evcot.events import Events
from evcot.filters.config import FilterConfig
from evcot.hardware.config import CotConfig, SlotConfig
from evcot.hardware.contract import Shape
from evcot_cosim.devices.base import Stalls
from evcot_cosim.devices.device import build_device
from evcot_cosim.lockstep.lockstep import Lockstep, Step, chunks
from support.full_disk import full_disk
from support.trials import random_traffic

SHAPE = Shape(n_slots=2, x_w=7, y_w=7, radix_w=5, nev_w=6, tc_w=12, sup_w=8, id_w=16, seq_w=16, time_w=20, tick_w=3)
SLOT = SlotConfig(
    init_radix=4, radix_th=2, radix_step=0, radix_min=4, radix_max=31, hist_avg=0,
    max_ticks=30, clust_nev=1, nev_min=1, nev_max=8, nev_th=4000, detect_ticks=100,
)  # fmt: skip
PLAIN = CotConfig.uniform(SHAPE, SLOT)
FILTERS = FilterConfig(refractory_us=20, activity_us=200)
FILTERED = replace(PLAIN, filters=FILTERS.registers(1), filter_shape=FILTERS.shape(128, 128))
CHUNK = 1_000


def traffic(n: int) -> Events:
    made = random_traffic(np.random.default_rng(3), SHAPE, n, 1)
    return Events(500_000 + made.ticks, made.x, made.y, made.p)


def same(one: Step, other: Step) -> bool:
    return all(np.array_equal(*pair) for pair in zip(one.hardware, other.hardware, strict=True))


@pytest.mark.parametrize(("config", "seed"), [(PLAIN, None), (FILTERED, 5)], ids=["plain", "filtered and stalled"])
def test_a_restored_run_is_the_unbroken_one(config: CotConfig, seed: int | None) -> None:
    def started() -> Lockstep:
        stalls = None if seed is None else Stalls.random(np.random.default_rng(seed))
        return Lockstep(config, stalls=stalls, seed=seed, model=build_device(config, waves=False, savable=True))

    parts = list(chunks(traffic(6 * CHUNK), CHUNK))
    with started() as unbroken, started() as first, started() as second:
        wanted = [unbroken.feed(part) for part in parts]
        assert sum(len(step.hardware.records) for step in wanted[3:]) > 100
        for part in parts[:3]:
            first.feed(part)
        second.feed(parts[0])  # whatever it did before is forgotten
        second.restore(pickle.loads(pickle.dumps(first.state())))
        assert all(same(second.feed(part), step) for part, step in zip(parts[3:], wanted[3:], strict=True))
        assert second.device.cycle == unbroken.device.cycle
        assert (second.events, second.records) == (unbroken.events, unbroken.records)
        assert np.array_equal(second.latency, unbroken.latency)


def test_state_is_saved_in_memory_where_no_file_can_be_written() -> None:
    """Verilator's own writer ends the process on a full disk."""
    with Lockstep(PLAIN, model=build_device(PLAIN, waves=False, savable=True)) as lockstep:
        with full_disk(0):
            lockstep.restore(lockstep.state())
        assert len(lockstep.feed(traffic(CHUNK)).hardware.owner) == CHUNK

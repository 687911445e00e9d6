# SPDX-License-Identifier: Apache-2.0
"""`hist_avg` written past the bus, which allows no more than 8: RTL and golden model agree on every value of its four bits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from evcot.hardware.config import CotConfig
from evcot.hardware.contract import HIST_AVG_STILL, REGISTERS, Shape
from evcot.hardware.cot import CotModel
from evcot.hardware.model import Decisions
from evcot.hardware.modules import Module
from evcot.tracks.log import Kind
from evcot_cosim.devices.base import Stalls
from evcot_cosim.devices.device import Device
from support.ticked import ticked
from support.trials import bare_device, random_config, random_traffic

SHAPE = Shape(n_slots=3, x_w=7, y_w=7, radix_w=5, nev_w=6, tc_w=12, sup_w=8, id_w=16, seq_w=16, time_w=20)


def write(model: CotModel, device: Device, k: int) -> None:
    """Write one value to all slots of both, past every check."""
    model._regs[list(REGISTERS).index("hist_avg")] = k
    io = device.sim.io
    io.cfg_valid, io.cfg_addr, io.cfg_data = 1, REGISTERS["hist_avg"].address, k
    for slot in range(device.shape.n_slots):
        if device.config.module != "cot":
            io.cfg_slot = slot
        device.sim.clock.tick()
    io.cfg_valid = 0


@pytest.mark.parametrize("frac", [0, 4])
@pytest.mark.parametrize("module", ["cot", "cot_chain", "cot_array"])
def test_every_value_has_one_meaning(module: Module, frac: int) -> None:
    shape = replace(SHAPE, frac=frac, n_slots=1 if module == "cot" else 3)
    moved: dict[int, int] = dict.fromkeys(range(16), 0)
    for seed in range(4):
        rng = np.random.default_rng([81, seed])
        config = random_config(rng, shape, module)
        slots = tuple(replace(slot, nev_min=1, nev_max=4, clust_nev=2, detect_ticks=4_000) for slot in config.slots)
        config = replace(config, slots=slots)
        device = bare_device(config, stalls=Stalls.random(rng) if seed % 2 else None)
        model = CotModel(config)
        for k in rng.permutation(16).tolist():
            write(model, device, k)
            traffic = random_traffic(rng, shape, 600, 1, device.now)
            hardware, golden = device.stream(traffic), model.feed(traffic)
            for field in Decisions._fields:
                assert np.array_equal(getattr(hardware, field), getattr(golden, field)), (
                    f"seed {seed}, k = {k}: {field} differs"
                )
            moves = golden.records[golden.records["kind"] == Kind.MOVED]
            for track in np.unique(moves["track_id"]):
                x = moves["cm_x"][moves["track_id"] == track].astype(int)
                moved[k] += int(np.count_nonzero(np.diff(x)))
    print(moved)
    assert all(moved[k] > 0 for k in range(6))


@pytest.mark.parametrize("frac", [0, 4])
@pytest.mark.parametrize("k", [HIST_AVG_STILL - 1, HIST_AVG_STILL, 15])
def test_from_ten_on_nothing_moves(k: int, frac: int) -> None:
    """Far to the right of a centre at 0, in a window as wide as the sensor."""
    shape = Shape(n_slots=1, x_w=12, y_w=4, radix_w=12, frac=frac)
    slot = {
        "init_radix": 4000,
        "radix_min": 4000,
        "radix_max": 4000,
        "radix_step": 0,
        "clust_nev": 1,
        "nev_min": 1,
        "nev_max": 1,
    }
    config = CotConfig.uniform(shape, replace(CotConfig(shape).slots[0], **slot, max_ticks=1_000))
    device, model = bare_device(config), CotModel(config)
    write(model, device, k)
    traffic = ticked(np.arange(600), [0] + [4000] * 599, 0)
    hardware, golden = device.stream(traffic), model.feed(traffic)
    assert np.array_equal(hardware.records, golden.records)
    assert (len(set(golden.records["cm_x"].tolist())) > 1) == (k < HIST_AVG_STILL)

# SPDX-License-Identifier: Apache-2.0
"""A reset of one clock, at any moment of busy traffic, leaves nothing behind in any tracker; what an upset stops resumes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import upsets
from evcot.hardware.config import CotConfig, MotionConfig, SlotConfig
from evcot.hardware.contract import Mode, Shape
from evcot.tracks.log import Kind
from evcot_cosim.devices.device import Device
from support.moving import QUICK
from support.trials import bare_device

SHAPE = Shape(n_slots=2, x_w=5, y_w=5, radix_w=4, nev_w=6, tc_w=12, sup_w=8, id_w=8, seq_w=16, time_w=24)
EVERY_EVENT = SlotConfig(
    mode=Mode.SEEDED, init_radix=2, radix_th=1, radix_step=1, radix_min=1, radix_max=4, hist_avg=1,
    max_ticks=40, clust_nev=1, nev_min=1, nev_max=1, nev_th=0, detect_ticks=40,
)  # fmt: skip
OUTPUTS = ("m_cm", "m_own", "m_pass")


def device_of(module: str) -> Device:
    if module == "cot_motion":
        return bare_device(MotionConfig(replace(SHAPE, time_w=32), QUICK))
    return bare_device(CotConfig(SHAPE, (EVERY_EVENT,) * SHAPE.n_slots, module=module))


def run(device: Device, clocks: int, rng: np.random.Generator) -> None:
    """Two places from which events come at almost every clock, while the outputs stall now and then."""
    io = device.sim.io
    for _ in range(clocks):
        for output in OUTPUTS:
            setattr(io, f"{output}_ready", int(rng.random() < 0.8))
        io.s_valid, io.s_event, io.s_tick = int(rng.random() < 0.9), 1, int(rng.integers(4))
        io.s_x, io.s_y = (int(place + rng.integers(-1, 2)) for place in rng.choice([8, 22], 2))
        device.sim.clock.tick()


@pytest.mark.parametrize("module", ["cot_array", "cot_chain", "cot_motion"])
def test_after_a_reset_of_one_clock_nothing_comes_out(module: str) -> None:
    print("seed 12")
    rng = np.random.default_rng(12)
    device = device_of(module)
    io = device.sim.io
    for _ in range(150):
        device.reset()
        run(device, int(rng.integers(40, 100)), rng)
        io.rst = 1
        device.sim.clock.tick()
        io.rst, io.s_valid = 0, 0
        for output in OUTPUTS:
            setattr(io, f"{output}_ready", 1)
        for _ in range(60):
            assert [output for output in OUTPUTS if getattr(io, f"{output}_valid")] == []
            device.sim.clock.tick()


def test_a_merge_ends_as_ever_after_a_reset_in_another_one() -> None:
    """Centres are wide, so that a mean takes long: the one that a reset has broken off is done when the next merge begins."""
    shape = replace(SHAPE, x_w=16, y_w=16, frac=8)
    slot = replace(EVERY_EVENT, max_ticks=4000, detect_ticks=4000)
    device = bare_device(CotConfig(shape, (slot, slot), module="cot_array"))
    io = device.sim.io
    for output in OUTPUTS:
        setattr(io, f"{output}_ready", 1)

    def two_events(clocks: int) -> list[int]:
        """Two births whose windows overlap; returns the kinds of the records."""
        kinds, columns = [], [10, 14]
        io.s_event, io.s_tick, io.s_y = 1, 1, 10
        for _ in range(clocks):
            io.s_valid, io.s_x = int(bool(columns)), columns[0] if columns else 0
            if columns and io.s_ready:
                del columns[0]
            if io.m_cm_valid:
                kinds.append(int(io.m_cm_kind))
            device.sim.clock.tick()
        return kinds

    whole = [Kind.BORN, Kind.BORN, Kind.MERGED, Kind.MOVED]
    for clocks in range(40, 180):
        device.reset()
        two_events(clocks)
        io.rst = 1
        device.sim.clock.tick()
        io.rst, io.s_valid, io.cfg_valid, io.cfg_addr, io.cfg_data = 0, 0, 1, 0, int(Mode.SEEDED)
        for io.cfg_slot in range(2):  # of the registers a reset changes only the modes
            device.sim.clock.tick()
        io.cfg_valid = 0
        assert two_events(300) == whole, f"{clocks} clocks before the reset"


def test_a_watchdog_frees_the_streams_of_cot_motion() -> None:
    print("seed 22")
    bench = upsets.Bench("cot_motion", 22)
    clean = bench.run()
    heads = [bit for bit in bench.bits(1.0) if bit.name.endswith("u_jobs.head")]
    assert heads
    for bit in heads:
        found = bench.run(12_000, bit)
        assert clean.clocks < found.clocks < clean.clocks + (1 << 15)
        seq = bench.columns["own"].index("m_own_seq")
        restart = np.flatnonzero(np.diff(found.own[:, seq].astype(np.int64)) < 0)
        assert len(restart) == 1, "event numbers begin again, once"
        assert len(found.own) - restart[0] > 100, "slots are as the registers have them: they own events again"

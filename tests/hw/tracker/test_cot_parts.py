# SPDX-License-Identifier: Apache-2.0
"""The parts of one tracker: window, averages by history, an axis, the module around it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from pyverilator import PyVerilator

from evcot.hardware import _cot_kernel as kernel
from evcot.hardware.config import CotConfig
from evcot.hardware.contract import HIST_AVG_STILL, REGISTERS, Shape
from evcot.hardware.cot import CotModel
from evcot.hardware.model import Decisions
from evcot.hardware.modules import Module
from evcot.tracks.log import Kind
from evcot_cosim.devices.base import Stalls
from evcot_cosim.devices.device import Device
from evcot_cosim.rtl.build import load
from support.testing import evaluate
from support.tokens import ticked
from support.trials import bare_device, random_config, random_traffic


def check(centre: np.ndarray, radius: np.ndarray, w: int, frac: int, r_w: int) -> None:
    """The definition: a centre rounded to nearest, halves up, less and plus a radius."""
    inputs = {"asked": 1, "centre": centre, "radius": radius, "inset": (radius - 1) % (1 << r_w + 1)}
    result = evaluate("cot_window", {"W": w, "FRAC": frac, "R_W": r_w}, inputs, ["pixel", "lo_not", "hi"])
    pixel = np.floor(centre / 2.0**frac + (0.5 if frac else 0)).astype(np.int64)
    zero = 1 << max(w, r_w) + 1  # what stands for address 0
    on_sensor = pixel < 1 << w  # no centre lies beyond the last pixel
    np.testing.assert_array_equal(result["pixel"][on_sensor], pixel[on_sensor])
    np.testing.assert_array_equal(2 * zero - 1 - result["lo_not"], zero + pixel - radius)
    np.testing.assert_array_equal(result["hi"], zero + pixel + radius)


@pytest.mark.parametrize(("w", "frac", "r_w"), [(1, 0, 2), (5, 0, 6), (2, 1, 3), (5, 4, 6)])
def test_every_centre_and_radius(w: int, frac: int, r_w: int) -> None:
    centre, radius = (axis.ravel() for axis in np.meshgrid(np.arange(1 << w + frac), np.arange(1 << r_w)))
    check(centre, radius, w, frac, r_w)


@pytest.mark.parametrize(("w", "frac", "r_w"), [(16, 8, 13), (16, 0, 2)])
def test_random_wide_centres(w: int, frac: int, r_w: int) -> None:
    rng = np.random.default_rng(w)
    check(rng.integers(0, 1 << w + frac, 50_000), rng.integers(0, 1 << r_w, 50_000), w, frac, r_w)


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


IDLE = dict.fromkeys(["place", "begins", "seeds", "takes", "moves"], 0)


def step(value: int, target: int, k: int, frac: int) -> int:
    """A step of the contract, by the golden model: none from a k of 10 on."""
    return int(kernel._approach.py_func(value, target, k, frac))


def clock(sim: PyVerilator, **inputs: int) -> None:
    """One clock with these inputs; the steps that are not named are not taken."""
    for name, value in (IDLE | inputs).items():
        setattr(sim.io, name, value)
    sim.clock.tick()


@pytest.mark.parametrize(("w", "frac", "radix_w"), [(1, 0, 1), (7, 4, 5), (9, 1, 12), (16, 8, 3)])
def test_events_move_average_and_centre_and_window(w: int, frac: int, radix_w: int) -> None:
    rng = np.random.default_rng([12, w])
    moved = hits = rings = 0
    sim = load("cot_axis", {"W": w, "FRAC": frac, "RADIX_W": radix_w})
    for _ in range(40):
        radius, k = int(rng.integers(1 << radix_w + 1)), int(rng.integers(12))
        at = int(rng.integers(1 << w))
        sim.io.radius, sim.io.k = radius, k
        clock(sim, place=1, at=at)
        clock(sim)
        average = centre = at << frac
        for _ in range(20):
            pixel = (centre + (1 << frac >> 1)) >> frac
            token = int(np.clip(pixel + rng.integers(-2 * radius - 2, 2 * radius + 3), 0, (1 << w) - 1))
            g, seeds = int(rng.integers(1 << min(w, radix_w))), bool(rng.random() < 0.1)
            sim.io.token = token
            sim.eval()
            inside = abs(token - pixel) <= radius
            assert sim.io.hit == inside
            if inside:
                assert sim.io.rel == token - pixel + radius
            sim.io.g = g
            clock(sim, begins=1, seeds=seeds)
            beyond = not seeds and abs(token - pixel) > g
            assert sim.io.ring == beyond
            sim.io.token = int(rng.integers(1 << w))  # it is taken where it begins
            clock(sim, takes=1)
            clock(sim, moves=1)
            if not seeds:
                average = step(average, token << frac, k, frac)
                before, centre = centre, step(centre, average, k, frac)
                moved += centre != before
            assert (sim.io.av, sim.io.cm) == (average, centre)
            clock(sim)
            hits += inside
            rings += beyond
    assert hits > 50
    assert min(moved, rings) > 50 or w == 1

# SPDX-License-Identifier: Apache-2.0
"""lfsr.v against its twin: full periods, seeds, the refused seed."""

from __future__ import annotations

import contextlib

import numpy as np
import pytest

from evcot.errors import ConfigError
from evcot.hardware.lfsr import WIDTH_MAX, WIDTH_MIN, Lfsr
from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load
from support.testing import lint

WIDTHS = [2, 16, 64]


@pytest.mark.parametrize("width", range(WIDTH_MIN, WIDTH_MAX + 1))
def test_every_width_lints_clean(width: int) -> None:
    assert lint("lfsr", WIDTH=width) == (0, "")


@pytest.mark.parametrize("width", [WIDTH_MIN - 1, WIDTH_MAX + 1])
def test_refuses_a_width_without_taps(width: int) -> None:
    code, log = lint("lfsr", WIDTH=width)
    assert code != 0
    assert "WIDTH_must_be_2_to_64" in log


@pytest.mark.parametrize("width", [2, 16])
def test_a_full_period_from_reset(width: int) -> None:
    """From all zeros through every state but all ones, in the twin's order; done rises at step 2^width - 1 and not before."""
    sim = load("lfsr", {"WIDTH": width})
    reset(sim)
    assert (sim.io.state, sim.io.done) == (0, 0)
    sim.io.enable = 1
    states = np.empty((1 << width) - 1, np.uint64)
    done = np.empty(states.size, bool)
    for i in range(states.size):
        sim.clock.tick()
        states[i], done[i] = sim.io.state, sim.io.done
    assert np.array_equal(states, Lfsr(width).states(states.size))
    assert np.array_equal(np.sort(states), np.arange(states.size))
    assert np.flatnonzero(done).tolist() == [states.size - 1]
    sim.clock.tick()
    assert (sim.io.state, sim.io.done) == (1, 0)


def test_a_seed_starts_a_period_and_the_lock_up_seed_is_refused() -> None:
    sim = load("lfsr", {"WIDTH": 16})
    reset(sim)
    sim.io.load, sim.io.seed = 1, 0xBEEF
    assert sim.io.seed_error == 0
    sim.clock.tick()
    assert sim.io.state == 0xBEEF

    sim.io.enable, sim.io.seed = 1, 0xFFFF
    assert sim.io.seed_error == 1
    sim.clock.tick()
    assert sim.io.state == 0xBEEF
    sim.io.load = 0
    assert sim.io.seed_error == 0

    steps = 0
    while not sim.io.done and steps <= 1 << 16:
        sim.clock.tick()
        steps += 1
    assert (steps, sim.io.state) == ((1 << 16) - 1, 0xBEEF)

    sim.io.enable = 0
    sim.clock.tick()
    assert (sim.io.state, sim.io.done) == (0xBEEF, 1)


@pytest.mark.parametrize("width", WIDTHS)
def test_random_control_matches_the_twin(width: int) -> None:
    sim, twin = load("lfsr", {"WIDTH": width}), Lfsr(width)
    rng = np.random.default_rng(width)
    lock_up = (1 << width) - 1
    reset(sim)
    for rst, enable, load_seed, all_ones in rng.random((5000, 4)) < (0.01, 0.8, 0.05, 0.3):
        seed = lock_up if all_ones else int.from_bytes(rng.bytes(8)) & lock_up
        sim.io.rst, sim.io.enable, sim.io.load, sim.io.seed = int(rst), int(enable), int(load_seed), seed
        assert sim.io.seed_error == (load_seed and seed == lock_up)
        sim.clock.tick()
        if rst:
            twin = Lfsr(width)
        elif load_seed:
            with contextlib.suppress(ConfigError):
                twin.load(seed)
        elif enable:
            twin.step()
        assert (sim.io.state, sim.io.done) == (twin.state, twin.done)
        assert sim.io.state != lock_up

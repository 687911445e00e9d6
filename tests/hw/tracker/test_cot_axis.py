# SPDX-License-Identifier: Apache-2.0
"""cot_axis.v: the steps of an average and of a centre, the window around the centre, and what lies outside the ring."""

from __future__ import annotations

import numpy as np
import pytest
from pyverilator import PyVerilator

from evcot.hardware import _cot_kernel as kernel
from evcot_cosim.rtl.build import load
from support.testing import lint

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


@pytest.mark.parametrize(("w", "frac", "radix_w"), [(1, 0, 1), (9, 4, 8), (16, 8, 12)])
def test_lints_clean(w: int, frac: int, radix_w: int) -> None:
    assert lint("cot_axis", W=w, FRAC=frac, RADIX_W=radix_w) == (0, "")


@pytest.mark.parametrize(
    ("parameters", "rule"),
    [
        ({"W": 0}, "W_must_be_1_to_16"),
        ({"W": 17}, "W_must_be_1_to_16"),
        ({"FRAC": 9}, "FRAC_must_be_0_to_8"),
    ],
)
def test_refuses_parameters_out_of_range(parameters: dict[str, int], rule: str) -> None:
    code, log = lint("cot_axis", **parameters)
    assert code != 0
    assert rule in log

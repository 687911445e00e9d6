# SPDX-License-Identifier: Apache-2.0
"""lfsr.v against its twin: full periods, seeds, the refused seed."""

from __future__ import annotations

import contextlib
import math

import numpy as np
import pytest

from evcot.errors import ConfigError
from evcot.hardware.lfsr import TAPS, WIDTH_MAX, WIDTH_MIN, Lfsr
from evcot_cosim.devices.base import reset
from evcot_cosim.rtl.build import load

WIDTHS = [2, 16, 64]


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


def prime_factors(number: int) -> set[int]:
    """All primes that divide a number: trial division, then Pollard's rho with Brent's polynomial for what is left."""
    found: set[int] = set()
    for prime in range(2, 10_000):
        while number % prime == 0:
            found.add(prime)
            number //= prime
    left = [number] if number > 1 else []
    while left:
        rest = left.pop()
        if all(pow(base, rest - 1, rest) == 1 for base in (2, 3, 5, 7)):
            found.add(rest)
            continue
        for constant in range(1, 20):
            slow = fast = 2
            divisor = 1
            while divisor == 1:
                slow = (slow * slow + constant) % rest
                fast = ((fast * fast + constant) ** 2 + constant) % rest
                divisor = math.gcd(slow - fast, rest)
            if divisor != rest:
                left += [divisor, rest // divisor]
                break
    return found


def power_of_x(exponent: int, polynomial: int, width: int) -> int:
    """x to a power, modulo a polynomial over two elements."""
    result = 1
    for bit in bin(exponent)[2:]:
        square = 0
        for i in range(width):
            square |= (result >> i & 1) << (2 * i)
        square <<= int(bit)
        for i in range(square.bit_length() - 1, width - 1, -1):
            if square >> i & 1:
                square ^= polynomial << (i - width)
        result = square
    return result


@pytest.mark.parametrize("width", range(WIDTH_MIN, WIDTH_MAX + 1))
def test_every_polynomial_is_primitive(width: int) -> None:
    """The order of x is 2^width - 1, so that the register has all states but one in one cycle; `make prove` shows its step."""
    polynomial = (1 << width) | sum(1 << (width - tap) for tap in TAPS[width])
    period = (1 << width) - 1
    factors = prime_factors(period)
    rest = period
    for prime in factors:
        while rest % prime == 0:
            rest //= prime
    assert rest == 1
    assert power_of_x(period, polynomial, width) == 1
    assert all(power_of_x(period // prime, polynomial, width) != 1 for prime in factors)

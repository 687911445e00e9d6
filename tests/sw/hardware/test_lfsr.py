# SPDX-License-Identifier: Apache-2.0
"""Every width of the tap table gives the maximal period, and the model steps through it."""

from __future__ import annotations

import numpy as np
import pytest

from evcot.errors import ConfigError
from evcot.hardware.lfsr import TAPS, WIDTH_MAX, WIDTH_MIN, Lfsr, tap_mask

# Every prime that divides 2^n - 1 for some n from 2 to 64.
# fmt: off
PRIMES = (
    3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53, 59, 61, 71, 73, 79, 89, 97, 103, 109, 113, 127, 151, 157, 223, 233,
    241, 251, 257, 331, 337, 397, 431, 601, 631, 641, 673, 683, 881, 1103, 1321, 1613, 1801, 2089, 2113, 2143, 2351, 2731, 3191,
    4051, 4513, 5419, 6361, 8191, 9719, 11119, 13367, 23311, 32377, 43691, 61681, 65537, 69431, 87211, 92737, 121369, 122921,
    131071, 174763, 178481, 179951, 201961, 262657, 524287, 599479, 649657, 1212847, 2099863, 2796203, 3033169, 6700417,
    13264529, 15790321, 20394401, 164511353, 616318177, 715827883, 2147483647, 3203431780337, 4432676798593,
    2305843009213693951,
)
# fmt: on


def is_prime(n: int) -> bool:
    """Miller-Rabin with the bases that decide every n below 3.3e24 (Sorenson and Webster, 2015)."""
    twos = (n - 1 & 1 - n).bit_length() - 1
    for base in (2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41):
        powers = [pow(base, (n - 1) >> k, n) for k in range(twos + 1)]
        if n % base and powers[-1] != 1 and n - 1 not in powers[1:]:
            return False
    return True


def power_of_x(exponent: int, polynomial: int) -> int:
    """x^exponent modulo a polynomial over GF(2); bit i of a number is the coefficient of x^i."""
    degree = polynomial.bit_length() - 1
    result = 1
    for bit in bin(exponent)[2:]:
        square = sum(1 << 2 * i for i in range(degree) if result >> i & 1) << int(bit)
        for i in range(square.bit_length() - 1, degree - 1, -1):
            if square >> i & 1:
                square ^= polynomial << (i - degree)
        result = square
    return result


def test_the_listed_primes_are_prime() -> None:
    assert all(is_prime(p) for p in PRIMES)
    assert not any(is_prime(n) for n in (9, 341, 2047, 3215031751, 2147483647 * 65537))


@pytest.mark.parametrize("width", range(2, 65))
def test_the_feedback_polynomial_is_primitive(width: int) -> None:
    """x has order 2^n - 1: its power of that is 1, and that divided by any of its prime factors is not enough."""
    order = (1 << width) - 1
    factors = [p for p in PRIMES if order % p == 0]
    rest = order
    for p in factors:
        while rest % p == 0:
            rest //= p
    assert rest == 1
    polynomial = 1 + sum(1 << tap for tap in TAPS[width])
    assert power_of_x(order, polynomial) == 1
    assert all(power_of_x(order // p, polynomial) != 1 for p in factors)


@pytest.mark.parametrize("width", range(2, 65))
def test_an_even_number_of_taps_keeps_all_ones_locked_up(width: int) -> None:
    assert TAPS[width][0] == width
    assert len(TAPS[width]) in (2, 4)


@pytest.mark.parametrize("width", range(2, 21))
def test_a_period_visits_every_state_but_all_ones(width: int) -> None:
    lfsr = Lfsr(width)
    states = lfsr.states(lfsr.period)
    assert np.array_equal(np.sort(states), np.arange((1 << width) - 1))
    assert (lfsr.state, lfsr.done) == (0, True)


@pytest.mark.parametrize("width", [2, 3, 8, 33, 64])
def test_blocks_steps_and_bits_agree(width: int) -> None:
    seed = 1 << (width - 1)
    block, stepped, bits = Lfsr(width, seed), Lfsr(width, seed), Lfsr(width, seed)
    states = [*block.states(100).tolist(), *block.states(0).tolist(), *block.states(100).tolist()]
    assert states == [stepped.step() for _ in range(200)]
    assert bits.bits(200).tolist() == [state & 1 for state in states]
    assert block.state == stepped.state == bits.state == states[-1]


def test_three_bits_by_hand() -> None:
    """Taps 3 and 2: the new bit is 1 where bits 2 and 1 of the state are equal."""
    lfsr = Lfsr(3)
    assert [lfsr.step() for _ in range(7)] == [0b001, 0b011, 0b110, 0b101, 0b010, 0b100, 0b000]


def test_done_marks_the_return_to_the_seed() -> None:
    lfsr = Lfsr(5, seed=9)
    assert not lfsr.done
    assert [step for step in range(1, 100) if lfsr.step() == 9 and lfsr.done] == [31, 62, 93]
    lfsr.load(3)
    assert (lfsr.state, lfsr.done) == (3, False)


@pytest.mark.parametrize("seed", [-1, 31, 32])
def test_refuses_a_seed_that_locks_up_or_does_not_fit(seed: int) -> None:
    lfsr = Lfsr(5, seed=9)
    with pytest.raises(
        ConfigError, match=rf"^lfsr.seed = {seed:#x}: must be from 0 to 0x1e for width 5; all ones would never change$"
    ):
        lfsr.load(seed)
    assert (lfsr.state, lfsr.start) == (9, 9)


@pytest.mark.parametrize("width", [WIDTH_MIN - 1, WIDTH_MAX + 1])
def test_refuses_a_width_without_taps(width: int) -> None:
    with pytest.raises(ConfigError, match=f"^lfsr.width = {width}: must be an integer from 2 to 64$"):
        tap_mask(width)

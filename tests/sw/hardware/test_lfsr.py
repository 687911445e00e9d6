# SPDX-License-Identifier: Apache-2.0
"""Shift registers with feedback, the source of events that one drives, and the flip-flop."""

from __future__ import annotations

import numpy as np
import pytest

from evcot.errors import ConfigError
from evcot.hardware.lfsr import TAPS, WIDTH_MAX, WIDTH_MIN, Lfsr, tap_mask
from evcot.hardware.lfsr_event_source import LfsrEventSource

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


def test_candidates_are_slices_of_the_state() -> None:
    source = LfsrEventSource(0, 511, 0, 511, gap=2, seed=77)
    states = Lfsr(32, seed=77).states(300)[1::3]  # after 2, 5, 8 … steps
    events = source.events(100)
    assert events.t_us.tolist() == list(range(2, 302, 3))
    assert np.array_equal(events.x, states & 511)
    assert np.array_equal(events.y, states >> 9 & 511)
    assert np.array_equal(events.p, states >> 18 & 1)


def test_events_are_uniform_over_an_odd_window() -> None:
    events = LfsrEventSource(10, 18, 300, 6, gap=18, seed=5).events(19 * 7 * 1000)
    pixels = np.bincount((events.y.astype(int) - 300) * 19 + events.x - 10, minlength=19 * 7)
    assert pixels.size == 19 * 7
    # Chi squared with 132 degrees of freedom: mean 132, standard deviation 16.
    assert 80 < np.sum((pixels - 1000.0) ** 2) / 1000 < 190
    assert abs(events.p.mean() - 0.5) < 0.005
    neighbours = np.corrcoef(events.x[:-1], events.x[1:])[0, 1]
    assert abs(neighbours) < 0.01


def test_candidates_outside_the_window_are_dropped() -> None:
    """A span of 4 needs three bits, of whose eight values five are inside: 5/8 per axis."""
    events = LfsrEventSource(0, 4, 0, 4, gap=18, seed=5).events(50_000)
    accepted = len(events) / (events.t_us[-1] / 19)
    assert accepted == pytest.approx(25 / 64, rel=0.02)


def test_the_start_of_a_sequence_does_not_depend_on_its_length() -> None:
    source = LfsrEventSource(3, 9, 4, 11, seed=123)
    long, short = source.events(1000), source.events(10)
    assert np.array_equal(long[:10].x, short.x)
    assert np.array_equal(long[:10].t_us, short.t_us)
    assert len(source.events(0)) == 0


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("x_w", 0, "x_w = 0: must be at least 1"),
        ("y_w", 0, "y_w = 0: must be at least 1"),
        ("gap_w", 0, "gap_w = 0: must be at least 1"),
        ("lfsr_w", 18, "lfsr_w = 18: must be from x_w + y_w + 1 = 19 to 64"),
        ("lfsr_w", 65, "lfsr_w = 65: must be from x_w + y_w + 1 = 19 to 64"),
        ("seed", 2**32 - 1, "seed = 0xffffffff: must be from 0 to 0xfffffffe"),
        ("gap", 65536, "gap = 65536: must be from 0 to 65535"),
        ("gap", -1, "gap = -1: must be from 0 to 65535"),
        ("x_min", 503, "x_min, x_span = 503, 9: must not be negative, and their sum must be below 512"),
        ("y_span", -1, "y_min, y_span = 0, -1: must not be negative, and their sum must be below 512"),
    ],
)
def test_refuses(field: str, value: int, message: str) -> None:
    legal = {"x_min": 0, "x_span": 9, "y_min": 0, "y_span": 9}
    with pytest.raises(ConfigError) as error:
        LfsrEventSource(**(legal | {field: value}))
    assert message in str(error.value)


def test_says_when_no_event_ever_comes() -> None:
    """A gap of one period less one reads the same state for ever: here one outside the window."""
    outside = next(seed for seed in range(15) if Lfsr(4, seed).states(14)[-1] & 3 == 3)
    with pytest.raises(ConfigError, match="gap = 14: no event in a whole period of the 4-bit LFSR"):
        LfsrEventSource(0, 2, 0, 0, gap=14, seed=outside, x_w=2, y_w=1, lfsr_w=4).events(1)

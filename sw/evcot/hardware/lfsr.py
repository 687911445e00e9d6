# SPDX-License-Identifier: Apache-2.0
"""Linear feedback shift registers of maximal length: the tap table and the cycle-exact model of `lfsr.v`.

The register shifts towards its high end and the XNOR of its taps enters at bit 0. With XNOR, all zeros is a legal start; the
only state that maps to itself is all ones, which is not a legal seed. All other states lie on one cycle of 2^width - 1 states,
because 1 + sum(x^tap) is primitive over GF(2) (Golomb, Shift Register Sequences, 1967) and the number of taps is even.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .._numba_private import njit, step
from ..errors import ConfigError
from ..ranges import check_integer

__all__ = ["TAPS", "WIDTH_MAX", "WIDTH_MIN", "Lfsr", "next_state", "tap_mask"]

# width -> taps, counted from 1; tap t feeds back the bit that entered t shifts ago. Of the primitive polynomials with the
# fewest terms this is the one with the highest inner taps. `hw/verilog/math/lfsr_taps.vh` is generated from it.
TAPS: dict[int, tuple[int, ...]] = {
    2: (2, 1),
    3: (3, 2),
    4: (4, 3),
    5: (5, 3),
    6: (6, 5),
    7: (7, 6),
    8: (8, 7, 6, 1),
    9: (9, 5),
    10: (10, 7),
    11: (11, 9),
    12: (12, 11, 10, 4),
    13: (13, 12, 11, 8),
    14: (14, 13, 12, 2),
    15: (15, 14),
    16: (16, 15, 13, 4),
    17: (17, 14),
    18: (18, 11),
    19: (19, 18, 17, 14),
    20: (20, 17),
    21: (21, 19),
    22: (22, 21),
    23: (23, 18),
    24: (24, 23, 22, 17),
    25: (25, 22),
    26: (26, 25, 24, 20),
    27: (27, 26, 25, 22),
    28: (28, 25),
    29: (29, 27),
    30: (30, 29, 28, 7),
    31: (31, 28),
    32: (32, 31, 30, 10),
    33: (33, 20),
    34: (34, 33, 32, 7),
    35: (35, 33),
    36: (36, 25),
    37: (37, 36, 35, 28),
    38: (38, 37, 35, 25),
    39: (39, 35),
    40: (40, 39, 38, 5),
    41: (41, 38),
    42: (42, 41, 40, 13),
    43: (43, 42, 41, 31),
    44: (44, 43, 41, 6),
    45: (45, 44, 42, 41),
    46: (46, 45, 43, 37),
    47: (47, 42),
    48: (48, 47, 45, 20),
    49: (49, 40),
    50: (50, 49, 48, 34),
    51: (51, 50, 49, 23),
    52: (52, 49),
    53: (53, 52, 51, 47),
    54: (54, 53, 52, 37),
    55: (55, 31),
    56: (56, 55, 54, 14),
    57: (57, 50),
    58: (58, 39),
    59: (59, 58, 57, 35),
    60: (60, 59),
    61: (61, 60, 59, 56),
    62: (62, 61, 59, 34),
    63: (63, 62),
    64: (64, 63, 62, 53),
}

WIDTH_MIN = min(TAPS)
WIDTH_MAX = max(TAPS)


def tap_mask(width: int) -> int:
    """Returns the taps of `width` as a bit mask over the state: tap t is bit t - 1.

    Raises:
        ConfigError: the width is not supported.
    """
    check_integer("lfsr.width", width, WIDTH_MIN, WIDTH_MAX)
    return sum(1 << (tap - 1) for tap in TAPS[width])


@step
def next_state(state: np.uint64, taps: np.uint64, keep: np.uint64) -> np.uint64:
    """One step of the register: `taps` is its `tap_mask`, `keep` the mask of its bits."""
    parity = state & taps
    for shift in (32, 16, 8, 4, 2, 1):
        parity ^= parity >> np.uint64(shift)
    return ((state << np.uint64(1)) | (~parity & np.uint64(1))) & keep


@njit(cache=True, nogil=True)
def _run(state: np.uint64, taps: np.uint64, keep: np.uint64, states: NDArray[np.uint64]) -> None:
    """Fills `states` with the states that follow `state`."""
    for i in range(states.size):
        state = next_state(state, taps, keep)
        states[i] = state


class Lfsr:
    """Cycle-exact model of `lfsr.v`, clocked by `step` with `enable` high.

    Attributes:
        width: bits of the register, WIDTH_MIN..WIDTH_MAX.
        state: the register; bit 0 is the newest bit.
        start: the state at which `done` is set: zero, or the seed loaded last.
        done: whether the last step returned the register to `start`, after a full period.

    Raises:
        ConfigError: the width is not supported, or the seed does not fit or is all ones.
    """

    def __init__(self, width: int, seed: int = 0) -> None:
        self._taps = tap_mask(width)
        self.width = width
        self.load(seed)

    @property
    def period(self) -> int:
        """Steps from a state to its next occurrence: 2^width - 1, also the mask of the register's bits."""
        return (1 << self.width) - 1

    def load(self, seed: int) -> None:
        """Makes `seed` the state and the start of the period.

        Raises:
            ConfigError: `seed` does not fit into the register, or is all ones. The state is unchanged.
        """
        lock_up = self.period
        if not 0 <= seed < lock_up:
            raise ConfigError(
                f"lfsr.seed = {seed:#x}: must be from 0 to {lock_up - 1:#x} for width {self.width}; all ones would never change"
            )
        self.state = self.start = seed
        self.done = False

    def step(self) -> int:
        """One clock; returns the new state."""
        feedback = ~(self.state & self._taps).bit_count() & 1
        self.state = ((self.state << 1) | feedback) & self.period
        self.done = self.state == self.start
        return self.state

    def states(self, count: int) -> NDArray[np.uint64]:
        """Steps `count` times; returns the state after each step, shape (count,)."""
        states = np.empty(count, np.uint64)
        _run(np.uint64(self.state), np.uint64(self._taps), np.uint64(self.period), states)
        if count:
            self.state = int(states[-1])
            self.done = self.state == self.start
        return states

    def bits(self, count: int) -> NDArray[np.uint8]:
        """Steps `count` times; returns the bit that entered at each step, shape (count,), 0 or 1."""
        return (self.states(count) & np.uint64(1)).astype(np.uint8)

# SPDX-License-Identifier: Apache-2.0
"""Cycle-exact model of `dff.v`, the D flip-flop."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Dff"]


@dataclass
class Dff:
    """One flip-flop, clocked by `step`.

    Attributes:
        reset_to_complement: False: reset clears q. True, as published: while in reset q follows the complement of d.
        q: the output; powers up False.
    """

    reset_to_complement: bool = False
    q: bool = False

    def step(self, d: bool, rst: bool = False) -> bool:
        """One rising clock edge; returns the new output."""
        self.q = (self.reset_to_complement and not d) if rst else d
        return self.q

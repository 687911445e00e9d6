# SPDX-License-Identifier: Apache-2.0
"""A trained classifier into hardware: weights over the bus, read back and compared, then the registers."""

from __future__ import annotations

from dataclasses import asdict

from ..errors import ConfigError
from ..hardware.classifier import VERSION
from ..hardware.register_access import Registers
from .weight_memory import memory_words
from .weights import Weights

__all__ = ["load"]


def load(registers: Registers, weights: Weights) -> None:
    """Load weights and registers, and commit `enable` = 1: all windows and votes begin anew.

    Args:
        registers: of an `evcot_top` with CLASSIFY = 1, on any transport.

    Raises:
        ConfigError: hardware without a classifier, with one of another version or size, or that does not hold what was written.
            Then the classifier is off.
    """
    bank = registers.classifier
    version = registers.build.classifier
    if version != VERSION:
        raise ConfigError(f"the hardware has version {version} of the classifier: must be {VERSION}, that of the weights")
    words = memory_words(weights.network).tolist()
    if registers.weights.needed != len(words):
        raise ConfigError(f"the hardware has {registers.weights.needed} words of weights: must be {len(words)}")
    bank.enable = 0
    _commit(registers)
    registers.weight_address = 0
    for word in words:
        registers.weight_data = word
    for address, word in enumerate(words):
        registers.weight_address = address
        if (found := registers.weight_data) != word:
            raise ConfigError(f"weight {address}: the hardware holds {found:#x}: must be {word:#x}, which was written")
    for name, value in asdict(weights.registers).items():
        setattr(bank, name, value)
    bank.enable = 1
    _commit(registers)


def _commit(registers: Registers) -> None:
    """Commit the bank of the classifier and wait until it has taken effect; outputs must be accepted meanwhile."""
    registers.classifier.commit()
    while registers.status.pending:
        pass

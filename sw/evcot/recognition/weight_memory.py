# SPDX-License-Identifier: Apache-2.0
"""The weights as the words of the classifier's memory: rows of four words (docs/recognition.md)."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
from numpy.typing import NDArray

from ..hardware.classifier import CELLS, WEIGHT_BANKS, WEIGHT_ROWS, RecognitionRegisters
from .model import Network

__all__ = ["BANKS", "BANK_BITS", "REGISTER_ADDRESSES", "ROWS", "memory_words"]

BANKS, ROWS = WEIGHT_BANKS, WEIGHT_ROWS
BANK_BITS = 18
_LANES = 8  # weights of a row, for as many cells
_WORDS = CELLS**2 // _LANES  # rows of a unit
_MOMENTS = 5
_NINTH_FIRST = 8  # row, of those of the next unit, with a unit's first weight of the second layer

REGISTER_ADDRESSES = {name: at for at, name in enumerate(("enable", *(each.name for each in fields(RecognitionRegisters))))}


def _cells() -> NDArray[np.int64]:
    """The cell of each lane, word by word: columns 0 to 7 of each row, then columns 8 to 11 of two rows at a time."""
    cells = np.arange(CELLS**2).reshape(CELLS, CELLS)
    return np.concatenate((cells[:, :_LANES].ravel(), cells[:, _LANES:].ravel()))


def memory_words(network: Network) -> NDArray[np.uint32]:
    """All words, (ROWS * BANKS,): word 4 r + b is that of row r and bank b."""
    half_cells = 2 * np.arange(CELLS) - CELLS + 1
    v, u = np.repeat(half_cells, CELLS), np.tile(half_cells, CELLS)
    moments = np.stack((u, 9 - 2 * abs(u), v, 9 - 2 * abs(v), np.where(v > 0, u, -u)))
    units = np.concatenate((moments, network.w1.T.astype(np.int64)))[:, _cells()]
    lanes = np.zeros((ROWS, _LANES + 1), np.int64)
    lanes[: units.size // _LANES, :_LANES] = units.reshape(-1, _LANES)
    for j, weights in enumerate(network.w2):
        begin = (_MOMENTS + j + 1) * _WORDS + _NINTH_FIRST
        lanes[begin : begin + len(weights), _LANES] = weights
    lanes &= 255
    bank = np.arange(BANKS)
    words = lanes[:, 2 * bank] | lanes[:, 2 * bank + 1] << 8 | (lanes[:, _LANES, None] >> 2 * bank & 3) << 16
    return words.astype(np.uint32).ravel()

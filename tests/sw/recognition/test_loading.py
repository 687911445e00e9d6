# SPDX-License-Identifier: Apache-2.0
"""Weights into hardware: what is written, and what is refused in one line. tests/hw/bus loads simulated hardware."""

from __future__ import annotations

from dataclasses import asdict

import numpy as np
import pytest

from evcot.errors import ConfigError
from evcot.hardware.classifier import CELLS, CLASSIFIER_REGISTERS, HIDDEN, VERSION, RecognitionRegisters
from evcot.hardware.register_access import Registers
from evcot.hardware.registers import register_map
from evcot.recognition.loading import load
from evcot.recognition.model import Network
from evcot.recognition.weight_memory import BANKS, ROWS, memory_words
from evcot.recognition.weights import Weights
from support.refusals import refused

WORDS = ROWS * BANKS


def address(name: str) -> int:
    return register_map().word(name).address


class Hardware:
    """A transport: registers that stay as written, and the memory of the weights."""

    def __init__(self, version: int = VERSION, needed: int = WORDS, damaged: int = -1) -> None:
        self.words = {
            address("id"): register_map().id, address("version"): register_map().version[0] << 16,
            address("build"): version << 20 | 2 << 16, address("weights"): needed << 16,
            address("sensor"): 0x00FF_00FF, address("memory"): 15 << 8 | 12,
            address("shape0"): 1 | 4 << 8 | 9 << 16 | 9 << 24, address("shape1"): 20 | 8 << 8 | 10 << 16 | 24 << 24,
            address("shape2"): 16 | 32 << 8 | 48 << 16 | 48 << 24,
        }  # fmt: skip
        self.weights = np.zeros(WORDS, np.int64)
        self.damaged = damaged
        self.commits: list[int] = []  # `enable` at each commit of the classifier

    def read(self, place: int) -> int:
        if place == address("weight_data"):
            at = self.words[address("weight_address")]
            return int(self.weights[at]) ^ (at == self.damaged)
        return self.words.get(place, 0)

    def write(self, place: int, value: int) -> None:
        bank = register_map().banks["classifier"]
        if place == address("weight_data"):
            self.weights[self.words[address("weight_address")]] = value
            self.words[address("weight_address")] += 1
        elif place == bank.base + 4 * bank.commit:
            self.commits.append(self.words[bank.base + 4 * bank.registers["enable"].address])
        else:
            self.words[place] = value


@pytest.fixture
def weights() -> Weights:
    rng = np.random.default_rng(5)
    w1, w2 = (rng.integers(-128, 128, shape).astype(np.int8) for shape in ((CELLS**2, HIDDEN), (HIDDEN, 3)))
    return Weights(Network(w1, w2), RecognitionRegisters(9, 77, 3, 5, 3, 6), (4, 0, 9))


def test_words_are_loaded_while_it_is_off_and_registers_follow(weights: Weights) -> None:
    hardware = Hardware()
    load(Registers(hardware), weights)
    assert np.array_equal(hardware.weights, memory_words(weights.network))
    assert hardware.commits == [0, 1]
    bank = register_map().banks["classifier"]
    for name, value in (asdict(weights.registers) | {"enable": 1}).items():
        assert hardware.words[bank.base + 4 * CLASSIFIER_REGISTERS[name].address] == value


def test_the_map_has_as_many_words_as_the_memory() -> None:
    (field,) = register_map().word("weight_address").fields
    assert field.high == WORDS - 1


@pytest.mark.parametrize(
    ("hardware", "said"),
    [
        (Hardware(version=2), "the hardware has version 2 of the classifier: must be 1, that of the weights"),
        (Hardware(needed=99), "the hardware has 99 words of weights: must be 2736"),
        (
            Hardware(version=0),
            "the hardware has no registers classifier: it was built with CLASSIFY = 0; CLASSIFY = 1 builds the classifier",
        ),
    ],
)
def test_other_hardware_is_refused_before_anything_is_written(weights: Weights, hardware: Hardware, said: str) -> None:
    with refused(ConfigError, said):
        load(Registers(hardware), weights)
    assert hardware.commits == []
    assert not hardware.weights.any()


def test_a_word_that_reads_back_differently_leaves_the_classifier_off(weights: Weights) -> None:
    hardware = Hardware(damaged=700)
    word = int(memory_words(weights.network)[700])
    with refused(ConfigError, f"weight 700: the hardware holds {word ^ 1:#x}: must be {word:#x}, which was written"):
        load(Registers(hardware), weights)
    assert hardware.commits == [0]

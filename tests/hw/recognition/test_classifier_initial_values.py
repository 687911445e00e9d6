# SPDX-License-Identifier: Apache-2.0
"""classifier.v in Icarus, from X: no output has an X, and the verdicts are those of the golden model."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from evcot.hardware.classifier import SERVICE_EVENTS, RecognitionRegisters
from evcot.recognition.weight_memory import REGISTER_ADDRESSES, memory_words
from support.classifier_trials import VERDICT_FIELDS, candidate, joined, model_verdicts, object_events, random_network
from support.four_state import needs_icarus, replay

WINDOW = 256
REGISTERS = RecognitionRegisters(window_log2=8, scale_start=200, shift_1=3, shift_2=6)
GIVEN = np.dtype(
    [
        ("rst", "u1"), ("cfg_valid", "u1"), ("cfg_addr", "u1"), ("cfg_data", "u2"),
        ("weight_valid", "u1"), ("weight_address", "u2"), ("weight_data", "u4"),
        ("s_valid", "u1"), ("s_slot", "u1"), ("s_dx", "u2"), ("s_dy", "u2"), ("s_visible", "u1"),
        ("s_id", "u2"), ("s_seq", "u4"), ("m_ready", "u1"),
    ]
)  # fmt: skip
READ = np.dtype(
    [
        ("cfg_ready", "u1"), ("weight_ready", "u1"), ("s_ready", "u1"), ("m_valid", "u1"), ("lost", "u1"), ("idle", "u1"),
        ("m_slot", "u1"), ("m_id", "u2"), ("m_seq", "u4"), ("m_class", "u1"), ("m_margin", "u2"), ("m_windows", "u1"),
    ]
)  # fmt: skip
HANDSHAKES = ("cfg_ready", "weight_ready", "s_ready", "m_valid", "lost", "idle")


def blocks(*parts: NDArray[np.void]) -> NDArray[np.void]:
    rows = np.concatenate(parts)
    rows["m_ready"] = 1
    return rows


@needs_icarus
def test_verdicts_do_not_depend_on_initial_values(tmp_path: Path) -> None:
    rng = np.random.default_rng(20311)
    network = random_network(rng)
    words = memory_words(network)
    track = [object_events(rng, slot, WINDOW, 40) for slot in (0, 3, 0, 3, 0)]
    events = joined([one for part in track for one in (part, candidate(1, SERVICE_EVENTS))])
    reset, idle = np.zeros(3, GIVEN), np.zeros(900, GIVEN)
    reset["rst"] = 1
    weights = np.zeros(len(words), GIVEN)
    weights["weight_valid"], weights["weight_address"], weights["weight_data"] = 1, np.arange(len(words)), words
    writes = [("window_log2", 8), ("scale_start", 200), ("shift_1", 3), ("shift_2", 6), ("enable", 1)]
    cfg = np.zeros(len(writes), GIVEN)
    cfg["cfg_valid"], cfg["cfg_addr"], cfg["cfg_data"] = (
        1,
        [REGISTER_ADDRESSES[name] for name, _ in writes],
        [v for _, v in writes],
    )
    tokens = np.zeros(len(events.slot), GIVEN)
    tokens["s_valid"], tokens["s_slot"], tokens["s_visible"], tokens["s_id"] = 1, events.slot, events.visible, events.id
    tokens["s_dx"], tokens["s_dy"], tokens["s_seq"] = events.dx & 1023, events.dy & 1023, np.arange(len(events.slot))
    inputs = blocks(reset, weights, cfg, tokens, idle)
    found = replay(tmp_path, "classifier", {}, inputs, READ)
    given = []
    for clock, told in enumerate(found[2:], 2):
        for name in (*HANDSHAKES, *(f"m_{field}" for field in VERDICT_FIELDS)) if told["m_valid"][-1] == "1" else HANDSHAKES:
            bits = told[name][-1:] if name in HANDSHAKES else told[name].replace("z", "")
            assert set(bits) <= set("01"), (clock, name, told[name])
        if told["m_valid"][-1] == "1":
            given.append([int(told[f"m_{field}"].replace("z", "0"), 2) for field in VERDICT_FIELDS])
    wanted = model_verdicts(REGISTERS, network, events)
    assert len(wanted) == 3
    assert given == wanted.tolist()

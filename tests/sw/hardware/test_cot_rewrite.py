# SPDX-License-Identifier: Apache-2.0
"""Registers of the golden model change between two events, while a life continues."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from evcot.errors import ConfigError
from evcot.hardware.config import CotConfig, SlotConfig
from evcot.hardware.contract import Mode, Shape
from evcot.hardware.cot import CotModel
from evcot.hardware.model import Decisions
from evcot.hardware.modules import Module
from evcot.tracks.log import Kind
from support.tokens import ticked

SHAPE = Shape(n_slots=2, x_w=7, y_w=7)
SLOT = SlotConfig(
    init_radix=6, radix_th=2, radix_step=1, radix_min=4, radix_max=8, hist_avg=1, max_ticks=1_000,
    clust_nev=1, nev_min=1, nev_max=1, detect_ticks=100,
)  # fmt: skip


def model_of(module: Module = "cot_array") -> CotModel:
    return CotModel(CotConfig.uniform(SHAPE, SLOT, module=module))


def feed(model: CotModel, *events: tuple[int, int]) -> Decisions:
    ticks, x = np.array(events, np.int64).T
    return model.feed(ticked(ticks, x, 20))


def test_a_life_goes_on_with_the_new_values() -> None:
    model = model_of()
    feed(model, (0, 20))
    assert len(model.write_registers(0, replace(SLOT, radix_max=12, radix_step=4), restart=False)) == 0
    record = feed(model, (1, 27)).records[0]
    assert (Kind(record["kind"]), record["track_id"]) == (Kind.MOVED, 0)
    assert record["radius"] == 5 + 4 + 2  # born with g = 6 less the step of 1; the ring was marked: 4 more


def test_mode_restarts_a_slot_and_a_life_that_was_there_is_lost_now() -> None:
    model = model_of()
    feed(model, (0, 20), (5, 21))
    lost = model.write_registers(0, replace(SLOT, mode=Mode.OFF), restart=True)
    assert [(Kind(row["kind"]), int(row["seq"]), int(row["time"])) for row in lost] == [(Kind.LOST, 2, 5)]
    assert feed(model, (6, 21)).owner.tolist() == [1]  # the other slot


def test_without_a_restart_mode_stays() -> None:
    model = model_of()
    model.write_registers(0, replace(SLOT, mode=Mode.OFF), restart=False)
    assert feed(model, (0, 20)).owner.tolist() == [0]


def test_a_deadline_that_is_set_stays_in_an_array_and_moves_in_a_chain() -> None:
    stories: tuple[tuple[Module, int], ...] = (("cot_array", 1_000), ("cot_chain", 30))
    for module, lost_at in stories:
        model = model_of(module)
        feed(model, (0, 20))
        model.write_registers(0, replace(SLOT, max_ticks=30), restart=False)
        records = feed(model, (900, 90), (2_000, 20)).records
        assert records["time"][records["kind"] == Kind.LOST].tolist()[0] == lost_at


def test_where_a_life_starts_is_loaded_when_the_one_before_ends() -> None:
    model = model_of()
    model.write_registers(0, replace(SLOT, init_radix=4, radix_min=4), restart=False)
    first = feed(model, (0, 20)).records[0]
    second = feed(model, (5_000, 20)).records
    assert first["radius"] == 5 + 2  # INIT_CELL was before the change
    assert second["radius"][second["kind"] == Kind.BORN].tolist() == [4 + 2]


def test_refuses_what_the_register_cannot_hold() -> None:
    with pytest.raises(ConfigError, match=r"slot\[1\].hist_avg = 9: must be an integer from 0 to 8"):
        model_of().write_registers(1, replace(SLOT, hist_avg=9), restart=False)

# SPDX-License-Identifier: Apache-2.0
"""Random designs are legal and of every kind; random runs of `evcot_top` are exact, and a difference in them is found."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from evcot.hardware.contract import RECORD
from evcot.hardware.cot import CotModel
from evcot.hardware.modules import MODULES
from evcot.hardware.motion.contract import MOTION_RECORD
from evcot.hardware.motion.model import MotionModel
from evcot_cosim.devices.device import build_device
from evcot_cosim.lockstep import top_runs
from evcot_cosim.lockstep.mismatch import MismatchError
from evcot_cosim.lockstep.random_runs import TOP, Design, random_case, run_case
from evcot_cosim.lockstep.top_runs import random_top_run
from support.top import BUILDS

TOPS = ("array behind filters", "chain", "motion")


def design_of(name: str) -> Design:
    build = BUILDS[name]
    enable = build.parameters.get("HAS", 0)
    return Design(build.module, build.shape, enable, build.filter_shape, build.parameters)


def test_designs_are_of_every_kind() -> None:
    print("seed 3")
    for module in (*MODULES, TOP):
        designs = [Design.random(np.random.default_rng([3, number]), module) for number in range(60)]
        assert all(Design.from_tables(design.to_tables()) == design for design in designs)
        assert {design.module for design in designs} == (set(MODULES) - {"cot"} if module == TOP else {module})
        assert all((design.top is not None) == (module == TOP) for design in designs)
        filtered = Counter(design.enable > 0 for design in designs)
        assert filtered[True] == 0 if module == "cot" else min(filtered.values()) > 15
        narrow = min(getattr(design.shape, name) for design in designs for name in ("id_w", "sup_w", "tick_w"))
        assert narrow <= 2, "counters wrap"


def test_a_case_has_events_on_the_sensor_of_its_filters() -> None:
    for number in range(20):
        design = Design.random(np.random.default_rng([4, number]), "cot_array")
        case = random_case(design, number, 500)
        assert len(case.events) == 500
        if design.enable:
            assert case.config.filters.enable == design.enable
            assert case.events.x.max() < design.filter_shape.width
            assert case.events.y.max() < design.filter_shape.height


@pytest.mark.parametrize("name", TOPS)
def test_registers_rewritten_and_a_reset_while_events_flow(name: str) -> None:
    design, records = design_of(name), 0
    for seed in range(4):
        done = random_top_run(design, seed, 2_500)
        assert done.events == 2_500
        assert done.cycles > 2_500
        records += done.records
    assert records > 20


@pytest.mark.parametrize(("name", "model", "record"), [("chain", CotModel, RECORD), ("motion", MotionModel, MOTION_RECORD)])
def test_a_change_that_the_model_does_not_make_is_a_mismatch(
    name: str, model: type[CotModel | MotionModel], record: np.dtype[np.void], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(model, "write_registers", lambda *_, **__: np.empty(0, record))
    different = 0
    for seed in range(4):
        try:
            random_top_run(design_of(name), seed, 2_500)
        except MismatchError:
            different += 1
    assert different > 1


def test_an_event_that_changes_on_its_way_is_a_mismatch(monkeypatch: pytest.MonkeyPatch) -> None:
    right = top_runs.unpack

    def wrong(stream: str, words: np.ndarray) -> np.ndarray:  # type: ignore[type-arg]
        found = right(stream, words)
        found["p"][len(found) // 2 :][:1] ^= 1
        return found

    monkeypatch.setattr(top_runs, "unpack", wrong)
    with pytest.raises(MismatchError, match=r"evcot_top changed p of (owned|passed) event"):
        random_top_run(design_of("chain"), 1, 2_500)


def test_a_case_is_the_same_for_the_same_seed() -> None:
    design = Design("cot_array", BUILDS["array behind filters"].shape)
    case, again = random_case(design, 5, 3_000), random_case(design, 5, 3_000)
    assert case.config == again.config
    assert np.array_equal(case.events.t_us, again.events.t_us)
    built = build_device(case.config, waves=False)
    assert run_case(case, built).records == run_case(again, built).records

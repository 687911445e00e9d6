# SPDX-License-Identifier: Apache-2.0
"""A configuration by what was seen: with motion or without, and the line that says so."""

from __future__ import annotations

from dataclasses import replace

import pytest

from evcot.filters.config import FilterConfig
from evcot.trackers.auto.estimates import Estimates
from evcot.trackers.auto_registers import auto_config, told
from evcot.trackers.presets import AUTO, AUTO_PAPER, PRESETS
from support.scene_estimates import MIXED


@pytest.mark.parametrize(("name", "motion"), [(AUTO, 1), (AUTO_PAPER, 0)])
def test_it_is_a_run_of_the_automatic_tracker_which_needs_no_filters(name: str, motion: int) -> None:
    config = auto_config(MIXED, name)
    assert (config.name, config.software, config.cot.motion.enable) == (name, "auto", motion)
    assert config.in_front_of_software == FilterConfig()
    assert name not in PRESETS


def test_with_motion_unless_another_name_is_given() -> None:
    assert auto_config(MIXED) == auto_config(MIXED, AUTO)


def test_the_line_says_what_runs() -> None:
    seen = replace(MIXED, noise_hz=0.5)
    line = told(seen, auto_config(seen))
    assert line.startswith(str(seen))
    assert line.endswith("-> 16 slots with motion, mask filter, refractory filter, activity filter")
    config = auto_config(MIXED, AUTO_PAPER)
    n_ev = config.cot.slots[0].clust_nev
    line = f"-> 11 slots, radius 28 px, N_ev {n_ev}, lifetime 32 ms, polarity filter, mask filter, refractory filter"
    assert line in told(MIXED, config)


def test_where_no_object_was_seen_the_line_says_what_is_assumed_of_them() -> None:
    seen = Estimates((1280, 720), 20_000, 10, 5.0)
    told_of = {name: told(seen, auto_config(seen, name)) for name in (AUTO, AUTO_PAPER)}
    assert "no object seen for long enough -> 8 slots with motion, refractory" in told_of[AUTO], "nothing depends on objects"
    assert "no object seen for long enough -> preset hd assumed, 8 slots, radius" in told_of[AUTO_PAPER]

# SPDX-License-Identifier: Apache-2.0
"""Named configurations: the paper's numbers, one per sensor size, and fitting to any sensor."""

from __future__ import annotations

import pytest

from evcot.errors import ConfigError
from evcot.hardware.contract import Mode
from evcot.trackers.config import RunConfig
from evcot.trackers.presets import PRESETS, fit, for_sensor, preset


@pytest.mark.parametrize(("name", "n_ev", "tc"), [("slow", 8, 20), ("fast", 3, 7), ("fast5", 5, 7)])
def test_the_papers_situations(name: str, n_ev: int, tc: int) -> None:
    cot = preset(name).cot
    assert {(slot.clust_nev, slot.max_ticks) for slot in cot.slots} == {(n_ev, tc)}
    assert preset(name).rct.lifetime_us == tc * cot.tick_us


@pytest.mark.parametrize("name", PRESETS)
def test_every_preset_can_find_something_and_says_its_name(name: str) -> None:
    run = PRESETS[name]
    assert run.name == name
    for slot in run.cot.slots:
        assert slot.mode == Mode.SEEDED
        assert slot.radix_step > 0  # windows follow the size of what they see
        assert slot.nev_min < slot.clust_nev < slot.nev_max or slot.clust_nev == slot.nev_min


@pytest.mark.parametrize("name", ["traffic", "discs"])
def test_what_was_tuned_stands_for_itself_on_its_sensor(name: str) -> None:
    """Filters and all: no mask of one camera's pixels, nothing that its hardware could not be built with."""
    run = fit(preset(name), 346, 260)
    assert run.filters.hot_pixels == ()
    assert run.filters.enabled
    assert run.hardware(346, 260).filtered


def test_an_unknown_name_lists_the_known_ones() -> None:
    with pytest.raises(ConfigError) as caught:
        preset("quick")
    assert str(caught.value) == f"preset 'quick': must be one of {', '.join(PRESETS)}"


@pytest.mark.parametrize(
    ("width", "name"),
    [
        (1, "dvs128"),
        (128, "dvs128"),
        (129, "davis346"),
        (346, "davis346"),
        (347, "vga"),
        (640, "vga"),
        (641, "hd"),
        (4096, "hd"),
    ],
)
def test_a_sensor_gets_the_first_preset_that_is_wide_enough(width: int, name: str) -> None:
    assert for_sensor(width).name == name


@pytest.mark.parametrize(
    ("width", "height", "x_w", "y_w"), [(1, 1, 1, 1), (2, 3, 1, 2), (128, 128, 7, 7), (129, 256, 8, 8), (1280, 720, 11, 10)]
)
def test_fitted_addresses_are_just_wide_enough(width: int, height: int, x_w: int, y_w: int) -> None:
    shape = fit(preset("hd"), width, height).cot.shape
    assert (shape.x_w, shape.y_w) == (x_w, y_w)


@pytest.mark.parametrize("n", [1, 3, 64])
def test_fitting_changes_the_number_of_slots_and_nothing_else(n: int) -> None:
    base: RunConfig = preset("vga")
    fitted = fit(base, 640, 480, n)
    assert fitted.cot.slots == base.cot.slots[:1] * n
    assert (fitted.name, fitted.rct, fitted.cot.tick_us) == (base.name, base.rct, base.cot.tick_us)
    assert fit(base, 640, 480).cot.slots == base.cot.slots


def test_beside_hardware_with_motion_runs_the_automatic_tracker_without_filters() -> None:
    motion = preset("motion")
    assert motion.software == "auto"
    assert motion.filters.enabled
    assert not motion.in_front_of_software.enabled

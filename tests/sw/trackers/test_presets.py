# SPDX-License-Identifier: Apache-2.0
"""Named configurations: the paper's numbers, one per sensor size, and fitting to any sensor."""

from __future__ import annotations

from dataclasses import replace

import pytest

from evcot.errors import ConfigError
from evcot.hardware.config import CotConfig, MotionConfig
from evcot.hardware.contract import Mode
from evcot.hardware.modules import MODULES, Module
from evcot.trackers.config import RunConfig
from evcot.trackers.presets import MOTION, PRESETS, fit, for_sensor, preset, presets_of, run_config


def slots_of(run: RunConfig) -> CotConfig:
    assert isinstance(run.hardware, CotConfig)
    return run.hardware


@pytest.mark.parametrize(("name", "n_ev", "tc"), [("slow", 8, 20), ("fast", 3, 7), ("fast5", 5, 7)])
def test_the_papers_situations(name: str, n_ev: int, tc: int) -> None:
    cot = slots_of(preset(name))
    assert {(slot.clust_nev, slot.max_ticks) for slot in cot.slots} == {(n_ev, tc)}
    assert preset(name).rct.lifetime_us == tc * cot.tick_us


@pytest.mark.parametrize("name", PRESETS)
def test_every_preset_can_find_something_and_says_its_name(name: str) -> None:
    run = PRESETS[name]
    assert run.name == name
    if isinstance(run.hardware, MotionConfig):
        registers = run.hardware.registers
        assert set(run.hardware.modes) == {Mode.SEEDED}
        assert registers.speed_max > 0  # boxes move
        assert registers.nev_low < registers.nev_high
        return
    for slot in run.hardware.slots:
        assert slot.mode == Mode.SEEDED
        assert slot.radix_step > 0  # windows follow the size of what they see
        assert slot.nev_min < slot.clust_nev < slot.nev_max or slot.clust_nev == slot.nev_min


@pytest.mark.parametrize("name", ["traffic", "discs"])
def test_what_was_tuned_stands_for_itself_on_its_sensor(name: str) -> None:
    """Filters and all: no mask of one camera's pixels, nothing that its hardware could not be built with."""
    run = fit(preset(name), 346, 260)
    assert run.filters.hot_pixels == ()
    assert run.filters.enabled
    assert run.device_config(346, 260).filtered


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
    shape = fit(preset("hd"), width, height).hardware.shape
    assert (shape.x_w, shape.y_w) == (x_w, y_w)


@pytest.mark.parametrize("n", [1, 3, 64])
def test_fitting_changes_the_number_of_slots_and_nothing_else(n: int) -> None:
    base: RunConfig = preset("vga")
    fitted = fit(base, 640, 480, n)
    assert slots_of(fitted).slots == slots_of(base).slots[:1] * n
    assert (fitted.name, fitted.rct, fitted.hardware.tick_us) == (base.name, base.rct, base.hardware.tick_us)
    assert slots_of(fit(base, 640, 480)).slots == slots_of(base).slots


@pytest.mark.parametrize("n", [1, 16, 64])
def test_fitting_cot_motion_changes_its_slots_and_nothing_else(n: int) -> None:
    hardware = MotionConfig(modes=(Mode.OFF, *(Mode.SEEDED,) * 15))
    base = replace(MOTION, hardware=hardware)
    fitted = fit(base, 640, 480, n)
    assert isinstance(fitted.hardware, MotionConfig)
    assert fitted.hardware.modes == (Mode.OFF, *(Mode.SEEDED,) * (n - 1))
    shape = replace(hardware.shape, x_w=10, y_w=9, n_slots=n)
    assert fitted == replace(base, hardware=replace(hardware, shape=shape, modes=fitted.hardware.modes))


def test_beside_cot_motion_runs_the_adaptive_tracker_without_filters() -> None:
    motion = preset("motion")
    assert motion.software == "adaptive"
    assert motion.filters.enabled
    assert not motion.in_front_of_software.enabled


def test_by_default_it_is_the_preset_motion_and_of_another_module_that_of_the_sensor() -> None:
    assert run_config(346, 260) == run_config(346, 260, hardware="cot_motion") == fit(MOTION, 346, 260)
    for module in ("cot_array", "cot_chain", "cot"):
        config = run_config(346, 260, hardware=module)
        assert (config.name, config.hardware.module) == ("davis346", module)
        assert config.hardware.shape.n_slots == (1 if module == "cot" else PRESETS["davis346"].hardware.shape.n_slots)
    assert run_config(346, 260, "traffic", 5, hardware="cot_chain").hardware.module == "cot_chain"
    assert run_config(346, 260, "traffic").hardware.module == "cot_array"


@pytest.mark.parametrize(("name", "hardware"), [("traffic", "cot_motion"), ("motion", "cot_chain")])
def test_a_preset_of_another_module_is_refused(name: str, hardware: str) -> None:
    with pytest.raises(ConfigError, match=rf"^hardware = '{hardware}': these registers are those of .* with preset {name}$"):
        run_config(346, 260, name, hardware=hardware)


@pytest.mark.parametrize("module", MODULES)
def test_the_presets_of_a_module_configure_it(module: Module) -> None:
    for name, run in presets_of(module).items():
        assert (run.name, run.hardware.module) == (name, module)
        assert run.device_config(1280, 720).module == module

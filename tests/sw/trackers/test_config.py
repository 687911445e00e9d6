# SPDX-License-Identifier: Apache-2.0
"""Configurations: limits named in full, what a TOML file may override, and presets: one per sensor size, fit to any sensor."""

from __future__ import annotations

import json
from dataclasses import FrozenInstanceError, replace
from pathlib import Path

import pytest

from evcot.errors import ConfigError
from evcot.filters.config import FilterConfig
from evcot.hardware.config import CotConfig, MotionConfig, SlotConfig, with_module
from evcot.hardware.contract import REGISTERS, Mode, Shape
from evcot.hardware.modules import MODULES, Module
from evcot.hardware.motion.contract import MotionRegisters
from evcot.ranges import span
from evcot.trackers.config import RunConfig, load_toml
from evcot.trackers.presets import MOTION, PRESETS, fit, for_sensor, preset, presets_of, run_config
from evcot.trackers.rct.config import RCT_RANGES, RctConfig
from support.refusals import refused

SHAPE = Shape(n_slots=3, x_w=7, y_w=6, radix_w=5, nev_w=6, tc_w=12)
SLOT = SlotConfig(max_ticks=500, nev_th=50, detect_ticks=200)
# Registers that must lie in order: moving one alone breaks the order before it breaks its limit.
ORDERED = {"init_radix", "radix_min", "radix_max", "clust_nev", "nev_min", "nev_max"}


class TestCot:
    def test_by_default_every_slot_is_the_same(self) -> None:
        config = CotConfig()
        assert config.slots == (SlotConfig(),) * config.shape.n_slots
        config = CotConfig.uniform(SHAPE, SLOT, tick_us=10)
        assert (config.slots, config.tick_us) == ((SLOT,) * 3, 10)
        with pytest.raises(FrozenInstanceError):
            config.tick_us = 2  # type: ignore[misc]
        with refused(ConfigError, "cot.slots has 2 entries: must be shape.n_slots = 3"):
            CotConfig(SHAPE, (SLOT,) * 2)

    @pytest.mark.parametrize("name", [name for name in REGISTERS if name not in ORDERED])
    def test_a_register_takes_its_limits_and_nothing_beyond(self, name: str) -> None:
        low, high = REGISTERS[name].limits(SHAPE)
        for value in (low, high):
            CotConfig.uniform(SHAPE, replace(SLOT, **{name: value}))
        for value in (low - 1, high + 1):
            with pytest.raises(ConfigError) as caught:
                CotConfig(SHAPE, (SLOT, replace(SLOT, **{name: value}), SLOT))
            rule = f"must be an integer from {low} to {high} ({REGISTERS[name].meaning})"
            assert str(caught.value) == f"cot.slot[1].{name} = {value}: {rule}"

    @pytest.mark.parametrize("name", sorted(ORDERED))
    def test_ordered_registers_have_limits_too(self, name: str) -> None:
        for value in (REGISTERS[name].low - 1, 64):
            with pytest.raises(ConfigError, match=rf"cot\.slot\[0\]\.{name} = {value}: must be an integer"):
                CotConfig.uniform(SHAPE, replace(SLOT, **{name: value}))

    @pytest.mark.parametrize(
        ("changed", "message"),
        [
            ({"init_radix": 3}, "init_radix = 3: must lie from radix_min = 4 to radix_max = 16"),
            ({"init_radix": 17}, "init_radix = 17: must lie from radix_min = 4 to radix_max = 16"),
            ({"radix_min": 9}, "init_radix = 8: must lie from radix_min = 9 to radix_max = 16"),
            ({"clust_nev": 7}, "clust_nev = 7: must lie from nev_min = 8 to nev_max = 32"),
            ({"nev_max": 15}, "clust_nev = 16: must lie from nev_min = 8 to nev_max = 15"),
        ],
    )
    def test_initial_values_lie_within_their_bounds_which_may_be_equal(self, changed: dict[str, int], message: str) -> None:
        with refused(ConfigError, f"cot.slot[0].{message}"):
            CotConfig.uniform(SHAPE, replace(SLOT, **changed))
        CotConfig.uniform(SHAPE, replace(SLOT, radix_min=9, init_radix=9, radix_max=9, nev_min=7, clust_nev=7, nev_max=7))

    @pytest.mark.parametrize("tick_us", [0, 1_000_001, 1.5])
    def test_a_tick_has_a_length(self, tick_us: int) -> None:
        with pytest.raises(ConfigError, match=rf"^tick_us = {tick_us}: must be an integer from 1 to 1000000"):
            CotConfig.uniform(SHAPE, SLOT, tick_us=tick_us)


class TestModules:
    def test_the_module_is_one_of_the_contract(self) -> None:
        for module in ("cot_chain", "cot_array"):
            assert CotConfig.uniform(SHAPE, SLOT, module=module).module == module
        for module in ("cot_motion", "cot_aray"):
            with refused(ConfigError, start=f"module = '{module}': must be one of cot, cot_chain, cot_array"):
                CotConfig.uniform(SHAPE, SLOT, module=module)  # type: ignore[arg-type]
        assert MotionConfig(SHAPE).modes == (Mode.SEEDED,) * 3
        for modes, told in (
            ((0, 2), "motion.modes has 2 entries: must be shape.n_slots = 3"),
            ((0, 1, 2), "motion.modes[1] = 1: must be 0 (off) or 2 (seeded)"),
        ):
            with refused(ConfigError, told):
                MotionConfig(SHAPE, modes=modes)

    def test_a_single_tracker_is_one_without_filters(self) -> None:
        with refused(ConfigError, "shape.n_slots = 3: must be 1 for a single tracker"):
            CotConfig(SHAPE, module="cot")
        one = CotConfig(replace(SHAPE, n_slots=1), (SLOT,), module="cot")
        with refused(ConfigError, "a single `cot` has no filters in front: use cot_array with one slot"):
            RunConfig("one", one, filters=FilterConfig(refractory_us=7)).device_config(128, 64)

    def test_registers_stay_with_another_module_of_the_contract(self) -> None:
        config = CotConfig(SHAPE, (replace(SLOT, hist_avg=2), SLOT, SLOT))
        assert with_module(config, "cot_chain") == replace(config, module="cot_chain")
        assert with_module(config, "cot") == CotConfig(replace(SHAPE, n_slots=1), config.slots[:1], module="cot")
        assert with_module(config, "cot_array") is config
        for module, told in (
            ("cot_motion", "these registers are those of cot, cot_chain and"),
            ("cot_aray", "must be one of cot, cot_chain, cot_array, cot_motion"),
        ):
            with refused(ConfigError, start=f"hardware = '{module}': {told}"):
                with_module(config, module)


@pytest.mark.parametrize("name", RCT_RANGES)
def test_rct_takes_its_limits_and_nothing_beyond(name: str) -> None:
    low, high, meaning = RCT_RANGES[name]
    for value in (low, high):
        assert getattr(RctConfig(**{name: value}), name) == value  # type: ignore[arg-type]
    fraction = (1.5,) if isinstance(getattr(RctConfig(), name), int) else ()
    for wrong in (low - 1, high + 1, True, "2", float("nan"), *fraction):
        with refused(ConfigError, f"rct.{name} = {wrong!r}: must be from {span(low, high)} ({meaning})"):
            RctConfig(**{name: wrong})  # type: ignore[arg-type]


def test_a_run_as_plain_values_survives_json() -> None:
    run = RunConfig("mine", CotConfig.uniform(SHAPE, SLOT), RctConfig(alpha=0.5))
    stored = json.loads(json.dumps(run.to_dict()))
    slots = tuple(SlotConfig(**slot) for slot in stored["hardware"]["slots"])
    hardware = stored["hardware"]
    assert CotConfig(Shape(**hardware["shape"]), slots, hardware["tick_us"], module=hardware["module"]) == run.hardware
    assert (stored["name"], RctConfig(**stored["rct"])) == ("mine", run.rct)


class TestToml:
    BASE = RunConfig("base", CotConfig.uniform(SHAPE, SLOT))

    def load(self, tmp_path: Path, text: str) -> RunConfig:
        path = tmp_path / "run.toml"
        path.write_text(text)
        return load_toml(path, self.BASE)

    def test_each_table_overrides_its_part(self, tmp_path: Path) -> None:
        assert self.load(tmp_path, "") == self.BASE
        run = self.load(
            tmp_path,
            'name = "mine"\n[shape]\nfrac = 2\n[cot]\ntick_us = 100\nhist_avg = 2\n'
            "[[slot]]\nmode = 1\ninit_cm_x = 20\n[[slot]]\nhist_avg = 5\n[rct]\nalpha = 0.1\n",
        )
        assert run.name == "mine"
        assert (run.hardware.shape, run.hardware.tick_us) == (replace(SHAPE, frac=2), 100)
        assert cot_of(run).slots == (
            replace(SLOT, hist_avg=2, mode=Mode.FIXED, init_cm_x=20), replace(SLOT, hist_avg=5), replace(SLOT, hist_avg=2),
        )  # fmt: skip
        assert run.rct == RctConfig(alpha=0.1)

    def test_more_slots_repeat_the_last_one_and_fewer_drop_the_rest(self, tmp_path: Path) -> None:
        for n in (5, 1):
            assert cot_of(self.load(tmp_path, f"[shape]\nn_slots = {n}")).slots == (SLOT,) * n

    def test_it_names_the_module(self, tmp_path: Path) -> None:
        chain = self.load(tmp_path, 'hardware = "cot_chain"\n[cot]\nhist_avg = 2').hardware
        assert chain == CotConfig.uniform(SHAPE, replace(SLOT, hist_avg=2), module="cot_chain")
        single = self.load(tmp_path, 'hardware = "cot"').hardware
        assert single == CotConfig(replace(SHAPE, n_slots=1), (SLOT,), module="cot")

    def test_cot_motion_has_registers_a_tick_and_modes(self, tmp_path: Path) -> None:
        text = "[shape]\nn_slots = 3\n[motion]\nside_max = 90\ntick_us = 10\nmodes = [2, 0, 2]\n"
        expected = MotionConfig(Shape(n_slots=3), MotionRegisters(side_max=90), 10, modes=(2, 0, 2))
        assert self.load(tmp_path, 'hardware = "cot_motion"\n' + text).hardware == expected
        assert self.load(tmp_path, text).hardware == expected, "its table says it, too"

    @pytest.mark.parametrize(
        ("text", "message"),
        [
            (
                "radius = 3",
                "top level: unknown field 'radius': must be one of adaptive, cot, files, filters, hardware, made, motion, "
                "name, rct, run, shape, slot, software, software_filters",
            ),
            ("[cot]\nradius = 3", "[cot]: unknown field 'radius': must be one of clust_nev, detect_ticks, "),
            ("[shape]\nw = 3", "[shape]: unknown field 'w': must be one of frac, id_w, "),
            ("[rct]\nw = 3", "[rct]: unknown field 'w': must be one of alpha, "),
            ("[[slot]]\n[[slot]]\nw = 3", "[[slot]] 1: unknown field 'w': must be one of clust_nev, "),
            ("[[slot]]\n" * 4, "[[slot]] occurs 4 times: must be at most shape.n_slots = 3"),
            ("slot = 3", "[[slot]] must be a list of tables"),
            ("cot = 3", "top level: [cot] must be a table, not 3"),
            ("[cot]\nhist_avg = 9", "cot.slot[0].hist_avg = 9: must be an integer from 0 to 8 "),
            ("[cot]\nhist_avg = '3'", "cot.slot[0].hist_avg = '3': must be an integer from 0 to 8 "),
            ("[cot]\ntick_us = 0", "tick_us = 0: must be an integer from 1 to 1000000"),
            ("[shape]\nfrac = 9", "shape.frac = 9: must be an integer from 0 to 8 "),
            ("[rct]\nalpha = 2", "rct.alpha = 2: must be from 1e-06 to 1 "),
            ("hardware = 'cot_aray'", "hardware = 'cot_aray': must be one of cot, cot_chain, cot_array, cot_motion"),
            ("[motion]\nside_max = 90\n[cot]", "[motion]: must not be given for cot_array, whose registers stand in [cot]"),
            ("hardware = 'cot_motion'\n[cot]", "[cot]: must not be given for cot_motion, whose registers stand in [motion]"),
            ("hardware = 'cot_motion'\n[[slot]]", "[slot]: must not be given for cot_motion, whose registers stand in "),
            ("[motion]\nmodes = 2", "[motion]: modes = 2: must be a list of 0 (off) or 2 (seeded), one per slot"),
            ("[motion]\nmodes = [2, 2]", "motion.modes has 2 entries: must be shape.n_slots = 16"),
            ("hardware = 'cot'\n[shape]\nn_slots = 2", "shape.n_slots = 2: must be 1 for a single tracker"),
            ("= 3", "is not TOML: "),
        ],
    )
    def test_what_is_wrong_is_named_after_the_file(self, tmp_path: Path, text: str, message: str) -> None:
        with refused(ConfigError, start=f"{tmp_path / 'run.toml'}: {message}"):
            self.load(tmp_path, text)

    def test_a_file_that_cannot_be_read(self, tmp_path: Path) -> None:
        with pytest.raises(ConfigError, match=r"absent\.toml: cannot be read: No such file or directory"):
            load_toml(tmp_path / "absent.toml", self.BASE)
        (tmp_path / "binary.toml").write_bytes(b"\xff\xfe")
        with pytest.raises(ConfigError, match=r"binary\.toml: is not TOML"):
            load_toml(tmp_path / "binary.toml", self.BASE)


class TestSoftware:
    def test_a_file_says_who_runs_with_which_settings_and_filters_of_its_own(self, tmp_path: Path) -> None:
        path = tmp_path / "run.toml"
        path.write_text('software = "adaptive"\n[adaptive]\ncoast = 2.5\n[filters]\nrefractory_us = 7\n')
        run = load_toml(path, RunConfig())
        assert (run.software, run.adaptive.coast) == ("adaptive", 2.5)
        assert run.in_front_of_software == run.filters == FilterConfig(refractory_us=7)
        path.write_text("[filters]\nrefractory_us = 7\n[software_filters]\nrefractory_us = 9\n")
        assert load_toml(path, RunConfig()).in_front_of_software == FilterConfig(refractory_us=9)
        path.write_text("[software_filters]\n")
        assert load_toml(path, RunConfig(filters=FilterConfig(refractory_us=7))).in_front_of_software == FilterConfig()

    @pytest.mark.parametrize("name", ["frames", ["rct"]])
    def test_none_but_those_that_run_beside_the_hardware(self, name: object) -> None:
        with refused(ConfigError, f"software = {name!r}: must be one of adaptive, rct"):
            RunConfig(software=name)  # type: ignore[arg-type]

    def test_what_is_stored_has_only_the_one_that_runs(self) -> None:
        assert {"adaptive", "rct"} & set(RunConfig(software="adaptive").to_dict()) == {"adaptive"}
        assert {"adaptive", "rct"} & set(RunConfig().to_dict()) == {"rct"}


def cot_of(run: RunConfig) -> CotConfig:
    assert isinstance(run.hardware, CotConfig)
    return run.hardware


@pytest.mark.parametrize(("name", "n_ev", "tc"), [("slow", 8, 20), ("fast", 3, 7), ("fast5", 5, 7)])
def test_the_papers_situations(name: str, n_ev: int, tc: int) -> None:
    cot = cot_of(preset(name))
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
    with refused(ConfigError, f"preset 'quick': must be one of {', '.join(PRESETS)}"):
        preset("quick")


@pytest.mark.parametrize(
    ("name", "widths"), [("dvs128", (1, 128)), ("davis346", (129, 346)), ("vga", (347, 640)), ("hd", (641, 4096))]
)
def test_a_sensor_gets_the_first_preset_that_is_wide_enough(name: str, widths: tuple[int, int]) -> None:
    assert [for_sensor(width).name for width in widths] == [name, name]


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
    assert cot_of(fitted).slots == cot_of(base).slots[:1] * n
    assert (fitted.name, fitted.rct, fitted.hardware.tick_us) == (base.name, base.rct, base.hardware.tick_us)
    assert cot_of(fit(base, 640, 480)).slots == cot_of(base).slots


@pytest.mark.parametrize("n", [1, 16, 64])
def test_fitting_cot_motion_changes_its_slots_and_nothing_else(n: int) -> None:
    hardware = MotionConfig(modes=(Mode.OFF, *(Mode.SEEDED,) * 15))
    base = replace(MOTION, hardware=hardware)
    shape, modes = replace(hardware.shape, x_w=10, y_w=9, n_slots=n), (Mode.OFF, *(Mode.SEEDED,) * (n - 1))
    assert fit(base, 640, 480, n) == replace(base, hardware=replace(hardware, shape=shape, modes=modes))


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

# SPDX-License-Identifier: Apache-2.0
"""Filters in physical units: limits named in full, times in ticks, weights in 1/256, and the table `[filters]`."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from evcot.errors import ConfigError
from evcot.filters.config import FILTER_RANGES, FilterConfig
from evcot.filters.contract import Filter, FilterShape
from evcot.filters.hot_pixels import save_hot_pixels
from evcot.filters.registers import FilterRegisters
from evcot.ranges import span
from evcot.trackers.config import RunConfig, load_toml
from support.refusals import refused

EVERYTHING = FilterConfig(
    region=(1, 2, 30, 40), polarity="off", hot_pixels=((5, 6),), refractory_us=100, activity_us=2000, activity_support=2,
    recent_us=3000, recent_radius=5, recent_support=3, recent_depth=64, decay_tau_us=5000.0, decay_epsilon=0.25,
    decay_support=1.5, rowcol_us=4000, rowcol_radius=2, rowcol_support=2,
)  # fmt: skip


def refusal(**changed: Any) -> str:
    with pytest.raises(ConfigError) as caught:
        FilterConfig(**changed)
    return str(caught.value)


class TestConfig:
    def test_by_default_all_are_off(self) -> None:
        config = RunConfig().filters
        assert (config.enabled, config.filters, config.registers(1).enable) == (False, (), 0)

    @pytest.mark.parametrize(
        ("changed", "which"),
        [
            ({"region": (0, 0, 0, 0)}, Filter.REGION),
            ({"polarity": "on"}, Filter.POLARITY),
            ({"hot_pixels": ((0, 0),)}, Filter.MASK),
            ({"refractory_us": 1}, Filter.REFRACTORY),
            ({"activity_us": 1}, Filter.ACTIVITY),
            ({"recent_us": 1}, Filter.RECENT),
            ({"decay_tau_us": 100.0}, Filter.DECAY),
            ({"rowcol_us": 1}, Filter.ROWCOL),
        ],
    )
    def test_each_is_turned_on_by_its_own_field(self, changed: dict[str, Any], which: Filter) -> None:
        config = FilterConfig(**changed)
        assert (config.enabled, config.filters, config.registers(1).enable) == (True, (which,), 1 << which)

    @pytest.mark.parametrize("name", FILTER_RANGES)
    def test_a_number_takes_its_limits_and_nothing_beyond(self, name: str) -> None:
        low, high, meaning = FILTER_RANGES[name]
        for value in (low, high):
            assert getattr(FilterConfig(**{"recent_depth": 256, "activity_us": 1, "cell_px": 1, name: value}), name) == value  # type: ignore[arg-type]
        for wrong in (low - 1, high + 1, True, "2"):
            rule = f"must be from {span(low, high)} ({meaning})"
            assert refusal(**{name: wrong}) == f"filters.{name} = {wrong!r}: {rule}"

    @pytest.mark.parametrize(
        ("changed", "message"),
        [
            ({"region": (3, 0, 2, 9)}, "region = [3, 0, 2, 9]: must have x0 <= x1 and y0 <= y1"),
            ({"region": (0, 9, 2, 8)}, "region = [0, 9, 2, 8]: must have x0 <= x1 and y0 <= y1"),
            ({"region": (0, 0, 9)}, "region = (0, 0, 9): must be [x0, y0, x1, y1], each from 0 to 65535"),
            ({"region": (0, 0, 9, 65536)}, "region = (0, 0, 9, 65536): must be [x0, y0, x1, y1], each from 0 to 65535"),
            ({"region": 3}, "region = 3: must be [x0, y0, x1, y1], each from 0 to 65535"),
            ({"polarity": 1}, "polarity = 1: must be 'on' or 'off'"),
            ({"hot_pixels": 3}, "hot_pixels = 3: must be a list of pixels"),
            ({"hot_pixels": "33"}, "hot_pixels = '33': must be a list of pixels"),
            ({"hot_pixels": [(1, 2), (1, -2)]}, "hot_pixels holds (1, -2): must be [x, y], each from 0 to 65535"),
            ({"hot_pixels": [(1, 2.0)]}, "hot_pixels holds (1, 2.0): must be [x, y], each from 0 to 65535"),
            ({"activity_noise_hz": 0.5}, "activity_noise_hz = 0.5: must be 0 without activity_us"),
            (
                {"activity_noise_hz": 0.5, "activity_us": 9},
                "activity_noise_hz = 0.5: must be 0 without memories of cells; set cell_px to 1, 2 or 4",
            ),
            ({"recent_support": 9, "recent_depth": 8}, "recent_support = 9: must be at most recent_depth = 8"),
        ],
    )
    def test_what_is_wrong_is_named(self, changed: dict[str, Any], message: str) -> None:
        assert refusal(**changed) == f"filters.{message}"

    def test_a_pixel_counts_once(self) -> None:
        assert FilterConfig(hot_pixels=((1, 2), (3, 4), (1, 2))).hot_pixels == ((1, 2), (3, 4))

    def test_what_holds_the_neighbours_or_changes_their_meaning_stops_following_the_noise(self) -> None:
        follows = FilterConfig(activity_us=9, activity_noise_hz=0.5, cell_px=1)
        for changes in ({"activity_us": 0}, {"activity_support": 2}, {"cell_px": 0}):
            assert follows.changed(changes) == replace(follows, activity_noise_hz=0.0, **changes)
        for changes in ({"activity_us": 8}, {"refractory_us": 7}, {"cell_px": 2}):
            assert follows.changed(changes) == replace(follows, **changes)

    def test_plain_values_survive_json(self) -> None:
        stored = json.loads(json.dumps(RunConfig(filters=EVERYTHING).to_dict()))
        assert FilterConfig(**stored["filters"]) == EVERYTHING


class TestRegisters:
    def test_each_goes_to_its_register(self) -> None:
        registers = EVERYTHING.registers(tick_us=10)
        assert registers == FilterRegisters(
            enable=0b11111111, region_x0=1, region_y0=2, region_x1=30, region_y1=40, polarity=0, refractory_ticks=10,
            activity_ticks=200, activity_support=2, recent_ticks=300, recent_radius=5, recent_support=3,
            decay_rate=round(2**24 * 32 / (500 * math.log(2))), decay_epsilon=64, decay_support=384, rowcol_ticks=400,
            rowcol_radius=2, rowcol_support=2, hot_pixels=((5, 6),),
        )  # fmt: skip
        shape = EVERYTHING.shape(346, 260)
        assert shape == FilterShape(346, 260, recent_depth=64)
        registers.check(shape)

    @pytest.mark.parametrize("name", ["refractory", "activity", "recent"])
    def test_times_go_to_the_nearest_tick_or_are_refused(self, name: str) -> None:
        for us, ticks in ((10, 1), (14, 1), (15, 2), (24, 2), (25, 3), (5_242_870, 524_287)):
            registers = FilterConfig(**{f"{name}_us": us}).registers(10)  # type: ignore[arg-type]
            assert getattr(registers, f"{name}_ticks") == ticks
        for us in (9, 5_242_871):
            with refused(ConfigError, f"filters.{name}_us = {us}: must be from 10 to 5242870, 1 to 524287 ticks of 10 us"):
                FilterConfig(**{f"{name}_us": us}).registers(10)  # type: ignore[arg-type]

    def test_the_decays_clock_has_limits(self) -> None:
        shortest = 32 / math.log(2)
        assert FilterConfig(decay_tau_us=shortest * 1.00000001).registers(1).decay_rate == 1 << 24
        assert FilterConfig(decay_tau_us=shortest * 2**24 / 1000).registers(1).decay_rate == 1000
        assert FilterConfig(decay_tau_us=7e8).registers(1).decay_rate == 1
        for tau in (46.0, 8e8):
            with refused(ConfigError, f"filters.decay_tau_us = {tau:g}: must be from 46.17 to 7.745e+08 at ticks of 1 us"):
                FilterConfig(decay_tau_us=tau).registers(1)

    def test_weights_go_to_the_nearest_256th(self) -> None:
        for epsilon, register in ((0.0, 0), (1 / 512 - 1e-9, 0), (1 / 512, 1), (0.5, 128), (1.0, 255)):
            assert FilterConfig(decay_epsilon=epsilon).registers(1).decay_epsilon == register
        for support, register in ((1 / 256, 1), (1.0, 256), (8.0, 2048)):
            assert FilterConfig(decay_support=support).registers(1).decay_support == register

    def test_every_legal_configuration_gives_legal_registers(self) -> None:
        for name, (low, high, _) in FILTER_RANGES.items():
            for value in (low, high):
                config = replace(FilterConfig(recent_depth=256, activity_us=1, cell_px=1), **{name: value})  # type: ignore[arg-type]
                if not config.enabled:
                    config.registers(1).check(config.shape(346, 260))


class TestToml:
    def load(self, tmp_path: Path, text: str, base: FilterConfig | None = None) -> FilterConfig:
        path = tmp_path / "run.toml"
        path.write_text(text)
        return load_toml(path, RunConfig(filters=base or FilterConfig())).filters

    def test_the_table_overrides_what_it_names(self, tmp_path: Path) -> None:
        text = """
            [filters]
            region = [1, 2, 30, 40]
            hot_pixels = [[5, 6], [7, 8]]
            activity_us = 5_000
            decay_tau_us = 4000
            """
        assert self.load(tmp_path, text, FilterConfig(activity_us=1, polarity="on")) == FilterConfig(
            region=(1, 2, 30, 40), hot_pixels=((5, 6), (7, 8)), activity_us=5000, decay_tau_us=4000, polarity="on"
        )

    def test_hot_pixels_come_from_a_file_beside_it(self, tmp_path: Path) -> None:
        (tmp_path / "sub").mkdir()
        save_hot_pixels(tmp_path / "sub" / "hot.txt", [(192, 209)], (346, 260))
        assert self.load(tmp_path, "[filters]\nhot_pixels_file = 'sub/hot.txt'").hot_pixels == ((192, 209),)

    @pytest.mark.parametrize(
        ("text", "message"),
        [
            ("filters = 3", "top level: [filters] must be a table, not 3"),
            ("[filters]\nradius = 3", "[filters]: unknown field 'radius': must be one of activity_noise_hz, "),
            ("[filters]\nactivity_us = 1.5", "filters.activity_us = 1.5: must be from 0 to 1000000000 "),
            ("[filters]\nhot_pixels_file = 3", "[filters]: hot_pixels_file = 3: must be a file name, given "),
            (
                "[filters]\nhot_pixels_file = 'a'\nhot_pixels = []",
                "[filters]: hot_pixels_file = 'a': must be a file name, given without hot_pixels",
            ),
        ],
    )
    def test_what_is_wrong_is_named_after_the_file(self, tmp_path: Path, text: str, message: str) -> None:
        with refused(ConfigError, start=f"{tmp_path / 'run.toml'}: {message}"):
            self.load(tmp_path, text)

    def test_a_file_of_hot_pixels_that_is_missing_is_named(self, tmp_path: Path) -> None:
        with pytest.raises(ConfigError, match=r"run\.toml: .*absent\.txt: cannot be read: No such file or directory$"):
            self.load(tmp_path, "[filters]\nhot_pixels_file = 'absent.txt'")

# SPDX-License-Identifier: Apache-2.0
"""Waveforms of real runs, dumped once: blobs that cross, merge, rest and vanish, with every stream stalled at random.

A folder for commands, and what they refuse. And one browser for all tests that want one.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from evcot.events import Events
from evcot.hardware.config import CotConfig, SlotConfig
from evcot.hardware.contract import Shape
from evcot.hardware.modules import Module
from evcot.tracks.log import Kind
from evcot_cosim.cli import main
from evcot_cosim.devices.base import Stalls
from evcot_cosim.devices.device import Device
from evcot_cosim.rtl.build import cache_dir

Refused = Callable[..., str]

SHAPE = Shape(n_slots=3, x_w=7, y_w=7, radix_w=5, nev_w=6, tc_w=12, sup_w=8, id_w=16, seq_w=16, time_w=20)
SLOT = SlotConfig(
    init_radix=5, radix_th=2, radix_step=1, radix_min=3, radix_max=9, hist_avg=2,
    max_ticks=300, clust_nev=6, nev_min=3, nev_max=12, nev_th=40, detect_ticks=120,
)  # fmt: skip


@pytest.fixture(scope="session")
def config() -> CotConfig:
    """Three seeded trackers on 128x128 pixels."""
    return CotConfig.uniform(SHAPE, SLOT)


@pytest.fixture(scope="session")
def blobs() -> Events:
    """Two blobs on crossing paths and scattered noise, about 3 ticks apart; every 500 events a silence ends all lives."""
    random = np.random.default_rng(11)
    n = 1_000
    phase = np.arange(n) % 1_000 / 1_000
    which = random.integers(2, size=n)
    x = np.where(which == 0, 20 + 90 * phase, 110 - 90 * phase) + random.normal(0, 2.5, n)
    y = np.where(which == 0, 60, 66) + random.normal(0, 2.5, n)
    noise = random.random(n) < 0.1
    x[noise], y[noise] = random.uniform(0, 128, (2, np.count_nonzero(noise)))
    steps = random.poisson(3, n)
    steps[::500] = 1_000
    steps[0] = 0
    x, y = (np.clip(axis, 0, 127).astype(np.uint16) for axis in (x, y))
    return Events(np.cumsum(steps), x, y, random.integers(2, size=n).astype(np.uint8))


@pytest.fixture(scope="session")
def stalls() -> Stalls:
    """Every stream stalls; records have to wait longest."""
    return Stalls.random(np.random.default_rng(5), (0.8, 0.02, 0.4, 0.6))


@pytest.fixture(scope="session")
def vcds(config: CotConfig, blobs: Events, stalls: Stalls, tmp_path_factory: pytest.TempPathFactory) -> dict[Module, Path]:
    """The waveform of one run through each arrangement of trackers."""
    folder = tmp_path_factory.mktemp("vcds")
    return {top: dumped(config, blobs, stalls, folder / f"{top}.vcd", top) for top in ("cot_array", "cot_chain")}


def dumped(config: CotConfig, events: Events, stalls: Stalls, path: Path, top: Module) -> Path:
    device = Device(replace(config, module=top), stalls=stalls)
    with device.dumping(path):
        records = device.stream(events).records
    wanted = set(Kind) - {Kind.MERGED} if top == "cot_chain" else set(Kind)
    assert set(records["kind"]) == wanted, "the run is to show every kind of record"
    return path


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty working folder; models come from the cache that the test run shares."""
    monkeypatch.setenv("EVCOT_CACHE", str(cache_dir()))
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def refused(capsys: pytest.CaptureFixture[str]) -> Refused:
    """Runs a command that cannot be done; returns the one line that it prints, which must be all that it leaves."""

    def run(*arguments: str) -> str:
        assert not Path("pyproject.toml").exists(), "must be in a folder of its own, such as `home`"
        before = sorted(Path().rglob("*"))
        capsys.readouterr()
        assert main(arguments) == 2
        printed = capsys.readouterr()
        lines = [line for line in printed.err.splitlines() if not line.startswith("evcot: compiling the hardware")]
        assert (printed.out, len(lines)) == ("", 1), printed.err
        assert sorted(Path().rglob("*")) == before
        assert lines[0].startswith("evcot: ")
        return lines[0].removeprefix("evcot: ")

    return run


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    """Chromium without a screen; tests that want it skip where Playwright or Chromium is absent."""
    api = pytest.importorskip("playwright.sync_api", reason="Playwright is not installed")
    chromium = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if chromium is None:
        pytest.skip("no Chromium on PATH")
    arguments = ["--no-sandbox", "--disable-gpu", "--disable-background-networking", "--font-render-hinting=none"]
    with api.sync_playwright() as playwright:
        running = playwright.chromium.launch(executable_path=chromium, args=arguments)
        yield running
        running.close()

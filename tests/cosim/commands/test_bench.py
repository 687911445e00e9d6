# SPDX-License-Identifier: Apache-2.0
"""`evcot bench`: every engine and the hardware are measured, and rates follow from times."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import evcot_cosim.rtl.build
from evcot_cosim.cli import main

Capture = pytest.CaptureFixture[str]


def test_bench_measures_every_engine_and_the_hardware(capsys: Capture, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("EVCOT_CACHE", str(evcot_cosim.rtl.build.cache_dir()))
    monkeypatch.chdir(tmp_path)
    assert main(["simulate", "boxes", "--duration", "0.1", "-o", "boxes.npz", "--json"]) == 0
    events = json.loads(capsys.readouterr().out)["events"]
    assert main(["bench", "boxes.npz", "--json"]) == 0
    rates = {rate["what"]: rate for rate in json.loads(capsys.readouterr().out)}
    wanted = {"reading", "activity filter", "rct, plain", "golden model", "cot_motion", "cot_motion, checked against the model"}
    assert wanted <= rates.keys()
    for rate in rates.values():
        assert rate["events"] == events
        assert rate["events_per_s"] == pytest.approx(rate["events"] / rate["seconds"])

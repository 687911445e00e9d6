# SPDX-License-Identifier: Apache-2.0
"""docs/sweeps.md: its specifications are specifications, and its queries answer on a store."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

from evcot_cosim.sweep.run import run_sweep
from evcot_cosim.sweep.spec import spec_from
from support.sweeping import recorded

PAGE = (Path(__file__).parents[3] / "docs" / "sweeps.md").read_text()


def blocks(language: str) -> list[str]:
    found = re.findall(rf"^```{language}\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
    assert found
    return found


def test_the_specifications_are_some(tmp_path: Path) -> None:
    for text in blocks("toml"):
        spec = spec_from(tomllib.loads(text), tmp_path, "page")
        assert spec.fuzz or spec.axes


def test_the_queries_answer(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    duckdb = pytest.importorskip("duckdb")
    recorded(tmp_path, 1)
    values = {
        "recordings": ["discs1.npz"], "engines": ["rct", "cot_array"], "preset": "discs",
        "fields": {"rct.radius_px": [6.0, 9.0], "cot.init_radix": [8, 10, 30], "shape.n_slots": [2, 4]},
    }  # fmt: skip
    # 30 is above radix_max with every number of slots, but not for the tracker in software.
    values["fields"]["cot.radix_max"] = [12, 30]  # type: ignore[index]
    swept = run_sweep(spec_from(values, tmp_path, "page"), tmp_path.with_name("page"), jobs=1)
    monkeypatch.chdir(swept.folder)
    best, front, faults, took, plan = (duckdb.sql(query).fetchall() for query in blocks("sql"))
    assert len(best) == 3, "two radii, and the model"
    assert sorted(row[2] for row in best) == sorted(row[2] for row in best)
    assert [row[2] for row in best] == sorted((row[2] for row in best), reverse=True)
    costs = [row[-1] for row in front]
    assert costs == sorted(costs)
    assert 1 <= len(front) <= 12
    assert {row[0] for row in faults} == {"invalid"}
    assert {row[1] for row in took} == {"rct", "cot_array"}
    assert sum(row[2] for row in took) == swept.runs
    assert plan[0][0] == swept.runs - len(faults)

# SPDX-License-Identifier: Apache-2.0
"""The report of a sweep: a page of 10^5 configurations that draws itself in a browser; and the figures behind it."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from evcot_cosim.sweep.finish import leaders
from evcot_cosim.sweep.page import render
from evcot_cosim.sweep.results import best_first, families_of, front, grouped, responses
from evcot_cosim.sweep.run import run_sweep
from evcot_cosim.sweep.spec import Spec, spec_from
from evcot_cosim.sweep.task import Task, canonical
from support.sweeping import recorded, until
from support.texts import hard_to_read


def row(number: int, settings: dict[str, Any], family: str = "a", status: str = "done", **figures: Any) -> dict[str, Any]:
    task = canonical(Task("rct", settings=settings).to_dict())
    plain = {"hota": None, "luts": None, "wall_s": 1.0, "events": 10, "error": "", "command": f"evcot sweep x --only {number}"}
    about = {"key": f"{number:016x}", "engine": "rct", "hardware": "", "preset": None, "host": "here", "family": family}
    return {**about, "status": status, "task": task, **plain, **figures}


def spec(**more: Any) -> Spec:
    values = {"scenes": ["discs"], "objectives": {"hota": "max", "luts": "min"}, "fields": {"rct.alpha": [0.1]}}
    return spec_from(values | more, Path(), "a sweep")


def summary_of(rows: list[dict[str, Any]], of: Spec) -> dict[str, Any]:
    groups = grouped(rows, list(of.objectives))
    best = [
        {"name": group.name, "means": group.means, "runs": len(group.rows), "keys": [], "playback": []}
        for group in best_first(groups, of.objectives)[:3]
    ]
    faults = [one for one in rows if one["status"] != "done"]
    return {"best": best, "faults": faults, "left_out": {}, "status": {"done": len(rows) - len(faults), "failed": len(faults)}}


def test_a_configuration_has_the_mean_of_its_runs() -> None:
    rows = [row(1, {"a": 1}, hota=0.25, luts=4.0), row(2, {"a": 1}, hota=0.75, luts=4.0), row(3, {"a": 2}, hota=0.5, luts=None)]
    one, two = grouped(rows, ["hota", "luts"])
    assert (one.means, two.means) == ({"hota": 0.5, "luts": 4.0}, {"hota": 0.5})
    failed = row(4, {"a": 2}, status="failed")
    assert grouped([*rows, failed], ["hota"])[1].means == {}, "what failed once has no mean"


def test_the_front_has_what_nothing_is_better_than() -> None:
    figures = [(0.9, 100.0), (0.8, 50.0), (0.8, 60.0), (0.7, 50.0), (0.1, 1.0), (0.9, 100.0)]
    rows = [row(i, {"a": i}, hota=hota, luts=luts) for i, (hota, luts) in enumerate(figures)]
    groups = grouped(rows, ["hota", "luts"])
    found = front(groups, {"hota": "max", "luts": "min"})
    assert [group.settings["a"] for group in found] == [0, 5, 1, 4]
    assert [group.settings["a"] for group in front(groups, {"luts": "min"})] == [4]
    assert leaders(spec(), [{"means": found[0].means, "runs": 1, "name": "x"}])[1] == ("0.9", "100", "1", "x")


def test_a_response_has_means_and_intervals() -> None:
    rows = [row(i, {"a": i % 2, "b": i}, hota=value) for i, value in enumerate([0.0, 1.0, 0.5, 1.0])]
    of = responses(grouped(rows, ["hota"]), "hota")
    low, high = of["a"]
    assert (low.title, low.count, low.mean) == ("0", 2, 0.25)
    assert low.high - low.mean == pytest.approx(1.96 * np.std([0, 0.5], ddof=1) / np.sqrt(2))
    assert (high.mean, high.low, high.high) == (1.0, 1.0, 1.0)
    assert [level.title for level in of["b"]] == ["0", "1", "2", "3"]


def test_a_response_to_names_has_each_of_them_however_many_the_best_first() -> None:
    names = [f"name{i}" for i in range(20)]
    rows = [row(i, {"preset": name, "a": 1}, preset=name, hota=i * 7 % 20 / 20) for i, name in enumerate(names)]
    groups = grouped(rows, ["hota"])
    levels = responses(groups, "hota")["preset"]
    assert [level.mean for level in levels] == [i / 20 for i in reversed(range(20))]
    assert {level.title: level.mean for level in levels} == {name: i * 7 % 20 / 20 for i, name in enumerate(names)}
    assert {level.at for level in levels} == {None}
    assert groups[0].name == "rct, name0, a = 1", "a preset that was swept is named once"


def test_a_family_is_scored_with_what_is_best_on_the_others() -> None:
    table = {1: {"a": 0.9, "b": 0.2, "c": 0.3}, 2: {"a": 0.1, "b": 0.8, "c": 0.8}, 3: {"a": 0.5, "b": 0.5, "c": 0.5}}
    rows = [
        row(10 * setting + i, {"s": setting}, family, hota=hota)
        for setting, own in table.items()
        for i, (family, hota) in enumerate(own.items())
    ]
    found = {each.family: each for each in families_of(grouped(rows, ["hota"]), "hota", "max")["rct"]}
    assert (found["a"].chosen, found["a"].score, found["a"].best_score) == ("rct, s = 2", 0.1, 0.9)
    assert (found["b"].chosen, found["b"].score) == ("rct, s = 1", 0.2)
    assert found["b"].others == pytest.approx(0.6)


def test_the_page_is_drawn_and_filtered(tmp_path: Path, browser: Any) -> None:
    rng = np.random.default_rng(1)
    rows = [
        row(
            i,
            {"rct.alpha": float(a), "filters.polarity": "on" if i % 2 else "off"},
            hota=float(1 - (a - 0.5) ** 2),
            luts=float(i % 7),
        )
        for i, a in enumerate(rng.random(2_000))
    ]
    rows.append(row(9_999, {"rct.alpha": 0.1}, status="failed", error="a <script>worker</script> was killed"))
    path = tmp_path / "report.html"
    path.write_text(render(spec(), rows, grouped(rows, ["hota", "luts"]), summary_of(rows, spec())))
    page = browser.new_page(viewport={"width": 1200, "height": 900})
    faults: list[str] = []
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.on("console", lambda message: faults.append(message.text) if message.type == "error" else None)
    page.goto(path.as_uri())
    page.wait_for_selector("html[data-ready=true]")
    assert faults == []
    assert page.inner_text("#kept") == "2,000 of 2,000 configurations; the best of them:"
    heads = page.eval_on_selector_all("#lines th", "cells => cells.map((cell) => cell.textContent)")
    assert heads == ["filters.polarity", "rct.alpha", "hota", "luts"]
    first = page.eval_on_selector_all("#lines tr:nth-child(2) td", "cells => cells.map((cell) => cell.textContent)")
    assert float(first[1]) == pytest.approx(0.5, abs=0.02), "the best of all"
    page.locator("#parallel").scroll_into_view_if_needed()
    box = page.locator("#parallel").bounding_box()
    x, top, high = box["x"] + 50, box["y"] + 44, box["height"] - 68
    page.mouse.move(x, top + 0.05 * high)
    page.mouse.down()
    page.mouse.move(x, top - 2, steps=3)
    page.mouse.up()
    until(lambda: page.inner_text("#kept").startswith("1,000 of 2,000"), "the lines that pass there")
    kept = page.eval_on_selector_all("#lines td:first-child", "cells => cells.map((cell) => cell.textContent)")
    assert set(kept) == {"on"}
    page.mouse.click(x, top + 0.3 * high)
    until(lambda: page.inner_text("#kept").startswith("2,000 of 2,000"), "all lines")
    drawn = "canvas => new Set(canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data).size"
    page.wait_for_selector("#parallel[data-drawn='2000']")
    assert page.eval_on_selector("#scatter", drawn) > 20
    assert page.eval_on_selector("#parallel", drawn) > 20
    assert page.locator("#responses figure").count() == 2
    assert "a <script>worker</script> was killed" in page.inner_text("#faults")
    for theme in ("light", "dark"):
        page.locator("#theme").click()
        assert page.evaluate("document.documentElement.dataset.theme") == theme
        assert hard_to_read(page) == []
    page.close()


def test_the_best_lines_are_drawn_first_and_stay_on_top(tmp_path: Path, browser: Any) -> None:
    """Half of the lines are good, half bad, all through the same place: the good ones are seen at once, and at the end."""
    rows = [row(i, {"rct.alpha": i * 7_919 % 6_000 / 6_000}, hota=float(i % 2), luts=1.0) for i in range(6_000)]
    path = tmp_path / "report.html"
    path.write_text(render(spec(), rows, grouped(rows, ["hota", "luts"]), summary_of(rows, spec())))
    page = browser.new_page(viewport={"width": 1200, "height": 900})
    page.add_init_script("""
      const drawImage = CanvasRenderingContext2D.prototype.drawImage;
      window.parts = 0;
      window.colour = () => {
        const canvas = document.getElementById("parallel");
        return [...canvas.getContext("2d").getImageData(canvas.width / 4, canvas.height / 2, 1, 1).data];
      };
      CanvasRenderingContext2D.prototype.drawImage = function (...given) {
        drawImage.apply(this, given);
        if (!window.parts++) window.first = colour();
      };
    """)
    page.goto(path.as_uri())
    page.wait_for_selector("#parallel[data-drawn='6000']")
    assert page.evaluate("parts") > 2, "part by part"
    for red, green, blue, _ in page.evaluate("[first, colour()]"):
        assert red > 2 * blue, "yellow, the colour of the best"
        assert green > 2 * blue
    page.close()


def test_a_hundred_thousand_configurations_are_a_page(tmp_path: Path) -> None:
    rng = np.random.default_rng(2)
    shares = rng.random((100_000, 3)).tolist()
    rows = [
        row(i, {"rct.alpha": a, "rct.radius_px": 50 * b, "cot.init_radix": int(9 * c)}, hota=a * b, luts=100 * c)
        for i, (a, b, c) in enumerate(shares)
    ]
    summary = {"best": [], "faults": [], "left_out": {}, "status": {"done": len(rows)}}
    page = render(spec(), rows, grouped(rows, ["hota", "luts"]), summary)
    facts = json.loads(re.search(r'id="facts">(.*?)</script>', page)[1])  # type: ignore[index]
    assert facts["count"] == 100_000
    assert len(page) < 3_000_000
    assert not re.search(r'(?:src|href)="(?:https?:)?//', page), "nothing from elsewhere"


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

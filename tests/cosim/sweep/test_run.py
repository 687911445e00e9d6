# SPDX-License-Identifier: Apache-2.0
"""Sweeps as a whole: the same results however they are run, resumed, killed; and what cannot be is refused before a run."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from collections import Counter
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import pytest

import evcot
from evcot.errors import ConfigError, OutputError
from evcot_cosim.sweep import machine
from evcot_cosim.sweep.axes import Axis, axis_from, grid, latin, uniform
from evcot_cosim.sweep.execute import execute
from evcot_cosim.sweep.metrics import METRICS
from evcot_cosim.sweep.plan import Planner, points_of
from evcot_cosim.sweep.playback import repeat
from evcot_cosim.sweep.run import Swept, run_sweep
from evcot_cosim.sweep.spec import FUZZED, Spec, read_spec, spec_from, spec_toml
from evcot_cosim.sweep.store import Store, read_rows
from evcot_cosim.sweep.task import Task
from support.sweeping import recorded

pytest.importorskip("pyarrow")

RADII = [6.0, 9.0]
Rows = dict[str, tuple[Any, ...]]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two recordings with truths."""
    folder = tmp_path_factory.mktemp("recordings")
    for seed in (1, 2):
        recorded(folder, seed)
    return folder


def spec_of(folder: Path, **more: Any) -> Spec:
    values: dict[str, Any] = {
        "recordings": [str(folder)], "engines": ["rct", "cot_array"], "preset": "discs", "objectives": {"hota": "max"},
        "fields": {"rct.radius_px": RADII, "cot.init_radix": [8], "filters.refractory_us": [0, 500]},
    }  # fmt: skip
    return spec_from(values | more, folder, "small")


def exact(folder: Path) -> Rows:
    """Everything that must not depend on how a run was done."""
    rows = read_rows(folder)
    return {row["key"]: tuple(row[name] for name in ("status", "engine", "error", "task", *METRICS)) for row in rows}


@pytest.fixture(scope="module")
def once(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Swept, Path]:
    """The whole sweep, in one process."""
    out = tmp_path_factory.mktemp("out") / "once"
    return run_sweep(spec_of(folder), out, jobs=1), out


def test_each_distinct_run_is_done_once(once: tuple[Swept, Path]) -> None:
    swept, out = once
    # The tracker knows nothing of registers, the model nothing of radius_px: 2 x 2 and 1 x 2 configurations on 2 recordings.
    assert (swept.runs, swept.new, dict(swept.counts)) == (12, 12, {"done": 12})
    rows = read_rows(out)
    assert sorted(row["engine"] for row in rows) == ["cot_array"] * 4 + ["rct"] * 8
    assert {row["rct.radius_px"] for row in rows if row["engine"] == "cot_array"} == {None}


def test_a_row_is_what_track_and_evaluate_say(once: tuple[Swept, Path], folder: Path) -> None:
    _, out = once
    rows = [row for row in read_rows(out) if row["engine"] == "rct" and row["input"].endswith("discs1.npz")]
    (row,) = (row for row in rows if row["rct.radius_px"] == 9.0 and row["filters.refractory_us"] == 500)
    filters = evcot.FilterConfig(refractory_us=500)
    log = evcot.track(folder / "discs1.npz", "rct", "discs", radius_px=9.0, filters=filters)
    scores = evcot.evaluate(log, folder / "discs1.truth.csv", sensor=(96, 64)).to_dict()
    assert {name: row[name] for name in scores} == scores
    assert (row["events"], row["records"], row["owned"]) == (len(log.owner), len(log.records), int((log.owner >= 0).sum()))


def test_nothing_is_done_twice(once: tuple[Swept, Path], folder: Path, tmp_path: Path) -> None:
    swept, out = once[0], tmp_path / "out"
    shutil.copytree(once[1], out)
    before = {row["key"]: row["when"] for row in read_rows(out)}
    again = run_sweep(spec_of(folder), out, jobs=1)
    assert (again.runs, again.new) == (12, 0)
    fields = {"rct.radius_px": [*RADII, 20.0], "cot.init_radix": [8], "filters.refractory_us": [0, 500]}
    larger = run_sweep(spec_of(folder, fields=fields), out, jobs=1)
    assert larger.new == 4, "the new radius, with either filter on either recording"
    assert {key: when for key, when in ((row["key"], row["when"]) for row in read_rows(out)) if key in before} == before
    assert swept.keys & larger.keys


def test_a_sweep_that_is_killed_goes_on_in_two_processes_bit_for_bit(
    once: tuple[Swept, Path], folder: Path, tmp_path: Path
) -> None:
    path, out = tmp_path / "spec.toml", tmp_path / "out"
    path.write_text(spec_toml(spec_of(folder)))
    command = [sys.executable, "-m", "evcot_cosim", "sweep", str(path), "-o", str(out), "--jobs", "1", "-q"]
    process = subprocess.Popen(command, stderr=subprocess.PIPE)
    journal = out / "journal.jsonl"
    while process.poll() is None and not (journal.exists() and journal.read_bytes().count(b"\n") >= 3):
        time.sleep(0.005)
    os.kill(process.pid, signal.SIGKILL)
    process.communicate()
    with Store(out) as store:
        kept = dict(store.status)
    assert len(kept) >= 3
    when = {row["key"]: row["when"] for row in read_rows(out)}
    swept = run_sweep(spec_of(folder), out, jobs=2)
    assert swept.new == 12 - len(kept)
    assert exact(out) == exact(once[1])
    assert {row["key"]: row["when"] for row in read_rows(out) if row["key"] in kept} == when


def test_one_run_is_repeated_by_its_key(once: tuple[Swept, Path], monkeypatch: pytest.MonkeyPatch) -> None:
    _, out = once
    row = read_rows(out)[0]
    assert row["command"] == f"evcot sweep {out} --only {row['key']}"
    assert repeat(out, row["key"]).differences == ()
    assert repeat(out, row["key"][:12]).row["hota"] == row["hota"]
    with pytest.raises(ConfigError, match="--only 0: is the key of 0 runs"):
        repeat(out, "0")
    changed = execute(Task.from_json(row["task"]))
    monkeypatch.setattr("evcot_cosim.sweep.playback.execute", lambda _: changed | {"hota": 0.25})
    (difference,) = repeat(out, row["key"]).differences
    assert (difference.name, difference.stored, difference.now) == ("hota", row["hota"], 0.25)


@pytest.mark.parametrize(
    "text", ["", "{", "[]", "{}", '{"input": null}', '{"input": {"x": 1}}', '{"input": null, "engine": "rct", "tables": 1}']
)
def test_a_stored_task_that_is_none_is_refused(text: str) -> None:
    with pytest.raises(ConfigError, match=r"^task = '.*': must be a task, as `evcot sweep` stores it$"):
        Task.from_json(text)


def test_a_file_that_changes_is_noticed(folder: Path, tmp_path: Path) -> None:
    path = recorded(tmp_path, 5)
    (task,) = Planner(spec_of(tmp_path, engines=["rct"], fields={})).plan(points_of(spec_of(tmp_path, fields={}))).tasks
    assert execute(task)["status"] == "done"
    path.unlink()
    recorded(tmp_path, 6).rename(path)
    row = execute(task)
    assert (row["status"], row["error"]) == ("failed", f"{path}: has changed since the sweep began: must stay as it is")
    path.unlink()
    assert execute(task)["error"] == f"{path}: cannot be read: No such file or directory"


def test_the_key_is_of_contents_not_of_names(folder: Path, tmp_path: Path) -> None:
    def keys(where: Path, **more: Any) -> set[str]:
        spec = spec_of(where, **more)
        return {task.key for task in Planner(spec).plan(points_of(spec)).tasks}

    for name in os.listdir(folder):
        (tmp_path / name).write_bytes((folder / name).read_bytes())
    assert keys(tmp_path) == keys(folder)
    assert not keys(folder, preset="traffic") & keys(folder)
    before = keys(tmp_path)
    truth = tmp_path / "discs1.truth.csv"
    truth.write_text("".join(truth.read_text().splitlines(keepends=True)[:-1]))
    assert len(keys(tmp_path) & before) == len(before) // 2, "another truth is another run"


def test_a_damaged_file_and_settings_that_contradict_each_other_are_rows(tmp_path: Path) -> None:
    path = recorded(tmp_path, 1)
    (tmp_path / "bad.csv.txt").write_text("t,x,y,p\n0,1,1,1\n5,2,2,0\n4,95,x,1\n")
    spec = spec_of(tmp_path, engines=["cot_array"], fields={"cot.init_radix": [8, 10], "cot.radix_max": [9, 12]})
    swept = run_sweep(spec, tmp_path.with_name("damaged"), jobs=1)
    assert dict(swept.counts) == {"done": 3, "failed": 4, "invalid": 1}, "the damaged file ends before its settings count"
    rows = read_rows(swept.folder)
    failed = {(Path(row["input"]).name, "bad.csv.txt" in row["error"]) for row in rows if row["status"] == "failed"}
    assert failed == {("bad.csv.txt", True)}
    assert {Path(row["input"]).name for row in rows if row["status"] == "done"} == {path.name}
    errors = {row["error"] for row in rows if row["status"] == "invalid"}
    assert errors == {"cot.slot[0].init_radix = 10: must lie from radix_min = 6 to radix_max = 9"}


@pytest.mark.parametrize(
    ("more", "why"),
    [
        ({"enginess": ["rct"]}, "unknown field 'enginess': must be one of "),
        ({"engines": ["rtc"]}, "engines: 'rtc': must be one of cot_motion, cot_array, "),
        ({"recordings": ["gone.raw"]}, "gone.raw: is missing: must be a recording"),
        ({"fields": {"rct.radius": [1.0]}}, "fields.rct.radius: no such field"),
        ({"fields": {"cot.init_radix": [8, 200]}}, "no run of engine cot_array is possible with [cot.init_radix,200]: "),
        ({"objectives": {"hotta": "max"}}, "objectives.hotta: no such metric: must be one of hota, "),
        ({"objectives": {"hota": "up"}}, "objectives.hota = 'up': must be max or min"),
        ({"seeds": {"from": 4, "to": 3}}, "seeds: from 4 to 3: must not be negative or empty"),
        ({"seeds": []}, "seeds = []: must be whole numbers"),
        ({"parts": [[5, 5]]}, "parts = [[5, 5]]: must be a list of "),
        ({"method": "latin"}, "samples = 0: must be from 1 to 200,000"),
        ({"method": "best"}, "method = 'best': must be one of grid, random, latin, optuna"),
        ({"truth": {"a.raw": "b.csv"}}, "a.raw: must be one of the recordings"),
        ({"families": {"a": ["c.raw"]}}, "c.raw: must be one of scenes or recordings"),
        ({"preset": "dics"}, "no run of engine rct is possible: preset dics: must be one of plain, "),
        ({"fields": {"preset": ["discs", "dics"]}}, "fields.preset: 'dics': must be one of "),
        ({"hardware": ["cot_arry"]}, "hardware: 'cot_arry': must be one of "),
        ({"seeds": {"from": 0, "to": 200_000}}, "seeds: from 0 to 200000: must not be negative or empty, and at most 200,000"),
        ({"fuzz": {"events": 5}}, "fuzz: must not be given with recordings, scenes or fields"),
        ({"samples": True}, "samples = True: must be a whole number"),
        ({"name": "../../mine"}, "name = '../../mine': must be a name for a folder in build/sweep"),
        ({"tables": {"rct": {"radius": 3.0}}}, "no run of engine rct is possible: [rct]: unknown field 'radius'"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused_before_anything_has_run(
    more: dict[str, Any], why: str, folder: Path, tmp_path: Path
) -> None:
    with pytest.raises(ConfigError) as refused:
        run_sweep(spec_of(folder, **more), tmp_path / "out", jobs=1)
    assert why in str(refused.value)
    assert not (tmp_path / "out").exists()


def test_a_sweep_has_a_limit_of_runs(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Runs, not points: of each input, engine and seed; a point that changes nothing for an engine makes no run of it."""
    runs = len(Planner(spec_of(folder)).plan(points_of(spec_of(folder))).tasks)
    fuzz = spec_from({"fuzz": {"events": 5}, "seeds": {"from": 1, "to": 50}}, folder, "fuzz")
    for spec, most in ((spec_of(folder), runs), (fuzz, len(FUZZED) * 50)):
        for limit, is_refused in ((most - 1, True), (most, False)):
            monkeypatch.setattr("evcot_cosim.sweep.plan.RUNS_MAX", limit)
            planner = Planner(spec)
            with pytest.raises(ConfigError, match=f"runs: must be at most {limit:,}") if is_refused else nullcontext():
                assert planner.plan(points_of(spec)) if spec.fuzz is None else planner.fuzz()


@pytest.mark.parametrize(
    ("fuzz", "why"),
    [
        ({"module": ["cot"]}, "fuzz: unknown field 'module': must be one of events, modules, shapes"),
        ({"modules": ["cots"]}, "fuzz.modules: 'cots': must be one of cot, cot_chain, cot_array, cot_motion, evcot_top"),
        ({"modules": ["cot"], "events": {"cot_array": 9}}, "must be given for each of cot, and for no other"),
        ({"events": 0}, "fuzz.events = 0 for cot: must be a whole number from 1 to 1000000000"),
        ({"shapes": 0}, "fuzz.shapes = 0 for cot: must be a whole number from 1 to 200000"),
        ({"shapes": []}, "fuzz.shapes = []: must be a list of tables, one at least, or how many to draw"),
        ({"shapes": [{"slots": 2}]}, "fuzz.shapes[0]: unknown field 'slots'"),
        ({"shapes": [{"n_slots": 0}]}, "fuzz.shapes[0]: shape.n_slots = 0: must be an integer from 1 to 64"),
    ],
)
def test_what_cannot_be_drawn_is_refused(fuzz: dict[str, Any], why: str, folder: Path) -> None:
    with pytest.raises(ConfigError) as refused:
        spec_from({"fuzz": fuzz}, folder, "fuzz")
    assert why in str(refused.value)


def test_drawn_shapes_are_others_for_each_module_and_the_same_each_time(folder: Path, tmp_path: Path) -> None:
    drawn = {"modules": ["cot_array", "evcot_top"], "shapes": {"cot_array": 3, "evcot_top": 2}, "events": 100}
    spec = spec_from({"fuzz": drawn, "seeds": [1, 2]}, folder, "fuzz")
    plan = Planner(spec).fuzz()
    assert Counter(task.hardware for task in plan.tasks) == {"cot_array": 6, "evcot_top": 4}
    assert plan.designs == 5
    assert {task.key for task in plan.tasks} == {task.key for task in Planner(spec).fuzz().tasks}
    (tmp_path / "again.toml").write_text(spec_toml(spec))
    assert read_spec(str(tmp_path / "again.toml")).fuzz == spec.fuzz


def test_a_specification_goes_round(folder: Path, tmp_path: Path) -> None:
    spec = spec_of(
        folder, seeds={"from": 3, "to": 9}, parts=[[0, 50_000], [50_000]], families={"a": [str(folder)]}, stalls=True,
        fields={"rct": {"radius_px": {"from": 1.0, "to": 9.0, "steps": 4, "log": True}}, "cot.init_radix": [7, 8]},
    )  # fmt: skip
    assert [axis.name for axis in spec.axes] == ["rct.radius_px", "cot.init_radix"]
    (tmp_path / "again.toml").write_text(spec_toml(spec))
    assert read_spec(str(tmp_path / "again.toml")) == spec


def test_a_folder_of_somebody_else_is_left_alone(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "mine").write_text("mine")
    with pytest.raises(OutputError, match="holds files, and evcot did not make it"):
        run_sweep(spec_of(folder), tmp_path, jobs=1)
    assert os.listdir(tmp_path) == ["mine"]


def test_optuna_asks_for_the_same_points_however_many_workers(folder: Path, tmp_path: Path) -> None:
    pytest.importorskip("optuna")
    fields = {"rct.radius_px": {"from": 5.0, "to": 20.0}, "filters.polarity": ["on", "off"]}
    spec = spec_of(folder, method="optuna", samples=6, batch=3, engines=["rct"], fields=fields)
    one = run_sweep(spec, tmp_path / "one", jobs=1)
    two = run_sweep(spec, tmp_path / "two", jobs=2)
    assert one.keys == two.keys
    assert exact(tmp_path / "one") == exact(tmp_path / "two")
    assert 8 <= one.runs <= 12
    again = run_sweep(spec, tmp_path / "one", jobs=2)
    assert (again.new, again.keys) == (0, one.keys)


def test_another_program_does_no_task(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    spec = spec_of(folder, engines=["rct"], fields={})
    task = Planner(spec).plan(points_of(spec)).tasks[0]
    monkeypatch.setattr("evcot_cosim.sweep.execute.code_of", lambda _: "other")
    assert execute(task)["error"] == f"the program is other: must be {machine.code_fingerprint()}, the sweep's"


def test_workers_that_differ_are_refused(folder: Path) -> None:
    own = machine.probe([str(folder / "discs1.npz")])
    machine.check_same(own, {"tcp://a": dict(own)})
    for change, why in (
        ({"versions": own["versions"] | {"numpy": "1.0"}}, f"has numpy 1.0: must be {own['versions']['numpy']}, as here"),
        ({"code": "0" * 16}, f"sources of evcot differ ({'0' * 16})"),
        ({"design": "1" * 16}, "RTL differ"),
        ({"contents": {}}, "discs1.npz: is missing on worker tcp://b on "),
        ({"contents": dict.fromkeys(own["contents"], "2" * 16)}, "discs1.npz: differs from the one here on worker tcp://b"),
    ):
        with pytest.raises(ConfigError) as refused:
            machine.check_same(own, {"tcp://a": dict(own), "tcp://b": {**own, **change}})
        assert why in str(refused.value)


def test_a_grid_is_every_combination_with_the_last_axis_fastest() -> None:
    axes = [axis_from("cot.init_radix", [8, 10]), axis_from("rct.radius_px", {"from": 1.0, "to": 4.0, "steps": 3, "log": True})]
    points = list(grid(axes))
    assert [tuple(point.values()) for point in points] == [(8, 1.0), (8, 2.0), (8, 4.0), (10, 1.0), (10, 2.0), (10, 4.0)]


def test_a_grid_of_whole_numbers_has_each_once() -> None:
    assert axis_from("shape.n_slots", {"from": 1, "to": 3, "steps": 9}).grid() == (1, 2, 3)


def test_a_latin_hypercube_has_one_point_in_each_part() -> None:
    axes = [axis_from("rct.radius_px", {"from": 1.0, "to": 11.0}), axis_from("shape.n_slots", {"from": 1, "to": 10})]
    points = list(latin(axes, 10, 3))
    assert sorted(int(point["rct.radius_px"] - 1.0) for point in points) == list(range(10))
    assert sorted(point["shape.n_slots"] for point in points) == list(range(1, 11))
    assert points == list(latin(axes, 10, 3))
    assert points != list(latin(axes, 10, 4))


def test_random_points_begin_alike_however_many_there_are() -> None:
    axes = [axis_from("rct.radius_px", {"from": 1.0, "to": 100.0, "log": True}), axis_from("filters.polarity", ["on", "off"])]
    few, many = list(uniform(axes, 5, 1)), list(uniform(axes, 400, 1))
    assert many[:5] == few
    below = sum(point["rct.radius_px"] < 10 for point in many)
    assert 150 < below < 250, "half of them below the middle of a ratio"
    assert {point["filters.polarity"] for point in many} == {"on", "off"}
    assert all(1 <= point["rct.radius_px"] <= 100 for point in many)


def test_limits_of_whole_numbers_are_reached() -> None:
    axis = Axis("shape.n_slots", (), 1, 3)
    assert {axis.at(share / 100) for share in range(100)} == {1, 2, 3}
    assert (axis.at(0.0), axis.at(0.999999)) == (1, 3)


@pytest.mark.parametrize(
    ("name", "values", "why"),
    [
        ("cot.init_radii", [1], "fields.cot.init_radii: no such field: must be one of clust_nev, "),
        ("cut.init_radix", [1], "fields.cut.init_radix: no such field: must be preset, hardware, or TABLE.FIELD"),
        ("slot.init_radix", [1], "fields.slot.init_radix: no such field"),
        ("rct.radius_px", [], "fields.rct.radius_px = []: must have one value at least"),
        ("rct.radius_px", {"from": 5.0, "to": 5.0}, "fields.rct.radius_px: from 5.0 to 5.0: is empty"),
        ("rct.radius_px", {"from": 5.0, "to": 2000.0}, "fields.rct.radius_px: 2000.0: must be from 0.5 to 1000 "),
        ("cot.hist_avg", [3, 9], "fields.cot.hist_avg: 9: must be from 0 to 8 "),
        ("cot.hist_avg", [3.5], "fields.cot.hist_avg: 3.5: must be from 0 to 8 "),
        ("shape.n_slots", {"from": 0, "to": 4}, "fields.shape.n_slots: 0: must be from 1 to 64 "),
        ("filters.recent_radius", [True], "fields.filters.recent_radius: True: must be from 1 to 15 "),
        ("rct.alpha", {"from": 0.1, "upto": 0.2}, "fields.rct.alpha: unknown key 'upto'"),
        ("rct.alpha", {"from": 0.1, "to": "b"}, "fields.rct.alpha.to = 'b': must be a number"),
        ("rct.coast_us", {"from": 0, "to": 9, "log": True}, "fields.rct.coast_us: from 0: must be above 0 with log"),
        (
            "rct.alpha",
            {"from": 0.1, "to": 0.2, "steps": 1},
            "fields.rct.alpha.steps = 1: must be a whole number from 2 to ",
        ),
    ],
)
def test_what_cannot_be_is_refused(name: str, values: Any, why: str) -> None:
    with pytest.raises(ConfigError) as refused:
        axis_from(name, values)
    assert str(refused.value).startswith(why)


def test_a_range_without_steps_is_no_grid() -> None:
    with pytest.raises(ConfigError, match=r"fields.rct.alpha: a range without steps"):
        next(grid([axis_from("rct.alpha", {"from": 0.1, "to": 0.2})]))


def test_a_grid_has_its_limit() -> None:
    axes = [Axis(f"a{i}", tuple(range(100))) for i in range(4)]
    with pytest.raises(ConfigError, match="100,000,000 points: must be at most 200,000"):
        next(grid(axes))
